"""Moduli that rise and fall within a month: what that changes for one breast whose stress-free shape stays.

The gland of one woman is up to 30 % softer or stiffer within a month. Her fitted body is taken as that of the
day of her images; with other moduli, the same stress-free shape is loaded and pressed again.
"""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pandas as pd

from mammosim.chain.graph import Chain
from mammosim.chain.outcome import CONVERGED, unsolved
from mammosim.chain.quantities import QUANTITIES
from mammosim.core.errors import MammosimError
from mammosim.core.progress import progress
from mammosim.study.identification.moduli import Materials

MEASURED = ("nipple_moved_mm", "force_n", "thickness_mm", "mas", "agd_mgy")


def scaled(materials: Materials, what: str, factor: float) -> Materials:
    """The materials with the modulus of one solid, or of 'all' and the skin, times a factor."""
    tissues = {
        name: replace(tissue, youngs_modulus_kpa=tissue.youngs_modulus_kpa * factor)
        if what in (name, "all")
        else tissue
        for name, tissue in materials.tissues.items()
    }
    skin = materials.skin
    if what == "all":
        skin = replace(skin, youngs_modulus_kpa=skin.youngs_modulus_kpa * factor)
    return Materials(tissues, skin)


def rows(assumed: Chain, fitted: Materials, variants: Iterable[tuple[str, float]]) -> pd.DataFrame:
    """A row per variant (tissue or 'all', factor), today's first: MEASURED and outcome.

    nipple_moved_mm: upright, from today's place; force_n: to today's thickness; thickness_mm, mas, agd_mgy:
    at today's force; NaN where there is no solution. assumed: a chain pressed to the standard thickness;
    fitted: the materials of today, in place of those of the chain.
    """
    today = _made_of(assumed, fitted)
    force_n = float(today["pressed"].row["force_n"])
    rest = {"stress_free": today["stress_free"]}
    cases = [("all", 1.0), *variants]
    found = []
    for what, factor in progress(cases, label="moduli", total=len(cases)):
        other = _made_of(assumed, scaled(fitted, what, factor)).given(rest)
        found.append({"tissue": what, "factor": factor} | _measured(today, other, force_n))
    return pd.DataFrame(found)


def _made_of(chain: Chain, materials: Materials) -> Chain:
    setting = materials.setting()
    return chain.with_settings({"tissues": setting, "load.tissues": setting})


def _measured(today: Chain, other: Chain, force_n: float) -> dict[str, float | str]:
    """MEASURED of a variant, and CONVERGED or why it was not solved."""
    nipple = QUANTITIES["nipple_mm"]
    # The way to today's thickness is gone on, or left, where the force is today's.
    at_force = other.with_settings({"load.strategy": {"until": {"force_n": force_n}}})
    try:
        values = (
            nipple.change(nipple.of(other), nipple.of(today)),
            float(other["pressed"].row["force_n"]),
            float(at_force["pressed"].row["plates_mm"]),
            at_force["exposure"],
            at_force["exposed_dose"].dose_mgy,
        )
    except MammosimError as error:
        return dict.fromkeys(MEASURED, np.nan) | {"outcome": unsolved(error)}
    return dict(zip(MEASURED, map(float, values))) | {"outcome": CONVERGED}


def numbers(table: pd.DataFrame) -> dict[str, float | None]:
    """What the page says: the largest changes, in percent or mm, of gland alone and of all moduli.

    table: rows of all breasts, with volunteer and side. None where no change was solved.
    """
    found: dict[str, float | None] = {}
    for what in ("glandular", "all"):
        changes = pd.concat([_changes(part, what) for _, part in table.groupby(["volunteer", "side"])])
        found |= {
            f"softening.{what}.{name}": float(value) if np.isfinite(value) else None
            for name, value in changes.max().items()
        }
    return found


def _changes(part: pd.DataFrame, what: str) -> pd.DataFrame:
    """Absolute changes of one breast's variants of a kind against today."""
    today = part[part.factor == 1.0].iloc[0]
    rows = part[(part.tissue == what) & (part.factor != 1.0)]
    return pd.DataFrame(
        {
            "nipple_mm": rows.nipple_moved_mm,
            "force_percent": 100 * (rows.force_n / today.force_n - 1).abs(),
            "thickness_mm": (rows.thickness_mm - today.thickness_mm).abs(),
            "dose_percent": 100 * (rows.agd_mgy / today.agd_mgy - 1).abs(),
        }
    )
