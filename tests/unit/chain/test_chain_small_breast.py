"""The chain of one small breast: what its stages decide between the sciences."""

import re
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from small_breast import THICKNESS_MM, small_breast, small_chain

from mammosim.chain.files import job_inputs, job_outputs, nearest_kept, variant_of
from mammosim.chain.jobs import make
from mammosim.chain.mammogram import SENSOR_MM, xray_phantom
from mammosim.chain.phantom import healthy
from mammosim.chain.photons import ExposedDose
from mammosim.chain.points import MaterialPoints
from mammosim.chain.stages import STAGES
from mammosim.core.errors import MissingResult
from mammosim.core.labels import Label
from mammosim.io.missing import write_missing
from mammosim.io.tables import read_json, read_table
from mammosim.meshing.raster import rasterise
from mammosim.xray.dose import GlandularDose
from mammosim.xray.projector import path_lengths, primary
from mammosim.xray.quality import automatic_mas

PLACES = {
    **{"v": "woman", "p": "prone", "side": "left", "method": "anderson", "strategy": "standard"},
    **{"moduli": "gravity", "position": "upright", "reference": "supine", "strokes": "", "also": ""},
}


@pytest.fixture(scope="module")
def chain(repository):
    return small_chain(repository)


def exposure_of(chain, labels):
    phantom, geometry = xray_phantom(labels), chain["geometry"]
    return automatic_mas(
        primary(phantom, geometry, chain["spectrum"]).kerma_mgy,
        path_lengths(phantom, geometry)[..., 1:].sum(axis=-1) > 0,
        target_mgy=chain.setting("xray.detector_kerma_ugy") / 1e3,
        sensor_pixels=max(round(SENSOR_MM / geometry.detector.pixel_mm), 1),
    )


def test_automatic_exposure_looks_beside_the_lesion(chain):
    large = chain.with_settings({"xray.lesion": {"diameter_mm": 40.0, "depth_mm": 25.0}})
    labels = large["phantom"]
    assert large["exposure"] == pytest.approx(exposure_of(large, healthy(labels)), rel=1e-12)
    assert abs(exposure_of(large, labels) / large["exposure"] - 1) > 1e-3, "the lesion would show"
    assert large["mammogram"].row["mas"] == large["exposure"]


def test_twice_the_kerma_takes_twice_the_exposure(chain):
    twice = chain.with_settings({"xray.detector_kerma_ugy": 2 * chain.setting("xray.detector_kerma_ugy")})
    assert twice["exposure"] == pytest.approx(2 * chain["exposure"], rel=1e-9)


def test_dose_and_its_error_are_those_per_mas_times_the_exposure(chain):
    dose, mas = chain["dose"], chain["exposure"]
    assert chain["exposed_dose"] == ExposedDose(dose.mgy_per_mas * mas, dose.standard_error_mgy_per_mas * mas)
    row = chain["image_row"]
    assert row["dose_mgy"] == chain["exposed_dose"].dose_mgy
    assert row["dose_se_mgy"] == chain["exposed_dose"].dose_se_mgy


def test_the_lesion_lies_where_it_was_put_behind_the_nipple_before_compression(chain):
    """The middle of its voxels, carried back to the measured shape: depth_mm behind the nipple, along +y."""
    breast, found, given = small_breast(), chain["pressed"], chain.setting("xray.lesion")
    labels = chain["phantom"]
    raster = rasterise(found.mesh, labels.grid)
    measured = raster.carry(breast.to_reference.inverse()(chain["mesh"].points))
    inside = labels.values[raster.cell >= 0] == Label.LESION
    middle = measured[inside].mean(axis=0)
    # Voxels of 4 mm: the middle of some forty is known to about a millimetre.
    np.testing.assert_allclose(middle, breast.nipple + [0, given["depth_mm"], 0], atol=2.0)
    assert np.linalg.norm(measured[inside] - middle, axis=1).max() <= given["diameter_mm"] / 2 + 2.0


def test_weight_between_the_plates_pulls_to_the_floor(repository):
    bare, heavy = small_chain(repository), small_chain(repository, also=("weight",))
    more = heavy["press_setup"].effects[len(bare["press_setup"].effects) :]
    assert len(more) == 1
    x = heavy["press_setup"].mesh.points
    lower, forward = x - [0, 0, 1.0], x - [0, 1.0, 0]
    assert more[0].energy(lower) < more[0].energy(x)
    assert more[0].energy(forward) == pytest.approx(more[0].energy(x), abs=1e-9 * abs(more[0].energy(x)))


def test_the_pressed_breast_is_as_thick_as_asked_and_sits_around_its_nipple(chain):
    found, breast = chain["pressed"], small_breast()
    assert found.row["plates_mm"] == THICKNESS_MM
    assert found.plates["paddle_z_mm"] - found.plates["support_z_mm"] == pytest.approx(THICKNESS_MM)
    nipple = MaterialPoints.on(chain["mesh"], breast.to_reference(breast.nipple[None]))
    x = nipple.carry(chain["stress_free"].mesh.points)[0, 0]
    assert (found.plates["low_x_mm"] + found.plates["high_x_mm"]) / 2 == pytest.approx(x)


def stiffer(tissue):
    return {**tissue, "youngs_modulus_kpa": 5 * tissue["youngs_modulus_kpa"]}


def test_other_moduli_press_the_same_stress_free_shape(chain):
    tissues = chain.setting("tissues")
    stiff = {
        name: {**t, "youngs_modulus_kpa": 5 * t["youngs_modulus_kpa"]}
        for name, t in tissues["tissues"].items()
    }
    skin = {**tissues["skin"], "youngs_modulus_kpa": 5 * tissues["skin"]["youngs_modulus_kpa"]}
    other = chain.with_settings({"load.tissues": {"tissues": stiff, "skin": skin}})
    assert other["stress_free"] is chain["stress_free"]
    # The penalty of the contact follows the moduli: the same state, within the residual, 1e-6 of the forces.
    assert other["pressed"].row["force_n"] == pytest.approx(5 * chain["pressed"].row["force_n"], rel=1e-6)


def test_without_scatter_the_mammogram_needs_none(chain):
    none = chain.with_effects(chain.effects - {"scatter"})
    assert "scatter" in chain.needs("mammogram")
    assert "scatter" not in none.needs("mammogram")
    assert none["mammogram"].row["scatter_to_primary"] == 0 < chain["mammogram"].row["scatter_to_primary"]


def test_a_method_or_a_start_that_is_the_mean_needs_the_mean_shape(chain):
    assert "mean_shape" not in chain.needs("unloaded")
    for name, value in (("default", "mean_start"), ("start", "mean")):
        other = chain.with_settings({f"mechanics.stress_free.{name}": value})
        assert "mean_shape" in other.needs("unloaded")


def test_all_views_together_take_their_share_of_the_exposure(chain):
    share = chain.setting("xray.tomosynthesis")["exposure_share"]
    half = chain.with_settings({"xray.tomosynthesis.exposure_share": share / 2})
    assert chain["views"].mas == pytest.approx(share * chain["exposure"])
    assert half["views"].mas == pytest.approx(chain["views"].mas / 2)


def test_what_is_conserved_is_told_of_the_breast_without_its_lesion(chain):
    """Else gland would be lost where the lesion stands."""
    rows = chain["conservation"].query(
        "quantity == 'volume_mm3' and step == 'voxels' and tissue == 'glandular'"
    )
    voxels = chain["healthy_phantom"]
    gland = np.count_nonzero(voxels.values == Label.GLANDULAR) * voxels.grid.voxel_volume
    assert rows.after.iloc[0] == pytest.approx(gland)
    assert np.count_nonzero(chain["phantom"].values == Label.LESION) > 0


def test_with_friction_only_the_standard_and_what_is_relative_to_it_need_its_load_path(repository):
    rough = small_chain(repository, also=("friction",))
    assert "standard_path" in rough.needs("pressed"), "it is pressed once"
    for until, needed in (({"force_share": 0.5}, True), ({"thickness_share": 1.25}, False)):
        other = rough.with_settings({"load.strategy": {"until": until}})
        assert ("standard_path" in other.needs("pressed")) == needed
    hinged = {"paddle": {"tilting": {"stiffness_n_mm_per_rad": 50.0}}, "until": {"thickness_share": 1.0}}
    assert "standard_path" not in rough.with_settings({"load.strategy": hinged}).needs("pressed")


def test_a_strategy_that_needs_no_standard_is_pressed_without_one(chain, tmp_path):
    """A share of a thickness is; a share of a force, and the standard itself, say why there is none."""
    lost = {name: str(tmp_path / Path(path).name) for name, path in paths_of("standard_path").items()}
    for path in lost.values():
        write_missing(path, "standard_path woman left gravity: it slides away")

    def pressed(until, *, without):
        other = chain.with_settings({"load.strategy": {"until": until}})
        if without:
            made = {
                key: found for key, found in chain.made.items() if key[0] not in ("standard_path", "pressed")
            }
            other = replace(other, made=made).kept({"standard_path": lost})
        return other["pressed"].row["force_n"]

    # From another start to the same state: as near as pressed skin lies on the plates.
    thicker = {"thickness_share": 1.1}
    assert pressed(thicker, without=True) == pytest.approx(pressed(thicker, without=False), rel=2e-3)
    for until in ({"force_share": 0.5}, {"thickness_share": 1.0}):
        with pytest.raises(MissingResult, match="it slides away"):
            pressed(until, without=True)


def paths_of(name):
    return STAGES[name].files.paths(PLACES)


@pytest.fixture(scope="module")
def kept(chain, tmp_path_factory):
    """Every kept product of the small breast as files, and a chain that reads them."""
    folder = tmp_path_factory.mktemp("kept")
    names = [name for name in KEPT if STAGES[name].files]
    paths = {name: str(folder / path) for name, path in job_outputs(names, PLACES).items()}
    for path in paths.values():
        folder.joinpath(path).parent.mkdir(parents=True, exist_ok=True)
    make(chain, names, paths, {"volunteer": "007", "side": "left"})
    files = {
        name: {f: str(folder / p) for f, p in STAGES[name].files.paths(PLACES).items()} for name in names
    }
    return chain.given({}).kept(files), folder


KEPT = (
    *("mesh", "unloaded", "stress_free", "loaded", "standard_path", "pressed", "phantom", "conservation"),
    "field",
    *("spectrum", "dose", "scatter", "mammogram", "image_row", "slices", "depth", "dose_routes"),
)


def fresh(chain):
    return type(chain)(chain.subject, chain.settings, chain.effects, chain.stages, files=chain.files)


def test_what_was_kept_is_what_was_made(chain, kept):
    read = fresh(kept[0])
    np.testing.assert_array_equal(read["mesh"].points, chain["mesh"].points)
    for name in ("unloaded", "stress_free", "loaded"):
        np.testing.assert_array_equal(read[name].mesh.points, chain[name].mesh.points)
    np.testing.assert_array_equal(read["standard_path"].shapes, chain["standard_path"].shapes)
    assert dict(read["pressed"].plates) == pytest.approx(dict(chain["pressed"].plates))
    assert read["pressed"].row["force_n"] == chain["pressed"].row["force_n"]
    np.testing.assert_array_equal(read["phantom"].values, chain["phantom"].values)
    np.testing.assert_allclose(read["spectrum"].fluence, chain["spectrum"].fluence)
    assert read["dose"] == chain["dose"]
    assert isinstance(read["dose"], GlandularDose)
    np.testing.assert_array_equal(read["scatter"].scatter, chain["scatter"].scatter)
    assert read["mammogram"].row["cnr"] == chain["mammogram"].row["cnr"]
    assert read["slices"].cnr("sart") == chain["slices"].cnr("sart")
    # The shape and the spectrum are read with the digits that their files hold.
    assert read["exposed_dose"].dose_mgy == pytest.approx(chain["exposed_dose"].dose_mgy, rel=1e-9)


def test_rows_of_tables_say_whose_they_are_and_no_file_is_without_numbers(kept):
    _, folder = kept
    for path in folder.rglob("*.csv"):
        table = read_table(path)
        assert len(table), path.name
        if "volunteer" in table:
            assert list(table.columns[:2]) == ["volunteer", "side"]
            assert set(table.volunteer) == {"007"}


def test_what_each_product_took_is_told_once(kept):
    _, folder = kept
    told = [name for path in folder.rglob("*_seconds.json") for name in read_json(path)]
    assert len(told) == len(set(told))


def test_every_stage_has_its_functions():
    for name, stage in STAGES.items():
        module, function = import_module(stage.module), stage.function.split(".")[1]
        assert callable(getattr(module, function)), name
        written_only = {"image_row", "depth", "dose_routes", "moved_scan", "gland_probability"}
        measured = {"scan", "strokes", "listed", "given_labels", "reference_scan", "reference_fiducials"}
        measured |= {"reference_mesh"}
        if stage.files and name not in written_only:
            assert callable(getattr(module, f"load_{function}")), name
        if stage.files and name not in measured:
            assert callable(getattr(module, f"save_{function}")), name


def test_a_variant_is_named_where_it_differs_from_the_study_and_not_before(chain):
    finer = chain.with_settings({"xray.voxel_mm": 2.0})
    names = {name: variant_of(name, finer, chain) for name in ("mesh", "pressed", "phantom", "dose")}
    assert names["mesh"] == names["pressed"] == ""
    assert re.fullmatch("-[0-9a-f]{8}", names["phantom"])
    assert names["dose"] not in ("", names["phantom"])
    assert variant_of("dose", chain.with_effects(chain.effects - {"paddle"}), chain) not in (
        "",
        names["dose"],
    )
    # What an absent effect would have read, and noise that a dose does not have, change nothing.
    assert variant_of("dose", chain.with_effects(chain.effects - {"blur"}), chain) == ""


def test_a_job_reads_the_nearest_kept_products(chain):
    assert set(nearest_kept(["dose"], chain)) == {"phantom", "pressed", "field", "spectrum"}
    assert set(nearest_kept(["mesh"], chain)) == {"transform", "labels", "fiducials"}
    assert (
        "results/compression/woman/left/standard_gravity_plates.json"
        in job_inputs(["phantom"], PLACES, chain).values()
    )
