"""What the scripts of the workflow write is what the chain's products are, for one small breast."""

import importlib
import sys

import numpy as np
import pytest
from small_breast import NAMES, THICKNESS_MM, small_breast, study_settings

from mammosim.chain.graph import Chain
from mammosim.chain.stages import PRODUCTS
from mammosim.core.fiducials import Fiducials
from mammosim.core.rng import seed_of
from mammosim.io.fiducials import write_fiducials
from mammosim.io.images import read_image, read_labels, write_labels
from mammosim.io.meshes import read_mesh
from mammosim.io.tables import HOLDING_DIGITS, read_json, read_table
from mammosim.io.transforms import write_transform

SEED, *JOB = NAMES
JOB = dict(zip(("volunteer", "side", "strategy", "moduli"), JOB))
TUBE = ("anode", "filter", "filter_um", "peak_kv", "paddle")
GEOMETRY = ("source_to_detector_mm", "support_to_detector_mm", "pixel_mm", "field_mm")
HOLDS = 0.5 * 10.0 ** (1 - HOLDING_DIGITS)  # relative, of a number in a table


def some(values, *names):
    return {name: values[name] for name in names}


@pytest.fixture(scope="module")
def settings(repository):
    return study_settings(repository)


@pytest.fixture(scope="module")
def chain(settings):
    effects = {"gland", "muscle", "skin", "polychromatic", "paddle", *settings["xray"]["effects"]}
    return Chain(small_breast(), settings, frozenset(effects), PRODUCTS)


@pytest.fixture(scope="module")
def written(settings, repository, tmp_path_factory):
    """The files of all scripts from the mesh to the slices."""
    sys.path.insert(0, str(repository / "workflow/scripts"))
    try:
        return _run(settings, tmp_path_factory.mktemp("scripts"))
    finally:
        sys.path.pop(0)


def _run(settings, folder):
    breast, xray, press = small_breast(), settings["xray"], settings["compression"]
    moved = Fiducials(
        breast.fiducials.names, breast.fiducials.kinds, breast.to_reference(breast.fiducials.points)
    )
    write_labels(breast.labels, str(folder / "labels.nii.gz"))
    write_fiducials(breast.fiducials, str(folder / "fiducials.csv"))
    write_fiducials(moved, str(folder / "moved.csv"))
    write_transform(breast.to_reference, str(folder / "motion.tfm"))
    pressed = some(press, "smallest_mm", "steps", "penetration_mm", "plate_mm", "chest_gap_mm", "thresholds")
    pressed |= {"tissues": settings["tissues"], "thickness_mm": THICKNESS_MM}
    view = xray | {
        "geometry": some(xray, *GEOMETRY),
        "chain": some(xray, "detector", "focal_spot_mm", "grid", "structure_percent", *TUBE),
    }

    def run(script, *args, **names):
        given = {
            name: [str(folder / n) for n in file] if isinstance(file, list) else str(folder / file)
            for name, file in names.items()
        }
        importlib.import_module(script).main(given, *args)

    run("mesh", "woman", "prone", settings["mesh"], labels="labels.nii.gz", fiducials="fiducials.csv",
        transform="motion.tfm", mesh="mesh.vtu", quality="quality.csv")  # fmt: skip
    unloading = some(settings["mechanics"]["stress_free"], "iterations", "tolerance_mm")
    unloading |= {"tissues": settings["tissues"], "gravity": "0 -1 0"}
    run("stress_free", {"method": "anderson"}, unloading, mesh="mesh.vtu", transform="motion.tfm", start=[],
        shape="rest.vtu", history="history.csv")  # fmt: skip
    run("compress", JOB, pressed | {"strategy": settings["load"]["strategy"]}, mesh="rest.vtu",
        measured="mesh.vtu", fiducials="moved.csv", standard=[], shape="pressed.vtu", row="row.csv",
        path="path.csv", faces="faces.csv", amounts="amounts.csv", thickness="thickness.csv",
        plates="plates.json")  # fmt: skip
    density = {name: tissue["density_g_cm3"] for name, tissue in settings["tissues"]["tissues"].items()}
    skin_mm = settings["tissues"]["skin"]["thickness_mm"]
    run("phantom", JOB, xray | {"skin_mm": skin_mm, "density_g_cm3": density}, shape="pressed.vtu",
        measured="mesh.vtu", labels="labels.nii.gz", transform="motion.tfm", fiducials="moved.csv",
        plates="plates.json", phantom="phantom.nii.gz", conservation="conservation.csv")  # fmt: skip
    importlib.import_module("spectrum").main(
        some(xray, *TUBE, "energies"), str(folder / "spectrum.csv"), str(folder / "spectrum.json")
    )
    scan = {"geometry": view["geometry"], "scan": some(xray["tomosynthesis"], "system", "pixel_mm")}
    seen = {"phantom": "phantom.nii.gz", "plates": "plates.json"}
    run("field", JOB, scan, **seen, rows="field.csv")
    seen |= {"field": "field.csv", "spectrum": "spectrum.csv", "facts": "spectrum.json"}
    run("dose", view, JOB, seed_of(*NAMES, "photons"), **seen, dose="dose.csv")
    run("scatter", view, seed_of(*NAMES, "scatter"), **seen, scatter="scatter.csv")
    run("mammogram", view, JOB, SEED, **seen, scatter=["scatter.csv"], dose="dose.csv", row="image.csv",
        image="image.nii.gz")  # fmt: skip
    run("tomosynthesis", view | {"scan": xray["tomosynthesis"]}, JOB, SEED, **seen, image="image.csv",
        filtered_backprojection="fbp.nii.gz", sart="sart.nii.gz", rows="slices.csv",
        profiles="depth.csv")  # fmt: skip
    return folder


def test_mesh_and_stress_free_shape_are_the_same(chain, written):
    """The rotation is read from a file with ten digits: iterations end there within a micrometre."""
    for file, product in (("mesh.vtu", "mesh"), ("rest.vtu", "stress_free")):
        np.testing.assert_allclose(read_mesh(written / file).points, chain[product].points, rtol=0, atol=1e-6)


def test_the_pressed_breast_its_plates_and_its_row_are_the_same(chain, written):
    np.testing.assert_allclose(
        read_mesh(written / "pressed.vtu").points, chain["pressed"].points, rtol=0, atol=1e-5
    )
    assert read_json(written / "plates.json") == pytest.approx(chain["pressed"].plates)
    row = read_table(written / "row.csv").iloc[0]
    for name in ("force_n", "thickness_mm", "mean_pressure_kpa", "logarithmic_p95", "energy_mj"):
        assert row[name] == pytest.approx(chain["pressed"].row[name], rel=HOLDS)


def test_voxels_and_photons_are_the_same(chain, written):
    np.testing.assert_array_equal(
        read_labels(written / "phantom.nii.gz").values, chain["phantom"].labels.values
    )
    dose = read_table(written / "dose.csv").iloc[0]
    assert dose.mgy_per_mas == pytest.approx(chain["dose"].mgy_per_mas, rel=HOLDS)
    scatter = read_table(written / "scatter.csv")
    np.testing.assert_allclose(scatter.scatter, chain["scatter"].scatter, rtol=HOLDS)


def test_what_is_seen_in_mammogram_and_slices_is_the_same(chain, written):
    row = read_table(written / "image.csv").iloc[0]
    for name, value in chain["image"].items():
        assert row[name] == pytest.approx(value, rel=10 * HOLDS), name
    assert row.mas == pytest.approx(chain["exposure"], rel=HOLDS)
    slices = read_table(written / "slices.csv").set_index("method").loc["sart"]
    assert slices.cnr == pytest.approx(chain["slices"]["cnr"], rel=1e-3)
    assert read_image(written / "sart.nii.gz").values.ndim == 3
