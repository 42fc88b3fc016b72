"""What keys of a configuration must be to each other: one table, all of it checked at once."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from mammosim.chain.advice import Place, dotted, shown

# (value, the other value, name of the other) -> what is wrong between them, '' for nothing.
Compared = Callable[[Any, Any, str], str]


@dataclass(frozen=True)
class Relation:
    """What a value must be beside another one.

    key: dotted name, `*` for every entry; other: the key that it is compared with, where each `*` is that of
    `key`; or what names of files are known by; or '' where a list is compared with itself; next_step: what to
    do about it.
    """

    key: str
    compare: Compared
    other: str
    next_step: str


def _among(value: Any, known: Any, other: str) -> str:
    """One name, each of a list, or each key of a mapping is an entry of the other."""
    names = [value] if isinstance(value, str) else list(value)
    absent = [repr(name) for name in names if name not in known]
    verb = "is" if len(absent) == 1 else "are"
    return (
        f"{', '.join(absent)} {verb} not in {other} ({', '.join(map(str, known)) or 'empty'})"
        if absent
        else ""
    )


def _preset(value: Any, known: Any, other: str) -> str:
    """Of an accuracy that is a name, and no group of errors."""
    return _among(value, known, other) if isinstance(value, str) else ""


def _less(value: Any, limit: Any, other: str) -> str:
    return "" if value < limit else f"must be less than {other} = {limit:g}"


def _at_most(value: Any, limit: Any, other: str) -> str:
    return "" if value <= limit else f"must be at most {other} = {limit:g}"


def _rising(value: Any, _: Any, other: str) -> str:
    rises = all(low < high for low, high in pairwise(value))
    return "" if rises else "each number must be more than the one before"


def _falling(value: Any, _: Any, other: str) -> str:
    falls = all(high > low for high, low in pairwise(value))
    return "" if falls else "each number must be less than the one before"


def _there(value: Any, known: Any, other: str) -> str:
    return "" if value in known else "there is no such file"


def _distinct(value: Any, _: Any, other: str) -> str:
    return "" if len(set(value)) == len(value) else "its entries must differ"


# Names that stand in no setting, but in files: what `known` of `unmet` gives.
STRATEGIES = "the file of compression.strategies_file"
TISSUES = "config/tissues"
MODULI = "gravity and config/tissues"
SCENES = "config/scenes"
PUBLISHED = "config/models"
ACCURACIES = "study and config/accuracy"
FILES = "the files that are there"
VOLUNTEERS = "volunteer_table and the digital volunteers"
WOMEN = "digital.women"
METHODS = "mechanics.stress_free.methods"
PRESSED = "compression.strategies"
SEGMENTED = "segmentation.positions"

WRITE, TAKE = "write such a file, or leave it out", "write such a file, or take one of these"
ORDER = "put the lowest first"
CORRECT = "correct the path, which begins where the study is run, or leave the key out"
# Keys that name a file.
NAMING = ("volunteer_table", "hard_cases", "peers", "accuracy", "recovery", "compression.strategies_file")
# Schema -> relations between the keys of such a file.
RELATIONS: Mapping[str, tuple[Relation, ...]] = {
    "config": (
        *(Relation(key, _there, FILES, CORRECT) for key in NAMING),
        Relation("tissues", _among, TISSUES, TAKE),
        Relation("digital.tissues", _among, TISSUES, TAKE),
        Relation("reference_position", _among, SEGMENTED, "segment it, too"),
        Relation("mechanics.stress_free.position", _among, SEGMENTED, "segment it, too"),
        Relation("mechanics.stress_free.default", _among, METHODS, "add it, or take one of these"),
        Relation("compression.strategies", _among, STRATEGIES, "describe it there, or leave it out"),
        Relation("compression.moduli", _among, MODULI, WRITE),
        Relation("compression.thickness_mm", _among, VOLUNTEERS, "correct the name, or leave it out"),
        Relation("xray.strategies", _among, PRESSED, "press by it, too, or leave it out"),
        Relation("validation.wrong_model", _among, WOMEN, "describe her, or leave her out"),
        Relation("validation.wrong_model.*", _among, WOMEN, "describe her, or leave her out"),
        Relation("scenes.names", _among, SCENES, WRITE),
        Relation("models.names", _among, PUBLISHED, WRITE),
        Relation("scenes.accuracy", _among, ACCURACIES, "take one of these"),
        Relation("scenes.coarse", _among, ACCURACIES, "take one of these"),
        Relation("propagation.pressed", _less, "propagation.draws", "draw more, or press fewer"),
        Relation("digital.women.*.skin.variation_mm", _less, "digital.women.*.skin.mean_mm", "vary it less"),
        Relation("digital.scan.field_of_view_mm.*", _rising, "", ORDER),
        Relation("compression.thresholds.*", _rising, "", ORDER),
        Relation("morph.stiffness_kpa_per_mm", _rising, "", "put the weakest first"),
        Relation("registration.smoothing_mm", _falling, "", "put the coarsest level first"),
    ),
    "scene": (
        Relation("tissues", _among, TISSUES, TAKE),
        Relation("load.strategy", _among, STRATEGIES, "describe it there, or take one of these"),
        Relation("accuracy", _preset, ACCURACIES, "take one of these, or state errors"),
    ),
    "campaign": (
        Relation("subjects", _among, VOLUNTEERS, "take one of these"),
        Relation("tissues", _among, TISSUES, TAKE),
        Relation("load.strategy", _among, STRATEGIES, "describe it there, or take one of these"),
        Relation("load.moduli", _among, MODULI, WRITE),
        Relation("accuracy", _among, ACCURACIES, "take one of these"),
    ),
    "accuracy": (Relation("volunteer", _among, VOLUNTEERS, "take one of these"),),
    "recovery": (
        Relation("ranges.*", _rising, "", ORDER),
        Relation("between", _among, WOMEN, "describe her, or take two of these"),
        Relation("between", _distinct, "", "name two women"),
    ),
    "peers": (
        Relation("runs.*.case", _among, "cases", "describe it under cases, or leave the run out"),
        Relation("xray.runs.least", _at_most, "xray.runs.most", "allow more runs"),
    ),
}


def unmet(
    settings: Any, relations: Sequence[Relation], known: Mapping[str, Collection[str]]
) -> Iterator[tuple[tuple[Place, ...], str]]:
    """The places that each unmet relation compares, and its words, a line without the file.

    settings: nested values; known: names that stand in no setting. A relation of which a key is not there, or
    is of another kind, is left to the schema.
    """
    for relation in relations:
        for place, value in entries(settings, relation.key):
            for places, name, limit in _others(settings, relation, place, known):
                try:
                    wrong = relation.compare(value, limit, name)
                except (TypeError, OverflowError):
                    continue
                if wrong:
                    yield (place, *places), f"{dotted(place)} = {shown(value)}: {wrong}; {relation.next_step}"


def _others(
    settings: Any, relation: Relation, place: Place, known: Mapping[str, Collection[str]]
) -> list[tuple[tuple[Place, ...], str, Any]]:
    """Places, name and value of what a value is compared with; one without a place for itself."""
    if not relation.other:
        return [((), "", None)]
    if relation.other in known:
        return [((), relation.other, known[relation.other])]
    name = _filled(relation.other, relation.key, place)
    return [((other,), dotted(other), value) for other, value in entries(settings, name)]


def entries(values: Any, name: str) -> list[tuple[Place, Any]]:
    """Places and values of a dotted name, `*` for every entry of a group or list; none without such."""
    found: list[tuple[Place, Any]] = [((), values)]
    for part in name.split("."):
        found = [((*place, key), value) for place, held in found for key, value in _held(held, part)]
    return found


def _held(held: Any, part: str) -> list[tuple[str | int, Any]]:
    if isinstance(held, list):
        return list(enumerate(held)) if part == "*" else []
    if not isinstance(held, Mapping):
        return []
    return list(held.items()) if part == "*" else [(part, held[part])] if part in held else []


def _filled(other: str, key: str, place: Place) -> str:
    """The other name with the same entries where both have `*`."""
    pairs = zip(other.split("."), key.split("."), place, strict=False)
    same = [str(at) if mine == theirs == "*" else mine for mine, theirs, at in pairs]
    return ".".join([*same, *other.split(".")[len(same) :]])
