"""The scenes of a study: answers with the screened effects beside those of the full model, and their time."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from mammosim.study.scenes.answers import changes

Answered = Mapping[str, Any]  # values by quantity, effects, seconds


def rows(
    scene: str,
    asked: Mapping[str, float],
    screened: Answered,
    full: Answered,
    *,
    numerical: Mapping[str, float],
    screening_s: float,
) -> list[dict[str, Any]]:
    """A row per quantity: scene, quantity, screened, full, difference, tolerance, within, and the seconds.

    A place is told by its length; difference: in the unit of the quantity; numerical_error: what the settings
    of both leave, NaN where it was not measured; seconds_screening: of finding the effects; fraction: of the
    full model's processor time that the screened one takes.
    """
    apart = changes(screened["values"], full["values"])
    return [
        {
            "scene": scene,
            "quantity": quantity,
            "screened": float(np.linalg.norm(screened["values"][quantity])),
            "full": float(np.linalg.norm(full["values"][quantity])),
            "difference": apart[quantity],
            "tolerance": tolerance,
            "within": apart[quantity] <= tolerance,
            "numerical_error": numerical[quantity],
            "effects": len(screened["effects"]),
            "effects_full": len(full["effects"]),
            "seconds_screening": screening_s,
            "seconds_screened": screened["seconds"],
            "seconds_full": full["seconds"],
            "fraction": screened["seconds"] / full["seconds"],
        }
        for quantity, tolerance in asked.items()
    ]


def numbers(table: pd.DataFrame, effects: pd.DataFrame) -> dict[str, Any]:
    """What the page says of all scenes."""
    each = table.drop_duplicates("scene")
    outside = table[~table.within.astype(bool)]
    coarse = table[table.numerical_error > table.tolerance]
    decisions = effects.drop_duplicates(["scene", "effect"])
    return {
        "scenes.total": len(each),
        "scenes.within": int(table.groupby("scene").within.all().sum()),
        "scenes.coarse": ", ".join(f"{r.scene} {r.quantity}" for r in coarse.itertuples()) or "none",
        "scenes.outside": ", ".join(f"{r.scene} {r.quantity}" for r in outside.itertuples()) or "none",
        "scenes.effects": len(decisions),
        "scenes.effects_included": int(decisions.included.astype(bool).sum()),
        "scenes.fraction_median": float(each.fraction.median()),
        "scenes.fraction_least": float(each.fraction.min()),
        "scenes.seconds_screening": float(each.seconds_screening.sum()),
        "scenes.seconds_screened": float(each.seconds_screened.sum()),
        "scenes.seconds_full": float(each.seconds_full.sum()),
    }


def outside(table: pd.DataFrame) -> list[str]:
    """One line per answer that the screened effects do not give within its tolerance."""
    return [
        f"NOT WITHIN ITS TOLERANCE: {row.scene}: {row.quantity} differs from the full model's by "
        f"{row.difference:.3g}, asked are {row.tolerance:g}; lower scenes.part, or list the effects"
        for row in table[~table.within.astype(bool)].itertuples()
    ]
