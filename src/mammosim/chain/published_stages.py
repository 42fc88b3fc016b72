"""The stages of a published model: those of the study, but for what the model does otherwise.

A product whose stage is the study's, with the same settings and effects, is the study's own.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from mammosim.chain.graph import Chain, Need, Stage
from mammosim.chain.stages import FIBRES, MATERIAL, STAGES

NEO_HOOKEAN, INCREMENTS, NETWORK = "neo_hookean", "small_strain_increments", "spring_network"
LAWS: Mapping[str, str] = {
    NEO_HOOKEAN: "neo-Hookean",
    INCREMENTS: "linear, in small increments",
    NETWORK: "network of springs",
}
SLIDING, CHEST_WALL = "sliding", "chest_wall"
ON_RIBS = (SLIDING, CHEST_WALL)
EFFECTS = (*MATERIAL, *ON_RIBS)
AS_MEASURED, SUBMERGED = "as_measured", "submerged"
# How a model has its stress-free shape, beside the methods of the study.
OWN_METHODS: Mapping[str, str] = {
    AS_MEASURED: "the measured shape itself",
    SUBMERGED: "the shape in water, computed",
}
_RIBS = ("effects.sliding", "effects.chest_wall")
_METHOD = ("default", "iterations", "tolerance_mm")
_UNLOADING = tuple(f"mechanics.stress_free.{name}" for name in _METHOD)


@dataclass(frozen=True)
class Otherwise:
    """What a model does otherwise than the study: its law, method and effects."""

    law: str
    method: str
    effects: frozenset[str]

    @property
    def body(self) -> bool:
        """Whether its body is none of the study's."""
        return self.law != NEO_HOOKEAN or bool(self.effects & set(ON_RIBS))


def stages_of(model: Otherwise) -> dict[str, Stage]:
    """The table of its stages."""
    stages = {**STAGES, **_ALWAYS}
    if model.body:
        stages |= {"body": _BODY}
    if model.method in OWN_METHODS:
        stages |= {"unloaded": _UNLOADED}
    return stages


def shared(products: Iterable[str], chain: Chain, study: Chain) -> tuple[str, ...]:
    """The nearest kept products of the study that those of a model's chain are made of."""
    found: dict[str, None] = {}

    def look(name: str) -> None:
        stage = STAGES.get(name)
        if stage and stage.files and stage is chain.stages[name] and chain.key(name) == study.key(name):
            found[name] = None
            return
        for need in chain.needs(name):
            look(need)

    for product in products:
        look(product)
    return tuple(found)


_BODY = Stage(
    "published.body",
    ("breast", Need("mesh", lambda inputs: any(map(inputs.has, ON_RIBS)))),
    ("model.law", "model.increments", "mechanics.stress_free.default", "tissues", *FIBRES, *_RIBS),
    EFFECTS,
)
_UNLOADED = Stage("published.unloaded", ("breast", "mesh", "body"), (*_UNLOADING, "effects.water"))
_ALWAYS: Mapping[str, Stage] = {
    # ASSUME: where a published model's own method fails, no other is tried, nor stiffer moduli.
    "stress_free": Stage("published.stress_free", ("unloaded",)),
    "loaded": Stage(
        "published.loaded",
        ("breast", "body", "stress_free"),
        ("mechanics.newton_tolerance", "load.position", "model.position"),
    ),
    "pressed_body": Stage("published.pressed_body", ("body",)),
    "force": Stage("published.force", ("press_setup", "body", "standard_path")),
}
