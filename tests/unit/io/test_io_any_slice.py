"""A slice to look at, of a series that makes no volume."""

import numpy as np

from mammosim.core.volume import Image, grid_around
from mammosim.io.any_slice import any_slice
from mammosim.io.dicom_writer import write_series


def test_the_decodable_slice_nearest_the_middle_is_taken(tmp_path):
    grid = grid_around(np.zeros(3), np.array([12.0, 10.0, 10.0]), 2.0)
    values = np.arange(5, dtype=np.float32)[:, None, None] * np.ones(grid.shape, np.float32)
    write_series(
        tmp_path,
        Image(grid, values),
        position="prone",
        volunteer="ada",
        echo_time_ms=70.0,
        repetition_time_ms=4500.0,
    )
    files = sorted(tmp_path.glob("*.dcm"))
    assert any_slice(tmp_path).shape == (5, 6)
    assert any_slice(tmp_path).max() == 2
    for name in ("._a.dcm", "._b.dcm", "Thumbs.db"):
        (tmp_path / name).write_bytes(files[4].read_bytes())
    assert any_slice(tmp_path).max() == 2
    files[2].write_bytes(files[2].read_bytes()[:50])
    assert any_slice(tmp_path).max() in (1, 3)


def test_where_there_is_nothing_to_see_there_is_none(tmp_path):
    (tmp_path / "notes.txt").write_text("no image")
    assert any_slice(tmp_path) is None
    assert any_slice(tmp_path / "none") is None
    assert any_slice("") is None
