"""T2-weighted rendering: contrast, partial volume, noise, markers, reproducibility."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
import yaml

from mammosim.core.errors import ConfigurationError
from mammosim.core.fiducials import Fiducials
from mammosim.core.labels import Label
from mammosim.core.rigid import IDENTITY, RigidTransform, rotation
from mammosim.core.settings import read
from mammosim.core.volume import Grid, grid_around
from mammosim.digital import signal
from mammosim.digital.body import AtRest
from mammosim.digital.signal import Scan, ScanSettings, finer, marker_centres, render, signals, truth_labels

SCAN = Scan(
    echo_time_ms=70.0,
    repetition_time_ms=4500.0,
    adipose=1000.0,
    bias=0.1,
    noise=0.02,
    subsamples=2,
    marker_mm=7.0,
)
CLEAN = replace(SCAN, bias=0.0, noise=0.0)


@dataclass(frozen=True)
class Uniform:
    """A body of one material without markers."""

    material: int

    def materials(self, grid: Grid) -> np.ndarray:
        return np.full(grid.shape, self.material, np.uint8)

    def fiducials(self) -> Fiducials:
        return Fiducials((), (), np.empty((0, 3)))

    def normals(self) -> np.ndarray:
        return np.empty((0, 3))


@pytest.fixture(scope="module")
def body(anatomies):
    return AtRest(
        anatomies["large"], RigidTransform(rotation(np.array([2.0, -1.0, 3.0])), np.array([3.0, -2, 5]))
    )


def scene(spacing):
    return grid_around(np.array([-160.0, -136.0, -40.0]), np.array([160.0, 72.0, 40.0]), spacing)


@pytest.mark.parametrize("material", [Label.AIR, Label.GLANDULAR, Label.ADIPOSE])
def test_noise_of_a_uniform_phantom_is_rician(material):
    # <M^2> = S^2 + 2 sigma^2, var(M^2) = 4 S^2 sigma^2 + 4 sigma^4.
    S, sigma = signals(SCAN)[material], SCAN.noise * SCAN.adipose
    image = render(Uniform(material), scene(4.0), scan=replace(SCAN, bias=0.0), stream=(1, "uniform"))
    squares = image.values.astype(float) ** 2
    standard_error = np.sqrt((4 * S**2 * sigma**2 + 4 * sigma**4) / squares.size)
    assert abs(squares.mean() - (S**2 + 2 * sigma**2)) < 4 * standard_error


def test_fat_is_brighter_than_gland_than_muscle_than_skin_than_air_and_markers_are_brightest():
    order = [Label.MARKER, Label.ADIPOSE, Label.GLANDULAR, Label.MUSCLE, Label.SKIN, Label.AIR]
    intensities = signals(SCAN)[order]
    assert (np.diff(intensities) < 0).all()
    assert intensities[1] == pytest.approx(SCAN.adipose)
    assert intensities[-1] == 0


def test_a_longer_echo_darkens_gland_against_fat():
    later = replace(SCAN, echo_time_ms=100.0)
    assert signals(later)[Label.GLANDULAR] < signals(SCAN)[Label.GLANDULAR]


def test_partial_volume_conserves_the_mean_signal(body):
    coarse = render(body, scene(8.0), scan=CLEAN, stream=(1,)).values
    fine = render(body, finer(scene(8.0), 2), scan=replace(CLEAN, subsamples=1), stream=(1,)).values
    # The same sub-samples: equal up to the rounding of single precision.
    np.testing.assert_allclose(coarse.mean(dtype=float), fine.mean(dtype=float), rtol=1e-6)
    assert len(np.unique(coarse)) > len(np.unique(fine)), "boundaries show intermediate intensities"


def test_an_image_does_not_depend_on_how_many_slices_are_drawn_at_once(body, monkeypatch):
    whole = render(body, scene(8.0), scan=SCAN, stream=(1, "prone"))
    monkeypatch.setattr(signal, "SAMPLES_AT_ONCE", 1)
    single = render(body, scene(8.0), scan=SCAN, stream=(1, "prone"))
    assert whole.values.tobytes() == single.values.tobytes()


def test_the_same_stream_gives_the_same_bytes_and_another_stream_other_noise(body):
    one, same, other = (
        render(body, scene(10.0), scan=SCAN, stream=(1, name)) for name in ("prone", "prone", "supine")
    )
    assert one.values.tobytes() == same.values.tobytes()
    assert (one.values != other.values).any()


def test_markers_are_balls_that_touch_the_skin_from_outside(body):
    ball = marker_centres(body, SCAN)[4]
    around = grid_around(ball - 6, ball + 6, 0.25)
    labels = truth_labels(body, around, scan=SCAN)
    marker = labels.grid.points(np.argwhere(labels.values == Label.MARKER).astype(float))
    # A ball of n voxels is counted to about the surface's share of half a voxel: 0.5 %.
    assert len(marker) * labels.grid.voxel_volume == pytest.approx(np.pi / 6 * 7.0**3, rel=0.01)
    np.testing.assert_allclose(marker.mean(axis=0), ball, atol=0.02)
    skin = body.fiducials().points[4]
    assert np.linalg.norm(skin - ball) == pytest.approx(SCAN.marker_mm / 2, abs=1e-6)


def test_truth_is_the_label_at_the_voxels_centre(body, anatomies):
    grid = scene(8.0)
    truth = truth_labels(body, grid, scan=SCAN).values.ravel()
    labels = anatomies["large"].labels_at(body.moved.inverse()(grid.centres()))
    differs = truth != labels
    assert (truth[differs] == Label.MARKER).all()


def test_full_resolution_is_drawn_slab_by_slab(anatomies):
    body = AtRest(anatomies["small"], IDENTITY)
    grid = grid_around(np.array([60.0, -100, -1.2]), np.array([100.0, -40, 1.2]), np.array([0.5, 0.5, 0.6]))
    image = render(body, grid, scan=SCAN, stream=(1,))
    assert image.values.shape == (4, 120, 80)
    assert image.values.max() > 0.8 * SCAN.adipose


@pytest.mark.parametrize(
    ("name", "value"), [("bias", 15.0), ("noise", -0.1), ("subsamples", 0), ("marker_mm", 0)]
)
def test_an_impossible_scan_is_rejected_by_name(name, value):
    with pytest.raises(ConfigurationError, match=name):
        replace(SCAN, **{name: value})


@pytest.fixture
def configured(repository):
    return yaml.safe_load((repository / "config/default.yaml").read_text())["digital"]["scan"]


def test_a_configured_scan_has_its_voxels_and_its_shares(configured):
    settings = read(ScanSettings, configured, "scan")
    assert settings.scan.noise == configured["noise_percent"] / 100
    low, high = settings.grid.points(np.array([[-0.5] * 3, np.array(settings.grid.shape) - 0.5]))
    np.testing.assert_allclose((low[0], high[0]), configured["field_of_view_mm"]["x"])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"spacing_mm": [2.0, 2.0]}, r"scan\.spacing_mm has 2 values; write 3"),
        ({"spacing_mm": [2.0, 0.0, 2.0]}, r"scan: spacing_mm .* must be above 0"),
        (
            {"field_of_view_mm": {"x": [-1, 1], "y": [5, -5], "z": [0, 1]}},
            "y from 5 to -5 mm: give the lowest",
        ),
        ({"subvoxels": 2.0}, r"scan\.subvoxels = 2\.0 is of type"),
        ({"fat": 600.0}, r"has no key 'fat'"),
    ],
)
def test_a_scan_that_cannot_be_configured_is_rejected(configured, change, words):
    with pytest.raises(ConfigurationError, match=words):
        read(ScanSettings, configured | change, "scan")
