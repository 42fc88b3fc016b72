"""The table of the stages, from image to answer: what each needs, reads, may have, and where it is kept.

Wildcards of the paths: v, the volunteer; p, the position that the model is made of, and reference, that whose
frame is common; position, that of a load; side; method, of the stress-free shape; strategy and moduli, of a
compression; strokes, listed and given_labels, the files that a person drew; also, empty for what the study
asks for by itself, else a dash and eight digits that tell a variant (results/variants.tsv).
"""

from collections.abc import Iterable, Mapping

from mammosim.chain.conditions import (
    begins_with_mean,
    finds_markers,
    is_labelled,
    is_marked,
    is_moved,
    is_painted,
    is_scattered,
    is_segmented,
    is_unmarked,
    uses_standard,
)
from mammosim.chain.graph import Files, Need, Stage

REGISTERED = "results/registration/{v}/{p}"
PRESSED = "{v}/{side}/{strategy}_{moduli}{also}"
MATERIAL = ("gland", "muscle", "skin", "fascia", "ligaments")
PLATES = ("weight", "friction")
BEAM = ("polychromatic", "paddle")
# In the order in which they act on an image.
IMAGE = ("scatter", "response", "heel", "focal_spot", "grid", "quantum_noise", "blur", "structure",
         "electronic_noise")  # fmt: skip


def _in(group: str, *names: str) -> tuple[str, ...]:
    return tuple(f"{group}.{name}" for name in names)


TUBE = _in("xray", "anode", "filter", "filter_um", "peak_kv")
GEOMETRY = _in("xray", "source_to_detector_mm", "support_to_detector_mm", "pixel_mm", "field_mm")
DETECTOR = _in("xray", "detector", "focal_spot_mm", "grid", "structure_percent")
SCATTER = _in("xray", "scatter_error_percent", "scatter_pixel_mm")
FIBRES = _in("effects", "fascia", "ligaments")

MEASURED: Mapping[str, Stage] = {
    "scan": Stage("images.scan", files=Files("results/images/{v}/{p}", {"scan": ".nii.gz"})),
    "strokes": Stage("images.strokes", files=Files("{strokes}", {"strokes": ""})),
    "listed": Stage("images.listed", files=Files("{listed}", {"fiducials": ""})),
    "given_labels": Stage("images.given_labels", files=Files("{given_labels}", {"labels": ""})),
    "reference_scan": Stage(
        "images.scan", files=Files("results/images/{v}/{reference}", {"scan": ".nii.gz"})
    ),
    "reference_fiducials": Stage(
        "images.reference_fiducials", files=Files("results/fiducials/{v}/{reference}", {"fiducials": ".csv"})
    ),
    "reference_mesh": Stage(
        "meshed.reference_mesh", files=Files("results/meshes/{v}/{reference}", {"mesh": ".vtu"})
    ),
}
LABELLED: Mapping[str, Stage] = {
    "fiducials": Stage(
        "images.fiducials",
        (Need("scan", finds_markers), Need("listed", is_marked), Need("labels", is_unmarked)),
        ("registration.chest_markers",),
        files=Files("results/fiducials/{v}/{p}", {"fiducials": ".csv"}, beside={"markups": ".mrk.json"}),
    ),
    "registration": Stage(
        "images.registration",
        ("scan", "fiducials", Need("reference_scan", is_moved), Need("reference_fiducials", is_moved)),
        _in("registration", "voxel_mm", "smoothing_mm", "iterations", "samples"),
    ),
    "transform": Stage(
        "images.transform",
        ("registration",),
        files=Files(REGISTERED, {"transform": ".tfm"}, beside={"steps": "_steps.csv"}),
    ),
    "moved_scan": Stage(
        "images.moved_scan",
        ("scan", "reference_scan", "transform"),
        files=Files(REGISTERED, {"scan": ".nii.gz"}),
    ),
    "moved_fiducials": Stage(
        "images.moved_fiducials",
        ("fiducials", "transform"),
        files=Files(REGISTERED, {"fiducials": "_fiducials.csv"}, beside={"markups": "_fiducials.mrk.json"}),
    ),
    "segmentation": Stage(
        "images.segmentation",
        ("scan", Need("strokes", is_painted)),
        _in("segmentation", "classifier", "trees", "voxel_mm", "neighbourhood_mm", "smoothing"),
    ),
    "taken_labels": Stage(
        "images.taken_labels", ("given_labels",), _in("labels", "codes", "glandularity_percent")
    ),
    "labels": Stage(
        "images.labels",
        (Need("segmentation", is_segmented), Need("taken_labels", is_labelled)),
        files=Files("results/segmentation/{v}/{p}", {"labels": ".nii.gz"}),
    ),
    "gland_probability": Stage(
        "images.gland_probability",
        ("segmentation",),
        files=Files("results/segmentation/{v}/{p}_glandular", {"probability": ".nii.gz"}),
    ),
    "breast": Stage("images.breast", (Need("transform", is_moved), "labels", "fiducials")),
}
MECHANICS: Mapping[str, Stage] = {
    "mesh": Stage(
        "meshed.mesh",
        ("breast",),
        ("mesh",),
        files=Files("results/meshes/{v}/{p}{also}", {"mesh": ".vtu"}, beside={"quality": "_quality.csv"}),
    ),
    "body": Stage("unloaded.body", (), ("tissues", *FIBRES), MATERIAL),
    "loaded_body": Stage("unloaded.loaded_body", ("stress_free",), ("tissues", *FIBRES), MATERIAL),
    "pressed_body": Stage(
        "unloaded.pressed_body", ("stress_free",), (*_in("load", "moduli", "tissues"), *FIBRES), MATERIAL
    ),
    "mean_shape": Stage(
        "unloaded.mean_shape",
        ("mesh", "reference_mesh"),
        ("morph",),
        files=Files(
            "results/morph/{v}/mean_start{also}",
            {"mesh": ".vtu"},
            beside={"morphed": "_morphed.vtu", "history": "_history.csv"},
        ),
    ),
    "unloaded": Stage(
        "unloaded.unloaded",
        ("breast", "mesh", "body", Need("mean_shape", begins_with_mean)),
        _in("mechanics.stress_free", "default", "start", "iterations", "tolerance_mm"),
        files=Files(
            "results/mechanics/{v}/stress_free/{p}_{method}{also}",
            {"shape": ".vtu"},
            beside={"history": ".csv"},
        ),
    ),
    "stress_free": Stage(
        "stress_free.stress_free",
        ("breast", "mesh", "body", "unloaded"),
        _in("mechanics.stress_free", "default", "fallback", "moduli_factors", "iterations", "tolerance_mm"),
        files=Files("results/mechanics/{v}/stress_free/{p}{also}", {"shape": ".vtu", "attempts": ".csv"}),
    ),
    "loaded": Stage(
        "unloaded.loaded",
        ("loaded_body", "stress_free"),
        ("mechanics.newton_tolerance", "load.position"),
        files=Files("results/mechanics/{v}/loaded/{position}{also}", {"shape": ".vtu"}),
    ),
    "press_setup": Stage(
        "press.press_setup",
        ("breast", "mesh", "stress_free", "pressed_body"),
        (
            *_in("compression", "plate_mm", "chest_gap_mm", "depth_share", "smallest_mm", "steps"),
            "compression.penetration_mm",
            "effects.friction",
            *_in("load", "thickness_mm", "moduli"),
        ),
        PLATES,
    ),
    "standard_path": Stage(
        "press.standard_path",
        ("press_setup",),
        files=Files(
            "results/compression/{v}/{side}/load_path_{moduli}{also}", {"shapes": ".vtu", "path": ".csv"}
        ),
    ),
    "pressed": Stage(
        "press.pressed",
        ("press_setup", Need("standard_path", uses_standard)),
        ("load.strategy", "compression.thresholds"),
        ("friction",),
        Files(
            f"results/compression/{PRESSED}",
            {"shape": ".vtu", "row": ".csv", "plates": "_plates.json"},
            beside={name: f"_{name}.csv" for name in ("path", "faces", "amounts", "thickness")},
        ),
    ),
}
XRAY: Mapping[str, Stage] = {
    "healthy_phantom": Stage(
        "voxels.healthy_phantom",
        ("breast", "mesh", "pressed"),
        ("xray.voxel_mm", "tissues.skin.thickness_mm"),
    ),
    "phantom": Stage(
        "voxels.phantom",
        ("breast", "mesh", "pressed", "healthy_phantom"),
        ("xray.lesion",),
        files=Files(f"results/phantom/{PRESSED}", {"labels": ".nii.gz"}),
    ),
    "conservation": Stage(
        "voxels.conservation",
        ("breast", "mesh", "pressed", "healthy_phantom"),
        ("tissues.tissues",),
        files=Files(f"results/phantom/{PRESSED}", {"rows": "_conservation.csv"}),
    ),
    "field": Stage(
        "beam.field",
        ("pressed", "phantom"),
        (*GEOMETRY, "xray.tomosynthesis.system", "xray.tomosynthesis.pixel_mm"),
        files=Files(f"results/xray/{PRESSED}", {"rows": "_field.csv"}),
    ),
    "spectrum": Stage(
        "beam.spectrum",
        (),
        (*TUBE, "xray.paddle", "xray.energies"),
        BEAM,
        Files("results/xray/spectrum{also}", {"table": ".csv", "facts": ".json"}),
    ),
    "geometry": Stage("beam.geometry", ("pressed", "phantom", "field"), GEOMETRY),
    "exposure": Stage("beam.exposure", ("phantom", "geometry", "spectrum"), ("xray.detector_kerma_ugy",)),
    "dose": Stage(
        "photons.dose",
        ("phantom", "geometry", "spectrum"),
        ("xray.dose_error_percent",),
        files=Files(f"results/xray/{PRESSED}", {"rows": "_dose.csv"}),
    ),
    "exposed_dose": Stage("photons.exposed_dose", ("dose", "exposure")),
    "scatter": Stage(
        "photons.scatter",
        ("phantom", "geometry", "spectrum"),
        SCATTER,
        files=Files(f"results/xray/{PRESSED}", {"cells": "_scatter.csv"}),
    ),
    "mammogram": Stage(
        "seen.mammogram",
        ("pressed", "phantom", "geometry", "spectrum", "exposure", Need("scatter", is_scattered)),
        (*DETECTOR, *TUBE, *_in("xray", "support_to_detector_mm", "calcifications", "rays_per_pixel")),
        IMAGE,
        Files(f"results/xray/{PRESSED}_mammogram", {"row": ".csv"}, beside={"image": ".nii.gz"}),
    ),
    "image_row": Stage(
        "seen.image_row",
        ("mammogram", "dose"),
        files=Files(f"results/xray/{PRESSED}", {"row": "_image.csv"}),
    ),
    "views": Stage(
        "seen.views",
        ("pressed", "phantom", "field", "spectrum", "exposure"),
        (*DETECTOR, *TUBE, *SCATTER, "xray.tomosynthesis"),
        IMAGE,
    ),
    "slices": Stage(
        "seen.slices",
        ("views",),
        ("xray.tomosynthesis",),
        files=Files(
            f"results/xray/{PRESSED}",
            {"rows": "_slices.csv"},
            beside={"filtered_backprojection": "_fbp.nii.gz", "sart": "_sart.nii.gz"},
        ),
    ),
    "depth": Stage(
        "seen.depth",
        ("phantom", "views"),
        ("xray.tomosynthesis",),
        files=Files(f"results/xray/{PRESSED}", {"profiles": "_depth.csv"}),
    ),
    "dose_routes": Stage(
        "photons.dose_routes",
        ("pressed", "phantom", "spectrum", "dose"),
        _in("xray", "anode", "filter", "dose_error_percent"),
        files=Files(f"results/xray/{PRESSED}", {"rows": "_routes.csv"}),
    ),
}
STAGES: Mapping[str, Stage] = {**MEASURED, **LABELLED, **MECHANICS, **XRAY}


def effects_on(products: Iterable[str]) -> frozenset[str]:
    """Every effect that one of these products may have."""
    return frozenset(effect for name in products for effect in STAGES[name].effects)
