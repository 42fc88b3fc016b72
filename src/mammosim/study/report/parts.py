"""The sections of the page of one woman after a run: which figures and answers stand where, in words."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Answer:
    """How a table is shown: its caption, and column -> heading, whose end is its unit as in column names."""

    caption: str
    columns: Mapping[str, str]


@dataclass(frozen=True)
class Part:
    """A section to be: figures, beginning of a name -> caption; its answers by their tables."""

    title: str
    figures: Mapping[str, str]
    answers: Mapping[str, Answer] = field(default_factory=dict)


PARTS: tuple[Part, ...] = (
    Part(
        "Positions in one frame",
        {
            "registration": "{what} over the reference position: as scanned, registered, and what is left "
            "at the markers, or the limits of the error."
        },
        {
            "registration": Answer(
                "How her positions were brought into one frame, and how well they agree; error 95: what the "
                "error exceeds in 5 of 100 cases, where no markers tell it.",
                {
                    **{"position": "position", "step": "step", "used": "used", "method": "method"},
                    "marker_residual_mm": "left at markers, mean_mm",
                    "marker_residual_max_mm": "largest_mm",
                    **{"correlation": "correlation", "error_95_mm": "error 95_mm", "error_95_deg": "_deg"},
                },
            )
        },
    ),
    Part(
        "Tissues and mesh",
        {
            "segmentation": "Tissues of {what} over the image. Check them: all that follows is computed of "
            "these.",
            "mesh": "The mesh of {what}: skin, and a cut through the left nipple with the tissue of each "
            "element.",
            "morph": "Prone brought onto the shape of supine, and the mean of both.",
        },
    ),
    Part(
        "Shape without gravity",
        {
            "stress_free": "The breast as it was scanned, and as it would be without weight.",
            "true_stress_free": "Measured, estimated and true shape of a digital volunteer.",
        },
        {
            "stress_free_attempts": Answer(
                "What was tried, in its order; the last one is pressed. Largest error: distance of any node "
                "from the scanned shape, after loading again.",
                {
                    **{"method": "method", "moduli_factor": "moduli times"},
                    **{"adipose_kpa": "fat_kpa", "glandular_kpa": "gland_kpa", "skin_kpa": "skin_kpa"},
                    "largest_mm": "largest error_mm",
                },
            )
        },
    ),
    Part(
        "Stiffness of her tissues",
        {
            "identification": "How well each stiffness explains her positions, and what was found.",
            "fitted_shapes": "Her positions, and what the fitted stiffness predicts.",
        },
        {
            "identification": Answer(
                "Young's moduli fitted to her positions, with their 95 % intervals. A dash: her positions do "
                "not tell it.",
                {
                    **{"side": "side", "tissue": "tissue", "fitted_kpa": "fitted_kpa"},
                    **{"low_kpa": "from_kpa", "high_kpa": "to_kpa"},
                },
            )
        },
    ),
    Part(
        "Predicted against scanned positions",
        {"validation": "Predicted over scanned ({what}), and their distance on the skin."},
        {
            "validation": Answer(
                "Distances between prediction and scan; before: with the modelled position, unmoved, in the "
                "place of the prediction; published: of a real woman. A position that was fitted is no test; "
                "one that was not, is.",
                {
                    **{"position": "position", "fitted": "fitted", "quantity": "where"},
                    **{"value_mm": "predicted_mm", "before_mm": "before_mm", "published_mm": "published_mm"},
                },
            )
        },
    ),
    Part(
        "Compression",
        {
            "compression": "The {what} breast without load and between the plates, the strain on a cut, and "
            "the pressure of the upper plate on the skin.",
            "thickness": "Thickness under the paddle from above, {what} moduli; the chest is below.",
            "discomfort": "Strain, energy and pressure, {what} moduli: what is done to the tissue, not pain.",
        },
        {
            "compression": Answer(
                "Her breast between the plates. Moduli: gravity, of the size that fits under gravity find; "
                "compression, those that phantom programs assume between plates; times: by what all of a set "
                "were multiplied.",
                {
                    **{"side": "side", "strategy": "strategy", "moduli": "moduli", "moduli_factor": "times"},
                    **{"plates_mm": "plates apart_mm", "force_n": "force_n"},
                    "mean_pressure_kpa": "mean pressure_kpa",
                },
            )
        },
    ),
    Part(
        "Mammogram, dose, and what would show",
        {
            "phantom": "Slices through the compressed {what} breast.",
            "mammogram": "The mammogram of the {what} breast as it would be read; the lesion put in is "
            "circled.",
            "tomosynthesis": "Slices of tomosynthesis of the {what} breast, and how far the lesion shows "
            "above and below its own.",
        },
        {
            "image": Answer(
                "Exposure, mean glandular dose and its standard error, contrast to noise of the lesion in a "
                "pixel, and d' of the calcifications with 95 %: how many standard deviations lie between "
                "images with and without them.",
                {
                    **{"side": "side", "strategy": "strategy", "moduli": "moduli", "mas": "exposure_mas"},
                    **{"dose_mgy": "dose_mgy", "dose_se_mgy": "±_mgy"},
                    **{"cnr": "contrast to noise", "calcification_d": "d'"},
                    **{"calcification_d_low": "d' from", "calcification_d_high": "d' to"},
                },
            )
        },
    ),
)
