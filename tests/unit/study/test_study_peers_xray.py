"""X-ray tasks for several programs: the right answer has no error, targets are met or missed."""

import numpy as np
import pandas as pd
import pytest

from mammosim.core.errors import ConfigurationError
from mammosim.core.settings import read
from mammosim.study.peers.summary import XrayTarget, reached, xray_numbers
from mammosim.study.peers.xray import Answer, Dose, Region, Slices, View, row_of, task_of
from mammosim.study.peers.xray_bodies import body, grid_of
from mammosim.xray.projector import primary

SMALL = {"voxels": (6, 20, 30), "voxel_mm": 5.0, "pixels": (30, 40), "pixel_mm": 4.0}
VIEW = {**SMALL, "energies": 4}


def test_the_closed_form_of_slabs_is_our_image_to_rounding():
    task = View("slabs", **VIEW)
    setup = task.setup()
    exact = primary(setup.phantom, setup.geometry, setup.spectrum).signal
    assert task.amounts(Answer(image=exact))["error"] < 1e-12
    # One percent more is an error of one percent.
    assert task.amounts(Answer(image=1.01 * exact))["error"] == pytest.approx(0.01)


def test_the_image_of_a_breast_is_compared_with_the_mean_of_rays():
    task = View("breast", **VIEW)
    setup = task.setup()
    fine = primary(setup.phantom, setup.geometry, setup.spectrum, supersampling=3).signal
    assert task.amounts(Answer(image=fine))["error"] == 0
    assert task.amounts(Answer(image=0.98 * fine))["error"] == pytest.approx(0.02)


def test_what_a_program_is_given_gives_the_image():
    """mu and weights of the problem, with the lengths of slabs, are all that the image needs."""
    task = View("slabs", **VIEW)
    arrays, facts = task.problem()
    setup = task.setup()
    middle = setup.geometry.project(np.array([[0.0, -50.0, 20.0]]))[0] / 4.0
    column, row = middle.astype(int)
    d = facts["detector"]
    end = np.array(d["origin"]) + d["pixel_mm"] * (column * np.array(d["u"]) + row * np.array(d["v"]))
    way = end - np.array(facts["source_mm"])
    r, h = np.linalg.norm(way), -way[2]
    tau = arrays["mu"].T @ np.array([h - 30.0, 15.0, 15.0]) * r / h
    expected = arrays["weights"] @ np.exp(-tau) * h / r**3
    image = primary(setup.phantom, setup.geometry, setup.spectrum).signal
    assert image[row, column] == pytest.approx(expected, rel=1e-9)


def test_true_slices_have_no_error_and_views_see_them():
    task = Slices(**SMALL, views=3, arc_deg=30.0, energy_kev=20.0, iterations=1)
    phantom, mu = task.truth()
    assert task.amounts(Answer(slices=mu[phantom.index]))["error"] == 0
    assert task.amounts(Answer(slices=0 * mu[phantom.index]))["error"] == pytest.approx(
        np.sqrt(np.mean(mu[phantom.index][phantom.index > 0] ** 2))
    )
    arrays, _ = task.problem()
    assert arrays["integrals"].shape == (3, 30, 40)
    assert arrays["integrals"].max() == pytest.approx(30 * mu.max(), rel=0.1)
    assert arrays["sources"][0, 0] == pytest.approx(-arrays["sources"][2, 0])


def test_dose_of_several_runs_is_their_mean_beside_the_report():
    found = Answer(value=[4690.0, 4710.0], standard_error=[3.0, 4.0])
    amounts = Dose("16.8 keV", 2.0, 0.01).amounts(found)
    assert amounts["value"] == 4700
    assert amounts["standard_error"] == pytest.approx(2.5)
    assert amounts["error"] == pytest.approx(4700 / 4697.333 - 1)
    region = Region("Mo/Mo 30 kVp", 2.0, 0.01, 6).amounts(Answer(value=6.041, standard_error=0.1))
    assert region["error"] == pytest.approx(0, abs=1e-12)


def test_time_to_an_uncertainty_grows_as_its_square():
    found = Answer(cpu_s=[1.0, 2.0, 3.0], reached=[0.02, 0.02, 0.02], histories=[1e6, 1e6, 1e6])
    row = found.times(0.01)
    assert (row["cpu_s"], row["seconds"], row["runs"]) == (2.0, pytest.approx(8.0), 3)
    assert row["histories_per_s"] == pytest.approx(0.5e6)
    assert Answer(cpu_s=2.0).times(None)["seconds"] == 2.0


def test_a_program_that_is_not_there_has_a_row_without_numbers():
    row = row_of(Dose("16.8 keV", 2.0, 0.01), Answer("not installed: name a command"), 0.01)
    assert (row["runs"], row["outcome"]) == (0, "not installed: name a command")
    assert np.isnan([row["seconds"], row["value"], row["memory_mb"]]).all()


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (VIEW | {"body": "leg"}, r"problem\.body = 'leg': choose one of: breast, slabs"),
        (VIEW | {"body": "slabs", "voxels": [6, 20]}, r"problem\.voxels has 2 values; write 3"),
        (VIEW | {"body": "slabs", "pixels": [0, 40]}, r"problem\.pixels\[0\] = 0 is outside \[1, inf\)"),
        (VIEW | {"body": "slabs", "voxel_mm": np.nan}, r"problem\.voxel_mm = nan is not a finite number"),
        (VIEW | {"body": "slabs", "views": 3}, "problem has no key 'views'; choose one of: body"),
        ({"body": "slabs", **SMALL}, "problem lacks energies; add it"),
    ],
)
def test_a_task_that_cannot_be_is_rejected_with_its_key(values, message):
    with pytest.raises(ConfigurationError, match=message):
        task_of("view", values)


def test_unknown_tasks_and_bodies_are_rejected():
    with pytest.raises(ConfigurationError, match="choose one of: view"):
        task_of("film", {})
    with pytest.raises(ConfigurationError, match="breast, slabs"):
        body("leg", grid_of((2, 2, 2), 1.0))


@pytest.fixture
def table() -> pd.DataFrame:
    columns = ["task", "kind", "program", "seconds", "histories_per_s", "error", "value", "outcome"]
    rows = [
        ("sart", "slices", "mammosim", 2.0, np.nan, 0.010, np.nan, "converged"),
        ("sart", "slices", "slow", 30.0, np.nan, 0.009, np.nan, "converged"),
        ("sart", "slices", "fast", 10.0, np.nan, 0.020, np.nan, "converged"),
        ("sart", "slices", "broken", 0.1, np.nan, np.nan, np.nan, "crashed: signal 11"),
        ("scatter", "scatter", "mammosim", 40.0, 4e5, np.nan, 50.1, "converged"),
        ("scatter", "scatter", "plain_transport", 800.0, 4e6, np.nan, 50.0, "converged"),
        ("dose", "dose", "mammosim", 2.5, 4.2e6, 0.001, 4700.0, "converged"),
        ("dose", "dose", "egsnrc", np.nan, np.nan, np.nan, np.nan, "not installed: name a command"),
    ]
    return pd.DataFrame(rows, columns=columns).assign(cpu_s=1.0, runs=2)


def test_ours_is_compared_with_the_fastest_program_that_answered(table):
    targets = [
        {"task": "sart", "what": "times faster", "at_least": 4},
        {"task": "sart", "what": "times the error", "at_most": 1},
        {"task": "scatter", "what": "difference", "at_most": 0.001},
        {"task": "scatter", "what": "times faster", "at_least": 2},
        {"task": "dose", "what": "histories_per_s", "at_least": 4_000_000},
    ]
    found = reached(table, read(tuple[XrayTarget, ...], targets, "xray.targets"))
    assert list(found.peer) == ["fast", "fast", "plain_transport", "none", "mammosim"]
    assert found.measured[:3].tolist() == pytest.approx([5.0, 0.5, 0.002])
    # Plain transport is ours: nobody is there to be faster than.
    assert np.isnan(found.measured[3])
    assert found.met.tolist() == [True, True, False, False, True]
    facts = xray_numbers(table, found)
    assert facts["peers_xray.targets_missed"] == "difference, scatter; times faster, scatter"
    assert facts["peers_xray.absent"] == "egsnrc"
    assert facts["peers_xray.times_faster"] == "5.0 (sart, fast)"
    assert facts["peers_xray.millions_per_s"] == "4.2"
