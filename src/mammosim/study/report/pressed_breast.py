"""One pressed breast as its tables have it: strategies, images, and the load paths of its standard."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from mammosim.chain.conditions import UNDER_GRAVITY
from mammosim.chain.outcome import CONVERGED
from mammosim.chain.strategies import STANDARD
from mammosim.io.missing import missing_rows

BREAST = ["volunteer", "side"]
STRAIN, FORCE, PRESSURE = "strain", "force_n", "pressure_kpa"
# What is done to the breast, by its column of compression.csv.
DONE: Mapping[str, str] = {
    STRAIN: "logarithmic_p95",
    FORCE: "force_n",
    PRESSURE: "mean_pressure_kpa",
}
SAME_MM = 0.01  # thicknesses that differ by less are one
KEYS = [*BREAST, "strategy", "moduli", "outcome", "quantity", "thickness_mm", *DONE.values()]
Tables = Mapping[str, pd.DataFrame]


@dataclass(frozen=True)
class PressedBreast:
    """One breast: its rows of compression.csv that converged, of image.csv, of the standard's load paths.

    force_share: the least and the greatest force of the draws of the fit, over that of the fit; or None.
    """

    rows: pd.DataFrame
    image: pd.DataFrame
    path: pd.DataFrame
    force_share: tuple[float, float] | None

    @property
    def xrayed(self) -> pd.DataFrame:
        """Its strategies with the moduli that are X-rayed, a row each, the thinnest first."""
        return self.rows[self.rows.moduli == UNDER_GRAVITY].sort_values("thickness_mm", ignore_index=True)

    def other_moduli(self) -> list[str]:
        """The other sets of moduli with which its standard was pressed."""
        standard = self.rows[self.rows.strategy == STANDARD]
        return [name for name in standard.moduli.unique() if name != UNDER_GRAVITY]

    def at(self, moduli: str, quantity: str, thickness_mm: float) -> float:
        """A quantity of DONE with a set of moduli at a thickness, from what was computed; NaN: not known."""
        rows = self.rows[(self.rows.moduli == moduli) & is_level(self.rows)]
        there = rows[(rows.thickness_mm - thickness_mm).abs() < SAME_MM]
        if len(there):
            return float(there[DONE[quantity]].iloc[0])
        path = self.path[self.path.moduli == moduli]
        if quantity != STRAIN and len(path):  # a load path has no strain
            rows = path
        return between(rows.thickness_mm, rows[DONE[quantity]], thickness_mm)


def is_level(rows: pd.DataFrame) -> pd.Series:
    """Whether the plates stayed parallel (n,) bool: strategies whose thickness says all of their shape."""
    yielding = rows.reindex(columns=["tilt_deg", "deflection_mm"]).fillna(0.0)
    ends = rows.reindex(columns=["thickness_min_mm", "thickness_max_mm"])
    return (yielding == 0).all(axis=1) & ~(ends.thickness_max_mm > ends.thickness_min_mm)


def between(t: pd.Series, q: pd.Series, at: float) -> float:
    """q at t = at, linear in a curve that only falls, or only rises; NaN of another one, and outside it."""
    order = np.argsort(t.to_numpy(), kind="stable")
    x, y = t.to_numpy(float)[order], q.to_numpy(float)[order]
    steps = np.diff(y)
    one_way = np.all(steps <= 0) or np.all(steps >= 0)
    return float(np.interp(at, x, y, left=np.nan, right=np.nan)) if len(x) and one_way else float("nan")


def breasts(tables: Tables) -> dict[tuple[str, str], PressedBreast]:
    """Every breast whose standard strategy converged with the moduli that are X-rayed, by volunteer and side.

    tables: compression, image, compression_path, propagation, as far as they are there, with rows in the
    place of missing results.
    """
    pressed = _there(tables, "compression")
    pressed = pressed[pressed.outcome == CONVERGED]
    others = {name: _there(tables, name) for name in ("image", "compression_path", "propagation")}
    found = {}
    for (volunteer, side), rows in pressed.groupby(BREAST, sort=False):
        hers = {name: of_breast(table, str(volunteer), str(side)) for name, table in others.items()}
        path = hers["compression_path"]
        image = hers["image"][hers["image"].moduli == UNDER_GRAVITY]
        if ((rows.strategy == STANDARD) & (rows.moduli == UNDER_GRAVITY)).any():
            found[str(volunteer), str(side)] = PressedBreast(
                rows, image, path[path.strategy == STANDARD], _force_share(hers["propagation"])
            )
    return found


def _there(tables: Tables, name: str) -> pd.DataFrame:
    """A table without the rows of missing results; without rows where it is not there."""
    table = tables.get(name, pd.DataFrame())
    table = table[~missing_rows(table)]
    return table.reindex(columns=list(dict.fromkeys([*KEYS, *table.columns])))


def of_breast(table: pd.DataFrame, volunteer: str, side: str) -> pd.DataFrame:
    """The rows of one breast; none of a table that knows no breasts."""
    if not set(BREAST) <= set(table):
        return table.iloc[:0]
    return table[(table.volunteer == volunteer) & (table.side == side)]


def _force_share(propagation: pd.DataFrame) -> tuple[float, float] | None:
    rows = propagation[propagation["quantity"] == "force_n"]
    if rows.empty or not rows.fit.iloc[0] > 0:
        return None
    row = rows.iloc[0]
    return float(row.low / row.fit), float(row.high / row.fit)
