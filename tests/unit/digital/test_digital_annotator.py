"""What a person adds: clicks and strokes."""

import numpy as np
import pytest

from mammosim.core.errors import ConfigurationError, SegmentationError
from mammosim.core.labels import Label
from mammosim.core.rigid import IDENTITY
from mammosim.core.settings import read
from mammosim.core.volume import grid_around
from mammosim.digital.annotator import PAINTED, Painting, clicked, strokes
from mammosim.digital.body import AtRest
from mammosim.digital.signal import Scan, marker_centres, truth_labels

SCAN = Scan(
    echo_time_ms=70.0,
    repetition_time_ms=4500.0,
    adipose=1000.0,
    bias=0.1,
    noise=0.02,
    subsamples=1,
    marker_mm=7.0,
)


@pytest.fixture(scope="module")
def body(anatomies):
    return AtRest(anatomies["large"], IDENTITY)


@pytest.fixture(scope="module")
def truth(body):
    grid = grid_around(np.array([-160.0, -120.0, -24.0]), np.array([160.0, 72.0, 24.0]), 3.0)
    return truth_labels(body, grid, scan=SCAN)


def paint(truth, z_mm=(-10.0, 0.0, 10.0), stream=(1, "small")):
    return strokes(truth, Painting(tuple(z_mm), per_tissue=3, steps=10), stream=stream)


def test_every_stroke_stays_in_the_tissue_it_names(truth):
    table = paint(truth)
    voxels = np.round(truth.grid.indices(table[["x_mm", "y_mm", "z_mm"]].to_numpy())).astype(int)
    labels = truth.values[tuple(voxels.T)]
    assert [Label(label).tissue for label in labels] == list(table.tissue)


def test_every_tissue_is_painted_on_the_asked_slices(truth):
    table = paint(truth)
    assert set(table.tissue) == {label.tissue for label in PAINTED}
    assert table.z_mm.nunique() == 3
    assert len(table) > 100


def test_strokes_are_the_same_each_time(truth):
    assert paint(truth).equals(paint(truth))
    assert not paint(truth).equals(paint(truth, stream=(1, "large")))


def test_slices_without_breast_are_rejected(truth):
    air = truth.__class__(truth.grid, np.where(truth.values == Label.GLANDULAR, 1, truth.values))
    with pytest.raises(SegmentationError, match="glandular"):
        paint(air)


def test_clicks_miss_by_a_normal_error(body):
    exact = body.fiducials().points.copy()
    exact[:10] = marker_centres(body, SCAN)
    errors = np.concatenate(
        [clicked(body, scan=SCAN, error_mm=0.5, stream=(s,)).points - exact for s in range(8)]
    ).ravel()
    # n normal errors: their variance has relative standard error sqrt(2 / n).
    assert abs((errors**2).mean() / 0.25 - 1) < 4 * np.sqrt(2 / errors.size)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"z_mm": []}, "strokes: z_mm names no slice"),
        ({"steps": 0}, r"strokes: steps = 0 is outside \(0, inf\)"),
        ({"per_tissue": 2.5}, r"strokes\.per_tissue = 2\.5 is of type"),
        ({"z_mm": ["top"]}, r"strokes\.z_mm\[0\] = 'top' is of type"),
    ],
)
def test_settings_that_paint_nothing_are_rejected(change, words):
    with pytest.raises(ConfigurationError, match=words):
        read(Painting, {"z_mm": [0.0], "per_tissue": 3, "steps": 12} | change, "strokes")
