"""Reference numbers of the verification, and what its tests share: the unit tissue, rollers, reactions."""

from pathlib import Path

import numpy as np
import pandas as pd

from mammosim.core.labels import Label
from mammosim.core.tissues import Tissue
from mammosim.mechanics.equilibrium import Settings
from mammosim.mechanics.newton import NewtonSettings

TABLES = Path(__file__).parent / "verification" / "references"
# Rounding of k (J - 1) leaves residuals of about 1e-16 k / load, here up to 1e-11.
TIGHT = Settings(newton=NewtonSettings(tolerance=1e-10))


def rows(name, **chosen):
    """The rows of a table, or only those with the given values; its comments name the source."""
    table = pd.read_csv(TABLES / f"{name}.csv", comment="#")
    for column, value in chosen.items():
        table = table[table[column] == value]
    return list(table.itertuples(index=False))


def unit_tissue(nu, density=0.0):
    """mu = 1 kPa."""
    return {Label.ADIPOSE: Tissue(2 * (1 + nu), nu, density)}


def rollers(mesh, axes):
    """Held: the normal component on the faces at 0 of the axes."""
    at_zero = np.isclose(mesh.points, 0.0, atol=1e-9)
    return at_zero & np.isin(np.arange(3), axes)


def forces(effects, x):
    """What must act on the nodes for x to be in equilibrium (n_node, 3), mN."""
    g = np.zeros_like(x)
    for effect in effects:
        effect.add_gradient(x, g)
    return g
