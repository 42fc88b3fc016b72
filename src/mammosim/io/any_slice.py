"""Any one slice of a folder of DICOM files, to look at where the series makes no volume."""

from pathlib import Path

import numpy as np
import pydicom

from mammosim.io.hidden import is_hidden


def any_slice(folder: str | Path) -> np.ndarray | None:
    """Stored values (n_row, n_column) of the decodable slice nearest the middle; None without one."""
    if not folder or not Path(folder).is_dir():
        return None
    place = Path(folder)
    files = [
        path for path in sorted(place.rglob("*")) if path.is_file() and not is_hidden(path.relative_to(place))
    ]
    for k in sorted(range(len(files)), key=lambda k: abs(k - len(files) // 2)):
        values = _decoded(files[k])
        if values is not None:
            return values
    return None


def _decoded(path: Path) -> np.ndarray | None:
    """The pixels of a file, None where there are none; whatever is wrong with it, it is only looked at."""
    try:
        values = pydicom.dcmread(path).pixel_array
    except Exception:
        return None
    return np.asarray(values, float) if values.ndim == 2 else None
