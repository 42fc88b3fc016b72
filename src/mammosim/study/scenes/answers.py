"""What a chain answers to a scene and what it took; screened answers beside those with all effects."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from mammosim.chain.graph import Chain
from mammosim.chain.quantities import QUANTITIES
from mammosim.core.errors import MammosimError
from mammosim.core.settings import NotNegative, Settings
from mammosim.study.scenes.scene import Scene, products_of
from mammosim.study.scenes.screening import Answer, Answers


@dataclass(frozen=True)
class Answered(Settings):
    """values: of each asked quantity, (1,) or (3,) of a place; seconds: of a processor, for all of it."""

    values: Mapping[str, tuple[float, ...]]
    effects: tuple[str, ...]
    seconds: NotNegative


def values(chain: Chain, asked: Collection[str]) -> dict[str, list[float]]:
    """Asked quantities, see Answered. Raises the error of a product that could not be made."""
    return {name: np.atleast_1d(np.asarray(QUANTITIES[name].of(chain), float)).tolist() for name in asked}


def seconds(chain: Chain, asked: Collection[str]) -> float:
    """Processor time of every product that the answer is made of, as if it had been made for it alone."""
    keys = {chain.key(name) for name in products_of(asked)}
    return sum(chain.made[key].seconds for key in keys if key in chain.made)


def changes(
    found: Mapping[str, Sequence[float]], reference: Mapping[str, Sequence[float]]
) -> dict[str, float]:
    """How far each value is from its reference, in the unit of the quantity."""
    return {
        name: QUANTITIES[name].change(np.asarray(value), np.asarray(reference[name]))
        for name, value in found.items()
    }


def answers(chain: Chain, asked: Collection[str]) -> Answers:
    """Of a set of effects on one breast, against those of another set; a failure is an answer, too."""

    def answer(effects: frozenset[str], reference: frozenset[str]) -> Answer:
        other = chain.with_effects(effects)
        try:
            found, compared = values(other, asked), values(chain.with_effects(reference), asked)
        except MammosimError as error:
            return Answer({}, seconds(other, asked), failure=str(error))
        nameless = [name for name, value in found.items() if not np.all(np.isfinite(value))]
        if nameless:
            return Answer({}, seconds(other, asked), failure=f"{nameless[0]} is not a number")
        return Answer(changes(found, compared), seconds(other, asked), _noise(other, asked))

    return answer


def _noise(chain: Chain, asked: Collection[str]) -> dict[str, float]:
    """Standard errors in percent of changes, those of two independent runs, of quantities that have any."""
    # ASSUME: the noise of two runs is independent; where they have photons in common it is smaller.
    known = {name: QUANTITIES[name].noise for name in asked}
    return {name: 100 * np.sqrt(2) * noise(chain) for name, noise in known.items() if noise is not None}


def rows(
    scene: Scene, screened: Answered, full: Answered, *, numerical: Mapping[str, float], screening_s: float
) -> list[dict[str, Any]]:
    """A row per quantity: scene, quantity, screened, full, difference, tolerance, within, and the seconds.

    A place is given as its length; difference: in the unit of the quantity; numerical_error: what the
    settings of both leave, NaN where it was not measured; seconds_screening: of finding the effects;
    fraction: of the full model's processor time that the screened one takes.
    """
    apart = changes(screened.values, full.values)
    return [
        {
            "scene": scene.name,
            "quantity": quantity,
            "screened": float(np.linalg.norm(screened.values[quantity])),
            "full": float(np.linalg.norm(full.values[quantity])),
            "difference": apart[quantity],
            "tolerance": tolerance,
            "within": apart[quantity] <= tolerance,
            "numerical_error": numerical[quantity],
            "effects": len(screened.effects),
            "effects_full": len(full.effects),
            "seconds_screening": screening_s,
            "seconds_screened": screened.seconds,
            "seconds_full": full.seconds,
            "fraction": screened.seconds / full.seconds,
        }
        for quantity, tolerance in scene.asked.items()
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
        f"{row.difference:.3g}, the tolerance is {row.tolerance:g}; lower scenes.part, or list the effects"
        for row in table[~table.within.astype(bool)].itertuples()
    ]
