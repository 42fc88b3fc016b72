"""Other moduli on the same stress-free shape: what is scaled, what is reported, what a failure leaves."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from mammosim.chain.graph import Chain, Stage
from mammosim.core.errors import MechanicsError
from mammosim.core.settings import read
from mammosim.study.identification.moduli import Materials, Moduli
from mammosim.study.identification.softening import numbers, rows, scaled

ASSUMED = {
    "tissues": {
        name: {"youngs_modulus_kpa": 9.0, "poisson_ratio": 0.3, "density_g_cm3": 1.0}
        for name in ("adipose", "glandular", "muscle")
    },
    "skin": {"youngs_modulus_kpa": 9.0, "poisson_ratio": 0.45, "thickness_mm": 1.5},
}
MODULI = pd.DataFrame(
    {
        "side": ["left"] * 4 + ["right"] * 4,
        "tissue": ["adipose", "glandular", "skin", "muscle"] * 2,
        "fitted_kpa": [1.0, 2.0, 10.0, 30.0, 5.0, 6.0, 7.0, 8.0],
    }
)


def test_the_fitted_moduli_of_the_side_replace_the_assumed_ones():
    fitted = Moduli.of_rows(MODULI).materials(read(Materials, ASSUMED, "tissues"), "left", poisson_ratio=0.48)
    tissues = fitted.setting()
    assert tissues["tissues"]["glandular"] == {
        "youngs_modulus_kpa": 2.0, "poisson_ratio": 0.48, "density_g_cm3": 1.0
    }  # fmt: skip
    assert tissues["skin"] == {"youngs_modulus_kpa": 10.0, "poisson_ratio": 0.45, "thickness_mm": 1.5}


def test_gland_alone_or_every_modulus_is_scaled():
    given = read(Materials, ASSUMED, "tissues")
    gland, every = (scaled(given, what, 0.5).setting() for what in ("glandular", "all"))
    moduli = [t["youngs_modulus_kpa"] for t in (*gland["tissues"].values(), gland["skin"])]
    assert moduli == [9.0, 4.5, 9.0, 9.0]
    assert {t["youngs_modulus_kpa"] for t in (*every["tissues"].values(), every["skin"])} == {4.5}
    assert given.setting() == ASSUMED


def _stiffness(inputs):
    return inputs.setting("tissues.tissues.glandular.youngs_modulus_kpa")


def _pressed(inputs):
    """A spring of 100 mm: force is stiffness times what is pressed."""
    E, until = _stiffness(inputs), inputs.setting("load.strategy")["until"]
    if E > 20:
        raise MechanicsError("the plates meet the chest wall")
    mm = 100 - until["force_n"] / E if "force_n" in until else inputs.setting("load.thickness_mm")
    return SimpleNamespace(row={"force_n": E * (100 - mm), "plates_mm": mm})


SPRING = {
    "stress_free": Stage(lambda i: 1.0, reads=("tissues",)),
    "mesh": Stage(lambda i: 0.0),
    "pressed": Stage(_pressed, ("stress_free",), ("tissues", "load")),
    "exposure": Stage(lambda i: i["pressed"].row["plates_mm"], ("pressed",)),
    "exposed_dose": Stage(lambda i: SimpleNamespace(dose_mgy=2.0 * i["exposure"]), ("exposure",)),
    "loaded": Stage(lambda i: np.array([0.0, 0.0, 9 / _stiffness(i)]), ("stress_free",), ("tissues",)),
}


@pytest.fixture
def today(monkeypatch):
    # The place of the nipple is that of the only node.
    monkeypatch.setitem(
        rows.__globals__["QUANTITIES"],
        "nipple_mm",
        SimpleNamespace(of=lambda c: c["loaded"], change=lambda a, b: np.linalg.norm(a - b)),
    )
    load = {"position": "upright", "thickness_mm": 50.0, "strategy": {"until": {"thickness_share": 1.0}}}
    load["tissues"] = ASSUMED
    return Chain(None, {"tissues": ASSUMED, "load": load}, frozenset(), SPRING)


def test_twice_as_stiff_takes_twice_the_force_and_at_the_same_force_is_pressed_half_as_far(today):
    table = rows(today, read(Materials, ASSUMED, "tissues"), [("glandular", 2.0), ("all", 0.5)]).set_index(
        "factor"
    )
    assert table.force_n.to_dict() == {1.0: 450.0, 2.0: 900.0, 0.5: 225.0}
    assert table.thickness_mm.to_dict() == {1.0: 50.0, 2.0: 75.0, 0.5: 0.0}
    assert table.nipple_moved_mm.to_dict() == {1.0: 0.0, 2.0: 0.5, 0.5: 1.0}
    assert (table.agd_mgy == 2 * table.thickness_mm).all()


def test_a_change_that_fails_is_a_row_with_its_reason(today):
    row = rows(today, read(Materials, ASSUMED, "tissues"), [("glandular", 3.0)]).iloc[-1]
    assert np.isnan(row.force_n)
    assert row.outcome == "failed: the plates meet the chest wall"


def test_the_page_tells_the_largest_changes_against_today(today):
    table = rows(
        today, read(Materials, ASSUMED, "tissues"), [("glandular", 2.0), ("glandular", 0.8), ("all", 2.0)]
    )
    found = numbers(table.assign(volunteer="small", side="left"))
    assert found["softening.glandular.force_percent"] == pytest.approx(100)
    assert found["softening.glandular.thickness_mm"] == pytest.approx(25)
    assert found["softening.all.nipple_mm"] == pytest.approx(0.5)
