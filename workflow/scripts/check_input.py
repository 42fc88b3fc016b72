"""Reject images, labels, a fiducial list or strokes that cannot be used, before anything long runs."""

import logging
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field

import _log
import numpy as np
import pandas as pd

from mammosim.chain.labelled import chest_limits, nipples, outline_image, usable_labels
from mammosim.core.errors import FiducialError, ImageError, MammosimError, SegmentationError
from mammosim.core.fiducials import Fiducials
from mammosim.core.volume import Image, LabelMap
from mammosim.imaging.markers import chest_markers, require_four
from mammosim.imaging.plausible_points import require_plausible
from mammosim.imaging.plausible_strokes import require_painted
from mammosim.imaging.quality import image_quality, require_usable
from mammosim.io.fiducials import read_fiducials
from mammosim.io.images import read_labels
from mammosim.io.scans import read_scan
from mammosim.io.strokes import read_strokes
from mammosim.io.tables import write_table


@dataclass
class Seen:
    """What is given of a position, as far as it can be read, and every reason for which it cannot be used.

    images: by 'labels' and 'images', the outline of the labels and the image.
    """

    images: dict[str, Image] = field(default_factory=dict)
    labels: LabelMap | None = None
    listed: Fiducials | None = None
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


def main(
    files: dict[str, str],
    job: dict,
    gravity: np.ndarray,
    *,
    found: bool,
    registered: bool,
    sides: list[str],
    how: Mapping[str, str],
    out: str,
) -> None:
    about = {"found": found, "registered": registered, "sides": sides}
    seen = look(files, job["position"], gravity, how=how, **about)
    if seen.faults:
        raise type(seen.faults[0])("\n".join(map(str, seen.faults)))
    write_table(pd.DataFrame([job | image_quality(seen.image, position=job["position"])]), out)


def look(
    files: dict[str, str],
    position: str,
    gravity: np.ndarray,
    *,
    how: Mapping[str, str],
    found: bool,
    registered: bool,
    sides: list[str],
) -> Seen:
    """All that is given of a position, each part judged by itself. how: which series, and what of uneven gaps."""
    seen = Seen()
    if "labels" in files:
        with seen.judged():
            seen.labels = read_labels(files["labels"])
            seen.images["labels"] = outline_image(usable_labels(seen.labels, files["labels"]))
            usable(seen.images["labels"], files["labels"], position, gravity, None)
            if "listed" not in files and position == "prone":
                seen.listed = found_points(seen.labels, files["labels"])
    if "images" in files:
        with seen.judged():
            seen.images["images"], tag = imaged(files["images"], how)
            usable(seen.images["images"], files["images"], position, gravity, tag)
    if "listed" in files:
        with seen.judged():
            seen.listed = read_fiducials(files["listed"])
            if seen.image is not None:
                about = {"found": found, "registered": registered, "sides": sides}
                check_list(files["listed"], seen.listed, seen.image, **about)
    if "strokes" in files and "labels" not in files:  # given labels stand in the place of a segmentation
        with seen.judged():
            check_strokes(files["strokes"], seen.image)
    return seen


def usable(image: Image, path: str, position: str, gravity: np.ndarray, tag: str | None) -> None:
    """Raise ImageError, which names the file, for an image or an outline that cannot be used."""
    try:
        require_usable(image, position=position, gravity=gravity, patient_position=tag)
    except ImageError as error:
        raise ImageError(f"{path}: {error}") from None


def found_points(labels: LabelMap, path: str) -> Fiducials:
    """The nipples as later stages find them. Raises FiducialError where they, or the chest, are not found."""
    try:
        found = nipples(labels)
        chest_limits(labels, found)
    except FiducialError as error:
        raise FiducialError(f"{path}: {error}") from None
    return found


def imaged(path: str, how: Mapping[str, str]) -> tuple[Image, str | None]:
    """An image, and the PatientPosition tag of a series."""
    scan = read_scan(path, **how)
    for note in scan.notes:
        logging.info("%s: %s", path, note)
    return scan.image, scan.patient_position


def check_list(
    path: str, listed: Fiducials, image: Image, *, found: bool, registered: bool, sides: list[str]
) -> None:
    """Raise FiducialError for points that cannot be meant in the image, and for names that are needed.

    Those are the nipples of the sides, and four chest markers where positions are brought together by them.
    """
    try:
        listed.require(f"nipple_{side}" for side in sides)
        require_plausible(listed, image)
        if registered:
            listed = chest_markers(image, listed) if found else listed
            require_four(listed.of_kind("chest"))
    except FiducialError as error:
        raise FiducialError(f"{path} with its image: {error}") from None


def check_strokes(path: str, image: Image | None) -> None:
    """Raise SegmentationError for strokes that cannot be read, or cannot be meant in the image, if there is one."""
    strokes = read_strokes(path)
    try:
        if image is not None:
            require_painted(strokes, image)
    except SegmentationError as error:
        raise SegmentationError(f"{path}: {error}") from None


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        {name: path for name, path in snakemake.input.items() if path},
        {"volunteer": snakemake.wildcards.v, "position": snakemake.wildcards.p},
        np.array(snakemake.params.gravity.split(), float),
        found=snakemake.params.chest_markers == "found",
        registered=snakemake.params.registered,
        how=snakemake.params.how,
        sides=snakemake.params.sides,
        out=snakemake.output[0],
    )
