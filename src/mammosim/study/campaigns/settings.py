"""The settings that a campaign may vary, by their dotted keys: their limits, and how a chain has them.

Keys of the configuration, as `xray.peak_kv`, and of files of config/tissues, as `tissues.skin.thickness_mm`;
`tissues` itself is the name of such a file. Of the load: `load.position`, `load.strategy` and `load.moduli`
by name; `load.paddle`, that of the strategy of this name; `load.until.force_n` and the like;
`load.thickness_mm` of the standard strategy; and `load.tissues.skin.thickness_mm` and the like of what is
pressed alone, while its stress-free shape stays.
"""

import operator
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from typing import Any

from mammosim.chain.conditions import UNDER_GRAVITY
from mammosim.chain.configuration import check_settings
from mammosim.chain.graph import nested, overridden, read_by
from mammosim.chain.stages import STAGES
from mammosim.core.errors import ConfigurationError
from mammosim.core.positions import GRAVITY
from mammosim.study.campaigns.axes import is_number

EFFECTS = ("mechanics.effects", "xray.effects")
# What a tissue table has beside the tissues themselves.
BESIDE_TISSUES = ("skin",)
Schema = Mapping[str, Any]
LIMITS: Mapping[str, Callable[[Any, Any], bool]] = {
    "minimum": operator.ge, "maximum": operator.le,
    "exclusiveMinimum": operator.gt, "exclusiveMaximum": operator.lt,
}  # fmt: skip


@dataclass(frozen=True)
class Known:
    """What settings are checked by and may name.

    schemas: those of config, tissues and compression; strategies and tissues: values by name, each read when
    it is asked for. settings: of the study, nested.
    """

    schemas: Mapping[str, Schema]
    strategies: Mapping[str, Any]
    tissues: Mapping[str, Any]
    settings: Mapping[str, Any]
    _limits: dict[str, Schema] = field(default_factory=dict, init=False, repr=False, compare=False)

    def limits(self, key: str) -> Schema:
        """The schema of one key. Raises ConfigurationError where there is no such setting."""
        if key not in self._limits:
            found = self._named(key) or _inside(*self._place(key))
            if found is None:
                raise ConfigurationError(f"there is no setting {key!r}; {self._advice(key)}")
            self._limits[key] = found
        return self._limits[key]

    def _named(self, key: str) -> Schema | None:
        """Of a key whose values are names."""
        names: Mapping[str, list[str]] = {
            "tissues": list(self.tissues),
            "load.moduli": [UNDER_GRAVITY, *self.tissues],
            "load.strategy": list(self.strategies),
            "load.position": list(GRAVITY),
        }
        if key == "load.paddle":
            paddle = _inside(self.schemas["compression"], ["standard", "paddle"])
            return {"oneOf": [{"enum": list(self.strategies)}, paddle]}
        return {"enum": names[key]} if key in names else None

    def _place(self, key: str) -> tuple[Schema, list[str]]:
        """In which schema a key stands, and where."""
        first, *rest = key.split(".")
        if first == "load" and rest[:1] == ["until"] and len(rest) > 1:
            return self.schemas["compression"], ["standard", *rest]
        if key == "load.thickness_mm":
            return self.schemas["config"], ["compression", "thickness_mm", "anyone"]
        if rest and (first == "tissues" or key.startswith("load.tissues.")):
            rest = rest[1:] if first == "load" else rest
            return self.schemas["tissues"], rest if rest[0] in BESIDE_TISSUES else ["tissues", *rest]
        return self.schemas["config"], [first, *rest]

    def _advice(self, key: str) -> str:
        names = list(self.names())
        near = get_close_matches(key, names, n=1) or [n for n in names if n.endswith(f".{key}")][:1]
        return (
            f"did you mean {near[0]!r}?" if near else "config/default.yaml and config/tissues have them all"
        )

    def names(self) -> Iterator[str]:
        """All settings that may be varied."""
        yield from ("tissues", *(f"load.{n}" for n in ("strategy", "paddle", "position", "moduli")))
        yield from ("load.thickness_mm", "load.until.force_n", "load.until.thickness_share")
        groups = {name.split(".")[0] for name in read_by(STAGES, STAGES)} & set(self.settings)
        yield from _leaves({name: self.settings[name] for name in groups - {"tissues", "load"}})
        for start in ("tissues", "load.tissues"):
            table = self.settings["tissues"]
            yield from (f"{start}.{n}" for n in _leaves(table["tissues"]))
            yield from (f"{start}.{n}" for n in _leaves({n: table[n] for n in BESIDE_TISSUES if n in table}))

    def fault(self, key: str, value: Any, file: str) -> str:
        """Why a value cannot be meant, in one line with its file; '' where it can."""
        settings: Any = value
        schema: Any = self.limits(key)
        if _plainly_within(value, schema):
            return ""
        for part in reversed(key.split(".")):
            settings, schema = {part: settings}, {"type": "object", "properties": {part: schema}}
        try:
            check_settings(settings, schema, files=[file])
        except ConfigurationError as error:
            return str(error).splitlines()[0]
        return ""


def _plainly_within(value: Any, schema: Schema) -> bool:
    """Whether it is a number within limits that are nothing but limits: a design has thousands of them."""
    limits = set(schema) - {"type", "description"}
    if not is_number(value) or schema.get("type") != "number" or limits - set(LIMITS):
        return False
    return all(LIMITS[name](value, schema[name]) for name in limits)


def _leaves(values: Any, start: str = "") -> Iterator[str]:
    if not isinstance(values, Mapping):
        yield start
        return
    for name, value in values.items():
        yield from _leaves(value, f"{start}.{name}" if start else name)


def _inside(schema: Schema, path: list[str]) -> Schema | None:
    """The schema of a place, None where it has no such key."""
    for part in path:
        inside = schema.get("properties", {}).get(part)
        if inside is None:
            patterns = list(schema.get("patternProperties", {}).values())
            more = schema.get("additionalProperties")
            inside = patterns[0] if patterns else more if isinstance(more, Mapping) else None
        if inside is None:
            return None
        schema = inside
    return schema


def depends(key: str, products: list[str]) -> bool:
    """Whether anything that these products may be made of reads a setting, or something in it."""
    if key in EFFECTS:
        return True
    read = {"load.paddle": "load.strategy", "load.position": "load.position"}.get(key, key)
    read = "load.strategy" if key.startswith("load.until.") else read
    if key == "tissues" or key.startswith("tissues."):
        return True
    return any(
        f"{read}.".startswith(f"{name}.") or name.startswith(f"{read}.") for name in read_by(STAGES, products)
    )


def changes(values: Mapping[str, Any], base: Mapping[str, Any], known: Known) -> dict[str, Any]:
    """The settings of a chain, by dotted names, that the varied ones of a point change.

    base: settings of the chain, with its load. Raises ConfigurationError where the load cannot have it.
    """
    mine = ("tissues", "load")
    found = {key: value for key, value in values.items() if key.split(".")[0] not in mine}
    return found | _tissues(values, base, known) | _load(values, base, known)


def _tissues(values: Mapping[str, Any], base: Mapping[str, Any], known: Known) -> dict[str, Any]:
    """`tissues`, and `load.tissues`, which are the same where the study's moduli are pressed with."""
    moduli = values.get("load.moduli", base["load"].get("moduli", UNDER_GRAVITY))
    table = known.tissues[values["tissues"]] if "tissues" in values else base["tissues"]
    table = _altered(table, values, "tissues.")
    pressed = table if moduli == UNDER_GRAVITY else known.tissues[moduli]
    pressed = _altered(pressed, values, "load.tissues.")
    found = {"tissues": table, "load.tissues": pressed, "load.moduli": moduli}
    return {
        name: value
        for name, value in found.items()
        if value != _at(base, name) and (name == "tissues" or "moduli" in base["load"])
    }


def _altered(table: Mapping[str, Any], values: Mapping[str, Any], start: str) -> Mapping[str, Any]:
    for key, value in values.items():
        if key.startswith(start):
            path = key.removeprefix(start).split(".")
            path = path if path[0] in BESIDE_TISSUES else ["tissues", *path]
            for part in reversed(path):
                value = {part: value}
            table = overridden(table, value)
    return table


def _load(values: Mapping[str, Any], base: Mapping[str, Any], known: Known) -> dict[str, Any]:
    """`load.strategy`, `load.position` and `load.thickness_mm`."""
    found = {key: values[key] for key in ("load.position", "load.thickness_mm") if key in values}
    strategy = base["load"].get("strategy")
    if "load.strategy" in values:
        strategy = known.strategies[values["load.strategy"]]
    if strategy is None:
        return found
    if "load.paddle" in values:
        given = values["load.paddle"]
        described = known.strategies[given] if isinstance(given, str) else {"paddle": given}
        plates = {name: described[name] for name in ("paddle", "support") if described.get(name)}
        strategy = {"until": strategy["until"]} | plates
    start = "load.until."
    until = nested({key.removeprefix(start): value for key, value in values.items() if key.startswith(start)})
    if len(until) > 1:
        raise ConfigurationError(f"load.until has {' and '.join(until)}; a paddle stops by one of them")
    strategy = strategy | {"until": until} if until else strategy
    return found | ({"load.strategy": strategy} if strategy != base["load"].get("strategy") else {})


def _at(values: Any, name: str) -> Any:
    for part in name.split("."):
        values = values.get(part) if isinstance(values, Mapping) else None
    return values
