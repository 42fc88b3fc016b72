"""The table of the stages from a labelled breast to its images."""

from collections.abc import Iterable, Mapping

from mammosim.chain.graph import Product
from mammosim.chain.mechanics import PRODUCTS as MECHANICS
from mammosim.chain.xray import PRODUCTS as XRAY

PRODUCTS: Mapping[str, Product] = {**MECHANICS, **XRAY}


def effects_on(products: Iterable[str]) -> frozenset[str]:
    """Every effect that one of these products may have."""
    return frozenset(effect for name in products for effect in PRODUCTS[name].effects)
