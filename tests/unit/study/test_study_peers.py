"""What is compared with other programs is one problem, and the comparison tells no more than was measured."""

import numpy as np
import pandas as pd
import pytest

from mammosim.core.errors import ConfigurationError
from mammosim.core.labels import Label
from mammosim.core.settings import read
from mammosim.mechanics.body import load
from mammosim.study.peers.mechanics import AWAY_FROM_THE_HELD_FACE, RADIUS_MM, Case, hemisphere, result
from mammosim.study.peers.summary import MechanicsTargets, numbers, reached, with_agreement

SKIN = {"youngs_modulus_kpa": 10.0, "poisson_ratio": 0.45, "thickness_mm": 2.0}
STIFF = {"youngs_modulus_kpa": 1.0, "poisson_ratio": 0.45}


@pytest.mark.parametrize("skin", [{}, {"membrane": SKIN}])
def test_the_residual_is_that_of_the_forces_and_vanishes_in_equilibrium(skin):
    case, mesh = Case.of(STIFF | skin), hemisphere(25.0)
    found = load(mesh, case.tissues, AWAY_FROM_THE_HELD_FACE, skin=case.membrane)
    in_equilibrium = result(case, mesh, found.points - mesh.points, displacements_only=False)
    assert in_equilibrium["residual"] <= 1e-8  # the tolerance of a solve
    assert in_equilibrium["unknowns"] == 3 * (len(mesh.points) - len(mesh.boundary_nodes("posterior")))
    # At rest nothing opposes the weight.
    at_rest = result(case, mesh, np.zeros_like(mesh.points), displacements_only=False)
    assert at_rest["residual"] == pytest.approx(1.0)


def test_a_program_that_found_nothing_has_no_apex():
    assert np.isnan(result(Case.of(STIFF), hemisphere(25.0), None, displacements_only=True)["apex_mm"])


def test_the_layer_ends_at_the_same_radius():
    mesh = hemisphere(25.0, layer_mm=2.0)
    assert np.linalg.norm(mesh.points, axis=1).max() == pytest.approx(RADIUS_MM)
    inner = np.linalg.norm(mesh.points[mesh.boundary_nodes("fascia")], axis=1)
    assert inner == pytest.approx(RADIUS_MM - 2)
    assert set(mesh.tissue) == {Label.ADIPOSE, Label.SKIN}


def test_mu_and_k_are_those_of_the_tissue():
    facts = Case.of(STIFF | {"layer": SKIN}).facts()
    assert facts["mu_kpa"] == pytest.approx({"1": 1 / 2.9, "3": 10 / 2.9})
    assert facts["k_kpa"] == pytest.approx({"1": 1 / 0.3, "3": 10 / 0.3})
    assert facts["weight"] == pytest.approx(9.81e-3)


@pytest.fixture
def table() -> pd.DataFrame:
    columns = ["law", "case", "edge_mm", "program", "unknowns", "apex_mm", "cpu_s", "memory_mb", "outcome"]
    rows = [
        ("displacements", "soft", 8.0, "mammosim", 1000, 76.2379, 1.0, 300, "converged"),
        ("displacements", "soft", 8.0, "felupe", 1000, 76.2380, 6.0, 500, "converged"),
        ("displacements", "soft", 8.0, "calculix", 1000, 76.2990, 9.0, 200, "converged"),
        ("", "soft", 8.0, "ngsolve", 1000, np.nan, 0.1, 100, "30 iterations"),
        ("displacements", "soft", 4.0, "mammosim", 8000, 76.3000, 8.0, 900, "converged"),
    ]
    return with_agreement(pd.DataFrame(rows, columns=columns))


def test_a_displacement_of_its_own_is_flagged(table):
    agrees = dict(zip(table.program[:4], table.agrees[:4]))
    assert agrees == {"mammosim": True, "felupe": True, "calculix": False, "ngsolve": None}


def reached_by(table, targets):
    return reached(table, read(MechanicsTargets, targets, "targets").all())


def test_the_fastest_that_converged_counts(table):
    targets = {
        "faster": [{"case": "soft", "edge_mm": 8, "at_least": 5}],
        "growth": [{"case": "soft", "at_most": 0.9}],
        "less_memory": [{"case": "soft", "edge_mm": 8, "at_most": 1}],
        "slower": [{"case": "hard", "edge_mm": 8, "than": "soft", "at_most": 5}],
    }
    found = reached_by(table, targets).set_index("what")
    assert found.measured["times faster"] == pytest.approx(6.0)
    assert found.peer["times faster"] == "felupe"
    assert found.measured["exponent of the time"] == pytest.approx(1.0)
    assert found.measured["times the memory"] == pytest.approx(1.5)
    assert np.isnan(found.measured["times the time of soft"])
    assert dict(found.met) == {
        "times faster": True,
        "exponent of the time": False,
        "times the memory": False,
        "times the time of soft": False,
    }


def test_the_numbers_of_the_page_name_what_was_missed(table):
    targets = reached_by(table, {"faster": [{"case": "soft", "edge_mm": 8, "at_least": 8}]})
    facts = numbers(table, targets)
    assert facts["peers.targets_missed"] == "times faster, soft, 8 mm"
    assert (facts["peers.programs"], facts["peers.not_converged"], facts["peers.disagree"]) == (3, 1, 1)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (STIFF | {"layers": SKIN}, "case has no key 'layers'; did you mean 'layer'"),
        (STIFF | {"poisson_ratio": 0.5}, r"case\.poisson_ratio = 0.5 is outside \[0, 0.5\)"),
        (
            STIFF | {"membrane": SKIN | {"thickness_mm": 20.0}},
            r"case\.membrane: thickness_mm from 20 to 20 is outside",
        ),
        (
            {"youngs_modulus_kpa": np.inf, "poisson_ratio": 0.45},
            r"youngs_modulus_kpa = inf is not a finite number",
        ),
        ({"poisson_ratio": 0.45}, "case lacks youngs_modulus_kpa; add it"),
        (STIFF | {"load_steps": {"ngsolve": 0}}, r"case\.load_steps\.ngsolve = 0 is outside \[1, inf\)"),
    ],
)
def test_a_case_that_cannot_be_is_rejected_with_its_key(values, message):
    with pytest.raises(ConfigurationError, match=message):
        Case.of(values)


@pytest.mark.parametrize(
    ("target", "message"),
    [
        ({"case": "soft", "edge_mm": 8}, r"targets\.faster\[0\]: a target has one of at_least and at_most"),
        ({"case": "soft", "edge_mm": 8, "at_least": 1, "at_most": 2}, "give exactly one"),
        ({"case": "soft", "at_least": 1}, r"targets\.faster\[0\] lacks edge_mm"),
        ({"case": "soft", "edge_mm": 8, "at_least": "1"}, r"faster\[0\]\.at_least = '1' is of type str"),
    ],
)
def test_a_target_that_cannot_be_is_rejected_with_its_key(target, message):
    with pytest.raises(ConfigurationError, match=message):
        read(MechanicsTargets, {"faster": [target]}, "targets")
