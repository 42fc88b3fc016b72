from dataclasses import replace

import numpy as np
import pytest
from small_breast import small_chain

from mammosim.chain.calcifications import SearchSettings
from mammosim.chain.image_chain import Acquisition, Equipment, ImageChain, Tube
from mammosim.chain.mammogram import (
    View,
    dose_in,
    scatter_behind,
    scatter_cells,
    scatter_from,
    shot_of,
    tissue_materials,
    xray_phantom,
)
from mammosim.chain.phantom import healthy
from mammosim.chain.photons import ExposedDose
from mammosim.chain.tomosynthesis import ScanSettings
from mammosim.core.errors import ConfigurationError, XrayError
from mammosim.core.labels import Label
from mammosim.core.rng import generator
from mammosim.core.settings import read
from mammosim.core.volume import LabelMap, grid_around
from mammosim.xray.dose import GlandularDose
from mammosim.xray.spectrum import monoenergetic
from mammosim.xray.views import mammography_geometry

SPECTRUM = monoenergetic(20.0, fluence=1e5)
MAS = 50.0
TUBE = Tube("W", "Rh", 50.0, 28.0)
EQUIPMENT = Equipment(TUBE, "selenium", 0.3, "siemens_prototype", 0.5)


@pytest.fixture(scope="module")
def breast():
    """A half cylinder of fat, 30 mm thick, with a core of gland and a lesion of 10 mm in it."""
    grid = grid_around(np.array([-50.0, -50, 0]), np.array([50.0, 0, 30]), 2.0)
    p = grid.centres().reshape(*grid.shape, 3)
    r = np.hypot(p[..., 0], p[..., 1])
    values = np.zeros(grid.shape, np.uint8)
    values[r < 45] = Label.ADIPOSE
    values[r < 25] = Label.GLANDULAR
    values[np.linalg.norm(p - [0, -14, 15], axis=-1) < 5] = Label.LESION
    return LabelMap(grid, values)


def geometry(labels, pixel_mm):
    return mammography_geometry(
        xray_phantom(labels), chest_wall_y_mm=0.0, field_mm=(80.0, 120.0), pixel_mm=pixel_mm
    )


def view(labels, scatter=None):
    acquisition = Acquisition(geometry(labels, 1.0), 30.0, EQUIPMENT)
    return View(acquisition, SPECTRUM, ("quantum_noise",), scatter)


def shot(labels, mas, stream, scatter=None):
    return shot_of(labels, view(labels, scatter), mas=mas, rng=generator(stream))


def test_every_tissue_that_can_be_in_the_breast_has_a_material():
    needed = {Label.AIR, Label.ADIPOSE, Label.GLANDULAR, Label.SKIN, Label.MUSCLE, Label.LESION}
    assert needed <= set(tissue_materials())


def test_the_exposure_of_a_breast_is_that_without_its_lesion(breast, repository):
    """A lesion is denser than gland: looked through, it would take some percent more."""

    def exposure(labels):
        given = {"phantom": labels, "geometry": geometry(labels, 2.0), "spectrum": SPECTRUM}
        return small_chain(repository).given(given)["exposure"]

    assert exposure(breast) == pytest.approx(exposure(healthy(breast)), rel=1e-12)


def test_dose_and_its_error_grow_with_the_exposure(repository):
    dose = GlandularDose(0.02, 0.001, 0.1, 300.0)
    found = small_chain(repository).given({"dose": dose, "exposure": 70.0})["exposed_dose"]
    assert found == ExposedDose(pytest.approx(1.4), pytest.approx(0.07))


def test_the_lesion_darkens_its_own_shadow_and_nothing_else(breast):
    seen = shot(breast, MAS, 2)
    assert 0 < seen.row["contrast_percent"] < 10
    assert not np.any(seen.lesion & seen.ring)
    # At least half the thickness lies behind 3/4 pi r^2; a ball of 81 voxels of 2 mm is that rough.
    assert seen.row["lesion_pixels"] == pytest.approx(0.75 * np.pi * 25, rel=0.35)


def test_an_image_nears_that_of_many_rays_as_one_over_their_number(breast):
    # A voxel's edge crosses a pixel: of n rays and axis, 1/n are on the wrong side.
    images = {
        rays: shot_of(breast, replace(view(breast), rays=rays), mas=MAS, rng=generator(4)).exposure.mean
        for rays in (1, 4, 12)
    }
    one, four = (np.sqrt(np.mean((images[rays] - images[12]) ** 2)) for rays in (1, 4))
    assert 0 < four < one / 2


def test_quantum_noise_falls_as_one_over_the_root_of_the_exposure(breast):
    low, high = (shot(breast, mas, 3).row for mas in (MAS, 4 * MAS))
    assert high["snr"] / low["snr"] == pytest.approx(2, rel=1e-6)
    assert high["cnr_quantum"] / low["cnr_quantum"] == pytest.approx(2, rel=1e-6)


def test_the_same_stream_gives_the_same_image(breast):
    a, b = (shot(breast, MAS, "image") for _ in range(2))
    np.testing.assert_array_equal(a.exposure.image, b.exposure.image)


@pytest.fixture(scope="module")
def scattered(breast):
    return scatter_behind(breast, geometry(breast, 5.0), SPECTRUM, relative_error=0.05, cell_mm=5.0, seed=7)


def test_the_dose_is_as_certain_as_asked_and_does_not_depend_on_the_pixels(breast):
    one, other = (
        dose_in(breast, geometry(breast, pixel), SPECTRUM, relative_error=0.02, seed=seed)
        for pixel, seed in ((5.0, 1), (1.0, 2))
    )
    assert max(one.relative_error, other.relative_error) <= 0.02
    error = np.hypot(one.standard_error_mgy_per_mas, other.standard_error_mgy_per_mas)
    assert abs(one.mgy_per_mas - other.mgy_per_mas) < 4 * error


def test_scatter_comes_back_from_its_table_and_lowers_contrast(breast, scattered):
    cells = scatter_cells(scattered)
    scatter = scatter_from(cells, geometry(breast, 5.0))
    np.testing.assert_allclose(scatter.signal, scattered.per_mas(scattered.scatter).value, rtol=1e-12)
    fine = scatter_from(cells, geometry(breast, 1.0))
    with_scatter, without = (shot(breast, MAS, 5, scatter).row for scatter in (fine, None))
    # Scatter adds signal without contrast: C falls to C / (1 + S/P), with S/P at the lesion.
    expected = without["contrast_percent"] / (1 + with_scatter["scatter_to_primary"])
    assert with_scatter["contrast_percent"] == pytest.approx(expected, rel=0.01)


def test_scatter_of_another_field_is_rejected(breast, scattered):
    cells = scatter_cells(scattered)
    with pytest.raises(XrayError, match="use the same field"):
        scatter_from(cells[cells.row < 10], geometry(breast, 1.0))


def test_a_breast_without_lesion_has_no_cnr(breast):
    values = np.where(breast.values == Label.LESION, Label.GLANDULAR, breast.values).astype(np.uint8)
    healthy = LabelMap(breast.grid, values)
    with pytest.raises(XrayError, match="insert one"):
        shot(healthy, MAS, 6)


def test_a_step_that_is_not_known_is_answered_with_those_that_are(breast):
    with pytest.raises(ConfigurationError, match=r"no effect 'blurr' of an image; choose among: scatter"):
        ImageChain.named(("quantum_noise", "blurr"), Acquisition(geometry(breast, 1.0), 30.0, EQUIPMENT))


GROUPS = {
    Tube: vars(TUBE),
    Equipment: vars(EQUIPMENT),
    ScanSettings: {"system": "ge", "pixel_mm": 0.5, "slice_mm": 1.0, "iterations": 3, "exposure_share": 1.0,
                   "scatter_views": 3},
    SearchSettings: {"count": 5, "diameter_mm": 0.13, "width_mm": 5.0, "pixel_mm": 0.085, "images": 60},
}  # fmt: skip


@pytest.mark.parametrize(
    ("kind", "change", "words"),
    [
        (Tube, {"peak_kv": "28"}, r"xray\.peak_kv = '28' is of type"),
        (Tube, {"filter_um": 0.0}, r"xray: filter_um = 0 is outside \(0, inf\)"),
        (Equipment, {"detector": 3}, r"xray\.detector = 3 is of type"),
        (
            Equipment,
            {"focal_spot_mm": 300.0},
            r"focal_spot_mm = 300 is outside \[0, 5\]; usual",
        ),
        (Equipment, {"structure_percent": -1.0}, "structure_percent = -1 is outside"),
        (ScanSettings, {"iterations": 2.5}, r"xray\.iterations = 2\.5 is of type"),
        (ScanSettings, {"scatter_views": 0}, "scatter_views = 0 is outside"),
        (ScanSettings, {"slice_mm": -1.0}, r"slice_mm = -1 is outside \(0, inf\)"),
        (SearchSettings, {"images": 0}, r"images = 0 is outside \(0, inf\)"),
        (SearchSettings, {"balls": 3}, r"has no key 'balls'"),
    ],
)
def test_settings_of_an_image_that_cannot_be_meant_are_rejected(kind, change, words):
    with pytest.raises(ConfigurationError, match=words):
        read(kind, GROUPS[kind] | change, "xray")
