"""The tiny study as on other processors: the same meshes, and the same numbers within what they are worth.

A child process is held to the vector instructions of another processor (tests/instruction_sets.py).
"""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from instruction_sets import INSTRUCTION_SETS

from mammosim.io.meshes import read_mesh

pytestmark = pytest.mark.machines
MESHES = [f"results/meshes/small/{p}.vtu" for p in ("prone", "supine")]
# A tenth of the errors that `snakemake accuracy` found for the published study, of a number.
TENTH = {"mm": 0.19, "n": 0.01, "kpa": 0.01, "mgy": 0.007, "mas": 0.007, "cnr": 0.0075, "d": 0.0046}
MM = "mm"
# What a computation took, and what its last iteration left, are no results that must agree.
COSTS = (
    "seconds",
    "iterations",
    "factorisations",
    "forward_solves",
    "histories",
    "blocks",
    "damping",
    "imbalance_percent",
)
TABLES = (
    "registration",
    "sweep",
    "upright",
    "fit",
    "identification",
    "validation",
    "compression",
    "dose",
    "image",
)


@pytest.fixture(scope="module", params=["plain", "avx2"])
def other(request, study, tmp_path_factory):
    """The tiny study run with other instructions."""
    run = tmp_path_factory.mktemp(request.param)
    there = replace(study, run=run)
    result = there.snakemake(env=INSTRUCTION_SETS[request.param])
    assert result.returncode == 0, result.stdout[-6000:]
    return there


def test_meshes_are_the_same_to_the_node(finished, other):
    for name in MESHES:
        ours, theirs = (read_mesh(each.run / name) for each in (finished, other))
        np.testing.assert_array_equal(ours.cells, theirs.cells)
        np.testing.assert_array_equal(ours.tissue, theirs.tissue)
        np.testing.assert_allclose(ours.points, theirs.points, atol=1e-4)


@pytest.mark.parametrize("table", TABLES)
def test_numbers_differ_by_less_than_a_tenth_of_their_errors(finished, other, table):
    ours, theirs = (pd.read_csv(each.run / f"results/study/{table}.csv") for each in (finished, other))
    assert list(ours) == list(theirs)
    numbers = ours.select_dtypes("number").columns.difference(COSTS)
    for name in numbers:
        allowed = allowance(name, ours)
        away = (ours[name] - theirs[name]).abs()
        near = (away <= allowed) | (ours[name].isna() & theirs[name].isna())
        assert near.all(), f"{table}.{name}: {away.max():.3g}"


def allowance(name: str, rows: pd.DataFrame) -> pd.Series:
    """A tenth of the error of every number of a column: of its standard error, or of its quantity."""
    if f"{name}_se" in rows:
        return rows[f"{name}_se"] / 10 + 1e-6 * rows[name].abs()
    unit = name.rsplit("_", 1)[-1]
    if unit == MM:
        return pd.Series(TENTH[MM], index=rows.index)
    return TENTH.get(unit, 0.01) * rows[name].abs() + 1e-9
