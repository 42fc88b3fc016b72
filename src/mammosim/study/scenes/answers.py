"""What a chain answers to a scene, and what the answer took."""

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np

from mammosim.chain.graph import Chain
from mammosim.chain.quantities import QUANTITIES
from mammosim.core.errors import MammosimError
from mammosim.study.scenes.scene import products_of
from mammosim.study.scenes.screening import Answer, Answers


def values(chain: Chain, asked: Collection[str]) -> dict[str, Any]:
    """Asked quantities as plain numbers, or lists of them. Raises what a product is refused for."""
    return {name: np.asarray(QUANTITIES[name].of(chain), dtype=float).tolist() for name in asked}


def seconds(chain: Chain, asked: Collection[str]) -> float:
    """Processor time of every product that the answer is made of, as if it had been made for it alone."""
    keys = {chain.key(name) for name in products_of(asked)}
    return sum(chain.made[key].seconds for key in keys if key in chain.made)


def changes(found: Mapping[str, Any], reference: Mapping[str, Any]) -> dict[str, float]:
    """How far each value is from its reference, in the unit of the quantity."""
    return {
        name: QUANTITIES[name].change(np.asarray(value), np.asarray(reference[name]))
        for name, value in found.items()
    }


def answers(chain: Chain, asked: Collection[str]) -> Answers:
    """Of a set of effects on one breast, against those of another set; refusals are answers, too."""

    def answer(effects: frozenset[str], reference: frozenset[str]) -> Answer:
        other = chain.with_effects(effects)
        try:
            found, compared = values(other, asked), values(chain.with_effects(reference), asked)
        except MammosimError as refusal:
            return Answer({}, seconds(other, asked), refusal=str(refusal))
        nameless = [name for name, value in found.items() if not np.all(np.isfinite(value))]
        if nameless:
            return Answer({}, seconds(other, asked), refusal=f"{nameless[0]} is not a number")
        return Answer(changes(found, compared), seconds(other, asked), _noise(other, asked))

    return answer


def _noise(chain: Chain, asked: Collection[str]) -> dict[str, float]:
    """Standard errors in percent of changes, those of two independent runs, of quantities that have any."""
    # ASSUME: the noise of two runs is independent; where they have photons in common it is smaller.
    known = {name: QUANTITIES[name].noise for name in asked}
    return {name: 100 * np.sqrt(2) * noise(chain) for name, noise in known.items() if noise is not None}
