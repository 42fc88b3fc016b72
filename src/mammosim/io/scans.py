"""The scan of one position, whatever it comes as."""

from pathlib import Path

from mammosim.core.errors import ImageError
from mammosim.io.dicom import Series, is_series, read_series
from mammosim.io.images import read_image


def read_scan(path: str | Path, *, series: str = "", gaps: str = "") -> Series:
    """A DICOM series by `read_series`, with its `series` and `gaps`, or an image file by `read_image`.

    Raises ImageError as these do, where the path cannot be opened, and where a series of an image file is
    named.
    """
    try:
        if is_series(path):
            return read_series(path, series=series, gaps=gaps)
    except OSError as error:
        raise ImageError(
            f"{path} cannot be read: {error.strerror}; see to its permissions and disk"
        ) from None
    if series or gaps:
        raise ImageError(
            f"{path} is an image file: series and gaps are of DICOM alone; leave both columns empty"
        )
    return Series(read_image(path), None, None, None)
