"""Reject images, labels, a fiducial list or strokes that cannot be used, before anything long runs."""

import logging
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field

import _log
import numpy as np
import pandas as pd

from mammosim.chain.given_labels import LabelSettings, prepared
from mammosim.chain.labelled import chest_limits, nipples, outline_image
from mammosim.chain.meshed import ElementEdges
from mammosim.core.errors import FiducialError, ImageError, MammosimError, SegmentationError
from mammosim.core.fiducials import Fiducials
from mammosim.core.settings import read
from mammosim.core.units import MM3_PER_CM3
from mammosim.core.volume import Image, LabelMap
from mammosim.imaging.markers import worn_on_chest
from mammosim.imaging.plausible_labels import require_drawn_in
from mammosim.imaging.plausible_points import require_plausible
from mammosim.imaging.plausible_strokes import require_painted
from mammosim.imaging.quality import image_quality, require_intensities, require_usable, shows_one_breast
from mammosim.io.dicom import Series
from mammosim.io.fiducials import read_fiducials
from mammosim.io.label_maps import CodedMap, read_label_map
from mammosim.io.scans import read_scan
from mammosim.io.strokes import read_strokes
from mammosim.io.tables import write_table
from mammosim.meshing.body import thin_volume

# ASSUME: less than 1 cm3 that no element resolves need not be said.
LEAST_THIN_CM3 = 1.0


@dataclass(frozen=True)
class Asked:
    """What is asked of the data of a position, and how they are read.

    found: chest markers are looked for in the image; registered: positions are brought together by them;
    sides: whose nipples are needed; how: which series it is, and what of uneven gaps; taken: makes tissues
    of codes, and says what was mended.
    """

    found: bool
    registered: bool
    sides: list[str]
    how: Mapping[str, str]
    taken: Callable[[CodedMap], tuple[LabelMap, list[str]]]


@dataclass
class Seen:
    """What is given of a position, as far as it can be read, and every reason for which it cannot be used.

    images: by 'labels' and 'images', the outline of the labels and the image; coded: the labels as they are
    stored, scan: the series; notes: what was mended, or left out, of what is given.
    """

    images: dict[str, Image] = field(default_factory=dict)
    coded: CodedMap | None = None
    scan: Series | None = None
    labels: LabelMap | None = None
    listed: Fiducials | None = None
    notes: list[str] = field(default_factory=list)
    faults: list[MammosimError] = field(default_factory=list)

    @contextmanager
    def judged(self) -> Iterator[None]:
        """What is rejected inside is one of the faults, and the next thing is looked at."""
        try:
            yield
        except MammosimError as error:
            self.faults.append(error)

    @property
    def image(self) -> Image | None:
        """What shows most of the position: an image tells more than the outline of labels."""
        return self.images.get("images", self.images.get("labels"))


def main(files: dict[str, str], job: dict, gravity: np.ndarray, asked: Asked, out: str) -> None:
    seen = look(files, job["position"], gravity, asked)
    if seen.faults:
        raise type(seen.faults[0])("\n".join(map(str, seen.faults)))
    quality = image_quality(seen.image, position=job["position"]) | {"notes": "; ".join(seen.notes)}
    write_table(pd.DataFrame([job | quality]), out)


def look(files: dict[str, str], position: str, gravity: np.ndarray, asked: Asked) -> Seen:
    """All that is given of a position, each part judged by itself."""
    seen = Seen()
    if "labels" in files:
        with seen.judged():
            coded = read_label_map(files["labels"])
            seen.coded = coded
            seen.labels, notes = asked.taken(coded)
            seen.notes += notes
            seen.images["labels"] = outline_image(seen.labels)
            usable(seen.images["labels"], files["labels"], position, gravity, None)
            if "listed" not in files and position == "prone":
                seen.listed = found_points(seen.labels, files["labels"], asked.sides)
    if "images" in files:
        with seen.judged():
            scan = seen.scan = read_scan(files["images"], **asked.how)
            seen.notes += scan.notes
            seen.images["images"] = scan.image
            intense(scan.image, files["images"])
            usable(scan.image, files["images"], position, gravity, scan.patient_position)
            alone = not {"labels", "listed"} & set(files)  # else the nipples tell, which are needed
            if alone and len(asked.sides) > 1 and shows_one_breast(scan.image):
                seen.notes.append("one breast is shown and both are asked for: name it in compression.sides")
            if seen.labels is not None:
                check_together(seen.labels, scan.image, files)
    if "listed" in files:
        with seen.judged():
            seen.listed = read_fiducials(files["listed"])
            if seen.image is not None:
                check_list(files["listed"], seen.listed, seen.image, asked)
    if "strokes" in files and "labels" not in files:  # given labels stand in the place of a segmentation
        with seen.judged():
            check_strokes(files["strokes"], seen.image)
    for note in seen.notes:
        logging.info(
            "%s: %s", " and ".join(files[kind] for kind in ("labels", "images") if kind in files), note
        )
    return seen


def taken_by(settings: dict, element_mm: dict) -> Callable[[CodedMap], tuple[LabelMap, list[str]]]:
    """What makes tissues of codes, and says what was mended."""

    def taken(coded: CodedMap) -> tuple[LabelMap, list[str]]:
        found = prepared(coded, read(LabelSettings, settings, "labels"))
        thin = thin_volume(found.labels, read(ElementEdges, element_mm, "mesh.element_mm").size) / MM3_PER_CM3
        more = [f"{thin:.0f} cm3 are thinner than half an element"] if thin >= LEAST_THIN_CM3 else []
        return found.labels, [*found.notes, *more]

    return taken


def usable(image: Image, path: str, position: str, gravity: np.ndarray, tag: str | None) -> None:
    """Raise ImageError, which names the file, for an image or an outline that cannot be used."""
    try:
        require_usable(image, position=position, gravity=gravity, patient_position=tag)
    except ImageError as error:
        raise ImageError(f"{path}: {error}") from None


def intense(image: Image, path: str) -> None:
    """Raise ImageError, which names the file, for labels in the place of an image."""
    try:
        require_intensities(image)
    except ImageError as error:
        raise ImageError(f"{path}: {error}") from None


def check_together(labels: LabelMap, image: Image, files: dict[str, str]) -> None:
    """Raise ImageError where the labels are not of the image that is given beside them."""
    try:
        require_drawn_in(labels, image)
    except ImageError as error:
        raise ImageError(f"{files['labels']} with {files['images']}: {error}") from None


def found_points(labels: LabelMap, path: str, sides: list[str]) -> Fiducials:
    """The nipples as later stages find them. Raises FiducialError where one, or the chest, is not found."""
    try:
        found = nipples(labels)
        chest_limits(labels, found)
    except FiducialError as error:
        raise FiducialError(f"{path}: {error}") from None
    there = [side for side in sides if f"nipple_{side}" in found.names]
    if there != list(sides):
        only = " and ".join(name.removeprefix("nipple_") for name in found.names)
        raise FiducialError(
            f"{path} holds the {only} breast alone, and {' and '.join(sides)} are asked for; set "
            f"compression.sides: [{only}], or label both breasts"
        )
    return found


def check_list(path: str, listed: Fiducials, image: Image, asked: Asked) -> None:
    """Raise FiducialError for points that cannot be meant in the image, and for names that are needed.

    Those are the nipples of the sides, and four chest markers where positions are brought together and some
    are listed.
    """
    try:
        _require_nipples(listed, asked.sides)
        require_plausible(listed, image)
        if asked.registered:
            worn_on_chest(listed, image if asked.found else None)
    except FiducialError as error:
        raise FiducialError(f"{path} with its image: {error}") from None


def _require_nipples(listed: Fiducials, sides: list[str]) -> None:
    """Raise FiducialError where the nipple of a side is not listed."""
    if absent := [side for side in sides if f"nipple_{side}" not in listed.names]:
        names = " and ".join(f"nipple_{side}" for side in absent)
        left = [side for side in sides if side not in absent]
        without = f", or set compression.sides: [{left[0]}] where there is no other breast" if left else ""
        missing = "is missing; mark it" if len(absent) == 1 else "are missing; mark them"
        raise FiducialError(f"{names} {missing}{without}")


def check_strokes(path: str, image: Image | None) -> None:
    """Raise SegmentationError for strokes that cannot be read, or cannot be meant in the image."""
    strokes = read_strokes(path)
    try:
        if image is not None:
            require_painted(strokes, image)
    except SegmentationError as error:
        raise SegmentationError(f"{path}: {error}") from None


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        {name: path for name, path in snakemake.input.items() if path and name != "codes"},
        {"volunteer": snakemake.wildcards.v, "position": snakemake.wildcards.p},
        np.array(snakemake.params.gravity.split(), float),
        Asked(
            found=snakemake.params.chest_markers == "found",
            registered=snakemake.params.registered,
            sides=snakemake.params.sides,
            how=snakemake.params.how,
            taken=taken_by(snakemake.params.labels, snakemake.params.element_mm),
        ),
        out=snakemake.output[0],
    )
