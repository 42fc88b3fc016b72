"""A scene: one question about one breast, with its load, what is asked how accurately, and its effects."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Literal

from mammosim.chain.graph import upstream
from mammosim.chain.quantities import QUANTITIES
from mammosim.chain.stages import STAGES, effects_on
from mammosim.core.errors import ConfigurationError
from mammosim.core.settings import Positive, Settings, read

# Every effect that a product of a scene may have, in words.
EFFECTS: Mapping[str, str] = {
    "gland": "gland with a modulus of its own",
    "muscle": "muscle stiffer than fat",
    "skin": "skin as a membrane",
    "fascia": "superficial fascia under the skin",
    "ligaments": "Cooper's ligaments as fibres",
    "weight": "weight of the breast between the plates",
    "friction": "friction of skin on the plates",
    "polychromatic": "photons of many energies",
    "paddle": "the paddle in the beam",
    "scatter": "scattered photons",
    "response": "what the detector absorbs",
    "heel": "the anode's own absorption",
    "focal_spot": "blur by the focal spot",
    "grid": "an anti-scatter grid",
    "quantum_noise": "noise of the photons",
    "blur": "spread in the detector",
    "structure": "pixels of different gain",
    "electronic_noise": "noise of the read-out",
}
# What a machine has or has not; all else is how faithfully it is computed.
EQUIPMENT = frozenset({"grid"})
# Only where a scene names it: with friction a press takes ten times as long (decisions/scenes.md).
EXPENSIVE = frozenset({"friction"})
AUTO = "auto"
# The settings that the load of a scene gives, by the products that read them.
LOADS = {"load.position": "position", "load.strategy": "strategy"}


@dataclass(frozen=True)
class Load(Settings):
    """What a breast is exposed to: the position that it hangs in, the strategy that presses it, or both."""

    position: str | None = None
    strategy: str | None = None

    @property
    def stated(self) -> dict[str, str]:
        """Those of them that a scene states."""
        return {name: value for name, value in asdict(self).items() if value is not None}


@dataclass(frozen=True)
class Scene(Settings):
    """asked: quantity -> tolerance in its unit; effects: names, None where a screening is to find them.

    volunteer, side, tissues: whose breast, of what; also: of EQUIPMENT and EXPENSIVE; accuracy: a preset's
    name; errors: in its place, quantity -> the largest numerical error.
    Raises ConfigurationError for names that mean nothing, and for a question that its load cannot answer.
    """

    name: str
    volunteer: str
    side: Literal["left", "right"]
    tissues: str
    load: Load
    asked: Mapping[str, Positive]
    effects: tuple[str, ...] | None
    also: tuple[str, ...] = ()
    accuracy: str = "standard"
    errors: Mapping[str, Positive] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        listed = self.effects or ()
        self._require_known("quantity", self.asked, QUANTITIES)
        self._require_known("effect", listed, EFFECTS)
        self._require_known("effect of `also`", self.also, EQUIPMENT | EXPENSIVE)
        for quantity in self.asked:
            for product in QUANTITIES[quantity].products:
                self._require_load(quantity, product)
            lacking = set(QUANTITIES[quantity].means_with) - set(listed)
            if self.effects is not None and lacking:
                raise ConfigurationError(
                    f"{quantity} means nothing without {', '.join(lacking)}; add it to effects"
                )

    @classmethod
    def of(cls, name: str, values: Mapping[str, object]) -> "Scene":
        """Of the values of its file, where effects may be AUTO and accuracy a preset or errors."""
        given = {key: value for key, value in values.items() if key != "title"} | {"name": name}
        if given.get("effects") == AUTO:
            given["effects"] = None
        if isinstance(given.get("accuracy"), Mapping):
            given["errors"] = given.pop("accuracy")
        return read(cls, given, f"scene {name}")

    @property
    def wanted(self) -> str | Mapping[str, float]:
        """How accurate its answer is to be: the preset, or the errors in its place."""
        return self.accuracy if self.errors is None else self.errors

    @property
    def full(self) -> frozenset[str]:
        """Every effect that acts on what is asked, of EQUIPMENT and EXPENSIVE only those that are named."""
        named = {*self.also, *(self.effects or ())}
        return effects_on(products_of(self.asked)) - ((EQUIPMENT | EXPENSIVE) - named)

    @property
    def needed(self) -> frozenset[str]:
        """Effects without which what is asked means nothing, and equipment."""
        means_with = {effect for name in self.asked for effect in QUANTITIES[name].means_with}
        return self.full & (means_with | EQUIPMENT)

    def modelled(self, model: str, screening: Sequence[Mapping[str, str]] | None) -> frozenset[str]:
        """The effects of a model: 'full', or 'screened': those listed, or else found by a screening.

        screening: rows as text, with scene, effect and included.
        """
        if model == "full":
            return self.full
        if self.effects is not None:
            return frozenset(self.effects) & self.full
        if screening is None:
            raise ConfigurationError(f"scene {self.name} was not screened; make its screening first")
        rows = [row for row in screening if row["scene"] == self.name]
        if not rows:
            raise ConfigurationError(f"scene {self.name} was not screened; make its screening again")
        return frozenset(row["effect"] for row in rows if row["included"] == "True")

    def _require_known(self, what: str, names: Iterable[str], known: Collection[str]) -> None:
        if unknown := [name for name in names if name not in known]:
            raise ConfigurationError(f"no {what} {unknown[0]!r}; choose among: {', '.join(sorted(known))}")

    def _require_load(self, quantity: str, product: str) -> None:
        reads = {name for each in (*upstream(STAGES, product), product) for name in STAGES[each].reads}
        for setting, key in LOADS.items():
            if setting in reads and key not in self.load.stated:
                raise ConfigurationError(
                    f"{quantity} needs a {key} in its load, such as "
                    f"{'upright' if key == 'position' else 'standard'}; add it, or do not ask for {quantity}"
                )


def products_of(asked: Iterable[str]) -> tuple[str, ...]:
    """Every product that asked quantities are taken from or made of, in the order of need."""
    ends = [product for name in asked for product in QUANTITIES[name].products]
    return tuple(dict.fromkeys(each for end in ends for each in (*upstream(STAGES, end), end)))
