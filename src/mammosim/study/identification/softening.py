"""Moduli that rise and fall within a month: what that changes for one breast whose stress-free shape stays.

The gland of one woman is up to 30 % softer or stiffer within a month. Her fitted body is taken as that of the
day of her images; with other moduli, the same stress-free shape is loaded and pressed again.
"""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import pandas as pd

from mammosim.chain.graph import Chain
from mammosim.chain.outcome import VERIFIED
from mammosim.chain.quantities import QUANTITIES
from mammosim.core.errors import MammosimError
from mammosim.core.progress import progress

FITTED = ("adipose", "glandular", "muscle")
MEASURED = ("nipple_moved_mm", "force_n", "thickness_mm", "mas", "agd_mgy")


def fitted_tissues(
    moduli: pd.DataFrame, assumed: Mapping[str, Any], *, side: str, poisson_ratio: float
) -> dict[str, Any]:
    """The tissues of one side as fitted, {'tissues': {...}, 'skin': {...}}.

    moduli: rows side, tissue, fitted_kpa; assumed: of which all but moduli and Poisson's ratio is taken.
    """
    kpa = moduli[moduli.side == side].set_index("tissue").fitted_kpa
    own = {name: {"youngs_modulus_kpa": float(kpa[name]), "poisson_ratio": poisson_ratio} for name in FITTED}
    tissues = {name: {**assumed["tissues"][name], **values} for name, values in own.items()}
    return {"tissues": tissues, "skin": {**assumed["skin"], "youngs_modulus_kpa": float(kpa["skin"])}}


def scaled(tissues: Mapping[str, Any], what: str, factor: float) -> dict[str, Any]:
    """The tissues with the modulus of one, or of 'all' and the skin, times a factor."""
    changed = {
        name: {**values, "youngs_modulus_kpa": values["youngs_modulus_kpa"] * factor}
        if what in (name, "all")
        else values
        for name, values in tissues["tissues"].items()
    }
    skin = {**tissues["skin"]}
    skin["youngs_modulus_kpa"] *= factor if what == "all" else 1.0
    return {"tissues": changed, "skin": skin}


def rows(today: Chain, variants: Iterable[tuple[str, float]]) -> pd.DataFrame:
    """A row per variant (tissue or 'all', factor), today's first: MEASURED and outcome.

    nipple_moved_mm: upright, from today's place; force_n: to today's thickness; thickness_mm, mas, agd_mgy:
    at today's force; NaN where refused. today: a chain pressed to the standard thickness.
    """
    force_n = float(today["pressed"].row["force_n"])
    tissues, rest = today.setting("tissues"), {"stress_free": today["stress_free"]}
    cases = [("all", 1.0), *variants]
    found = []
    for what, factor in progress(cases, label="moduli", total=len(cases)):
        changed = scaled(tissues, what, factor)
        other = today.with_settings({"tissues": changed, "load.tissues": changed}).given(rest)
        found.append({"tissue": what, "factor": factor} | _measured(today, other, force_n))
    return pd.DataFrame(found)


def _measured(today: Chain, other: Chain, force_n: float) -> dict[str, float | str]:
    """MEASURED of a variant, and VERIFIED or why it was refused."""
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
        return dict.fromkeys(MEASURED, np.nan) | {"outcome": f"refused: {error}"}
    return dict(zip(MEASURED, map(float, values))) | {"outcome": VERIFIED}


def numbers(table: pd.DataFrame) -> dict[str, float | None]:
    """What the page says: the largest changes, in percent or mm, of gland alone and of all moduli.

    table: rows of all breasts, with volunteer and side. None where every change was refused.
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
