"""Images and points that the study's own rules wrote: one that cannot be read is damaged, and no outcome."""

from pathlib import Path

from mammosim.core.errors import written
from mammosim.core.fiducials import Fiducials
from mammosim.core.volume import Image, LabelMap
from mammosim.io import fiducials, images


def read_image(path: str | Path) -> Image:
    """As `io.images.read_image`. Raises as `written`."""
    with written():
        return images.read_image(path)


def read_labels(path: str | Path) -> LabelMap:
    """As `io.images.read_labels`. Raises as `written`."""
    with written():
        return images.read_labels(path)


def read_fiducials(path: str | Path) -> Fiducials:
    """As `io.fiducials.read_fiducials`. Raises as `written`."""
    with written():
        return fiducials.read_fiducials(path)
