"""A published model as a file describes it: its source, what of it is reproduced, and its settings."""

from collections.abc import Collection, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from mammosim.chain.graph import Stage, overridden
from mammosim.chain.published_stages import (
    AS_MEASURED,
    EFFECTS,
    INCREMENTS,
    LAWS,
    OWN_METHODS,
    SLIDING,
    Otherwise,
    stages_of,
)
from mammosim.core.errors import ConfigurationError
from mammosim.core.settings import Count, Positive, read
from mammosim.core.tissues import TissueTable

PRODUCTS = ("stress_free", "loaded", "force")
INCREMENTS_TAKEN = 10
METHOD_WORDS: Mapping[str, str] = {
    "reverse_gravity": "reverse gravity",
    "fixed_point": "fixed point",
    "pull_back": "fixed point, pulled back",
    "mean_start": "from the mean of prone and supine",
    "inverse": "inverse formulation",
    "anderson": "accelerated fixed point",
    **OWN_METHODS,
}
# The settings of an effect that has some, where they stand.
SETTINGS_OF = {name: name for name in ("fascia", "ligaments", "sliding", "chest_wall")} | {
    "submerged": "water"
}

NOT_IN_STUDY = (
    "sliding",
    "chest_wall",
    "water",
)  # of them, what the settings of the study have no numbers of


@dataclass(frozen=True)
class Model:
    """One file of config/models.

    source: a key of the bibliography; known_from: what of it was read; tissues: a table as in config/tissues;
    settings: those of its effects; increments: of the law in small increments, by default INCREMENTS_TAKEN;
    tolerance_mm: of a stress-free shape loaded again, None for the study's.
    Raises ConfigurationError for an unknown law, method or effect, for an effect without its settings, and
    for settings that nothing of the model uses.
    """

    name: str
    title: str
    source: str
    known_from: str
    law: str
    method: str
    tissues: Mapping[str, Any]
    effects: tuple[str, ...]
    reproduced: str
    not_reproduced: str
    settings: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    increments: Count | None = None
    tolerance_mm: Positive | None = None

    def __post_init__(self) -> None:
        _among(self.law, LAWS, "law")
        _among(self.method, METHOD_WORDS, "method")
        for effect in self.effects:
            _among(effect, EFFECTS, "effects")
        wanted = {SETTINGS_OF[name] for name in (*self.effects, self.method) if name in SETTINGS_OF}
        if lacking := sorted(wanted - set(self.settings)):
            raise ConfigurationError(f"settings.{lacking[0]} is not there; give the numbers of that effect")
        if idle := sorted(set(self.settings) - wanted):
            raise ConfigurationError(f"settings.{idle[0]}: nothing of the model uses it; leave it out")
        if self.increments is not None and self.law != INCREMENTS:
            raise ConfigurationError(
                f"increments: only the law {INCREMENTS} has them; leave it out, or take that law"
            )
        if self.tolerance_mm is not None and self.method == AS_MEASURED:
            raise ConfigurationError(f"tolerance_mm: the method {AS_MEASURED} unloads nothing; leave it out")
        if "skin" in self.effects and self._table().skin is None:
            raise ConfigurationError("tissues has no skin; add it, or leave `skin` out of the effects")

    @classmethod
    def of(cls, name: str, values: Mapping[str, Any]) -> "Model":
        """Of a file's values. Raises ConfigurationError, which names the file."""
        try:
            return read(cls, {"name": name, **values}, f"config/models/{name}.yaml")
        except ConfigurationError as error:
            file = f"config/models/{name}.yaml"
            words = str(error)
            raise ConfigurationError(words if words.startswith(file) else f"{file}: {words}") from None

    @property
    def plain(self) -> dict[str, Any]:
        """As the plain values of a job."""
        return {name: value for name, value in asdict(self).items() if name != "name"}

    @property
    def otherwise(self) -> Otherwise:
        """What it does otherwise than the study."""
        return Otherwise(self.law, self.method, frozenset(self.effects))

    @property
    def stages(self) -> dict[str, Stage]:
        """The table of its stages."""
        return stages_of(self.otherwise)

    def over(self, study: Mapping[str, Any], position: str) -> dict[str, Any]:
        """The study's settings with its own in their place; position: in which the breast was measured."""
        tolerance = {} if self.tolerance_mm is None else {"tolerance_mm": self.tolerance_mm}
        own = {
            "model": {
                "law": self.law,
                "increments": self.increments or INCREMENTS_TAKEN,
                "position": position,
            },
            "effects": dict.fromkeys(NOT_IN_STUDY) | dict(self.settings),
            "mechanics": {"stress_free": {"default": self.method} | tolerance},
            # Half of the depth of her breast in prone, whatever the model.
            "load": {"moduli": "gravity", "thickness_mm": None, "position": position},
        }
        settings = overridden(study, own)
        return settings | {"tissues": self.tissues, "load": settings["load"] | {"tissues": self.tissues}}

    @property
    def words(self) -> dict[str, str]:
        """Columns of the table that say what it is."""
        return {
            "model": self.name,
            "title": self.title,
            "law": LAWS[self.law],
            "moduli_kpa": self._moduli(),
            "skin": self._skin(),
            "chest": self._chest(),
            "unloading": METHOD_WORDS[self.method],
            "known_from": self.known_from,
            "reproduced": self.reproduced,
            "not_reproduced": self.not_reproduced,
        }

    def _table(self) -> TissueTable:
        return read(TissueTable, dict(self.tissues), "tissues")

    def _moduli(self) -> str:
        tissues = self._table().tissues
        fat = tissues["adipose"]
        kpa = {
            "fat": fat.youngs_modulus_kpa,
            "gland": tissues["glandular"].youngs_modulus_kpa if "gland" in self.effects else None,
            "muscle": tissues["muscle"].youngs_modulus_kpa if "muscle" in self.effects else None,
        }
        listed = ", ".join(f"{name} {'as fat' if E is None else f'{E:.3g}'}" for name, E in kpa.items())
        return f"{listed}; nu {fat.poisson_ratio:g}"

    def _skin(self) -> str:
        skin = self._table().skin
        layers = (
            [f"{skin.youngs_modulus_kpa:g} kPa, {skin.thickness_mm:g} mm"]
            if skin and "skin" in self.effects
            else []
        )
        if "fascia" in self.effects:
            fascia = self.settings["fascia"]
            layers.append(f"fascia {fascia['youngs_modulus_kpa']:g} kPa, {fascia['thickness_mm']:g} mm")
        if "ligaments" in self.effects:
            layers.append("ligaments as fibres")
        return "; ".join(layers) or "none"

    def _chest(self) -> str:
        held = "held on the ribs"
        if SLIDING in self.effects:
            loose = self.settings[SLIDING]["tangential_kpa_per_mm"]
            held = f"slides on the ribs, {loose:g} kPa/mm along them"
        return held + (", which the skin cannot pass" if "chest_wall" in self.effects else "")


def _among(name: str, known: Collection[str], what: str) -> None:
    if name not in known:
        raise ConfigurationError(f"{what}: no {name!r}; choose one of: {', '.join(known)}")
