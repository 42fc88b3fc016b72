"""What is wrong with one value of a configuration, in words: its limits, and what was probably meant."""

import re
import sys
from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from typing import Any

from jsonschema import ValidationError

Place = tuple[str | int, ...]
Schema = Mapping[str, Any]

# Last part of a key -> units that a value may have been given in, and what one of them is in the key's own.
UNITS: Mapping[str, tuple[tuple[str, float], ...]] = {
    "mm": (("m", 1e3), ("cm", 10.0), ("um", 1e-3)),
    "um": (("mm", 1e3), ("cm", 1e4), ("m", 1e6)),
    "kpa": (("Pa", 1e-3), ("MPa", 1e3)),
    "mpa": (("GPa", 1e3), ("kPa", 1e-3), ("Pa", 1e-6)),
    "kpa_per_mm": (("MPa/mm", 1e3), ("Pa/mm", 1e-3)),
    "n": (("mN", 1e-3), ("kN", 1e3)),
    "n_mm_per_rad": (("N m per rad", 1e3), ("mN mm per rad", 1e-3)),
    "g_cm3": (("kg/m3", 1e-3),),
    "kv": (("V", 1e-3),),
    "kev": (("eV", 1e-3), ("MeV", 1e3)),
    "ms": (("s", 1e3), ("us", 1e-3)),
    "ugy": (("mGy", 1e3), ("Gy", 1e6)),
    "deg": (("rad", 57.29577951),),
    "percent": (("parts of one", 100.0),),
    "share": (("percent", 0.01),),
}
# Keys without a unit that are parts of one.
SHARES = ("fraction", "front", "part", "joint_part", "within", "relative_error", "tissue_error")
NUMBER = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
# Text in the place of a number, and what is wrong with it; the first that matches.
NO_NUMBERS: tuple[tuple[str, str], ...] = (
    (r"\s*[\u2010-\u2015\u2212]\s*[0-9.]+.*", "its minus is a typographic one; write -"),
    (r"\s*[-+]?[0-9]+([, '][0-9]{3})+(\.[0-9]*)?\s*", "write no comma, blank or ' between thousands"),
    (r"\s*[-+]?[0-9]*,[0-9]+.*", "write a decimal point, not a comma"),
    (r"\s*[-+]?0[box][0-9a-fA-F_]+\s*", "write a decimal number"),
    (r"\s*[-+]?[0-9.]+([eE][-+]?[0-9]+)?\s*[^\d\s].*", "write the number alone; the key names its unit"),
)
PATTERNS: Mapping[str, str] = {
    "^[a-z0-9]+$": "lower case letters and digits",
    "^[a-z0-9_]+$": "lower case letters, digits and _",
    "^[a-z0-9_]{1,60}$": "lower case letters, digits and _ (60 at most)",  # a part of names of files
    "^[a-z0-9_.]+$": "lower case letters, digits, _ and .",
}
TYPES: Mapping[str, str] = {
    "number": "a number",
    "integer": "a whole number",
    "string": "text",
    "boolean": "true or false",
    "array": "a list",
    "object": "a group of keys",
}


def dotted(place: Place) -> str:
    """The name of a place, as mesh.element_mm.breast."""
    return ".".join(map(str, place)) or "the file"


def number_of(text: str) -> int | float | None:
    """The number that a text is by YAML 1.2, which reads 2e-1 as 0.2; None for any other text."""
    if not NUMBER.fullmatch(text):
        return None
    return int(text) if text.lstrip("+-").isdigit() else float(text)


def advice(error: ValidationError) -> Iterator[tuple[Place, str]]:
    """Place and words of each fault that an error of the schema is: a line without the file."""
    place, schema = tuple(error.absolute_path), error.schema
    if error.validator == "additionalProperties":
        yield from (((*place, key), _unknown(place, key, schema)) for key in _unknown_keys(error))
    elif error.validator == "required":
        absent = sorted(set(error.validator_value) - set(error.instance))
        yield place, f"{dotted(place)} lacks {', '.join(_meant_by(key, schema) for key in absent)}; add it"
    elif "propertyNames" in error.absolute_schema_path:
        hint = _hint(place, error.instance, schema)
        must = "; ".join(filter(None, (f"must be {limits(schema)}", hint)))
        yield (*place, error.instance), f"{dotted(place)} has no key {error.instance!r}: {must}"
    elif error.validator == "contains":
        yield place, f"{dotted(place)} lacks {error.validator_value['const']!r}, which is needed; add it"
    else:
        yield place, _value(place, error.instance, schema, error)


def _meant_by(key: str, schema: Schema) -> str:
    """A key with what it means."""
    about = schema.get("properties", {}).get(key, {}).get("description")
    return f"{key} ({about})" if about else key


def _value(place: Place, value: Any, schema: Schema, error: ValidationError) -> str:
    """A value that cannot be, its limits, what was probably meant, and what the key means."""
    about = f" ({schema['description']})" if "description" in schema else ""
    if value is None:
        return f"{dotted(place)} is empty: must be {limits(schema)}; give it, or leave the key out{about}"
    hint = _hint(place, value, schema)
    must = _must(value, schema, error)
    return f"{dotted(place)} = {shown(value)}: {'; '.join(filter(None, (must, hint)))}{about}"


def shown(value: Any) -> str:
    """A value as Python writes it, cut where it is long."""
    text = repr(value) if isinstance(value, (str, int, float, bool, list, dict)) else str(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _must(value: Any, schema: Schema, error: ValidationError) -> str:
    if error.validator == "uniqueItems":
        twice = next(each for n, each in enumerate(value) if each in value[:n])
        return f"{twice!r} stands twice; keep one"
    if error.validator == "not":
        return f"must not be {error.validator_value.get('const')!r}"
    if error.validator in ("minItems", "maxItems", "minProperties", "maxProperties"):
        least, most = (schema.get(f"{end}{str(error.validator)[3:]}") for end in ("min", "max"))
        count = (
            f"{least}"
            if least == most
            else f"at least {least}"
            if most is None
            else f"{least or 0} to {most}"
        )
        return f"has {len(value)} entries and must have {count}"
    return f"must be {limits(schema)}"


def limits(schema: Schema) -> str:
    """What a value may be: its kind and limits, as 'a number from 15 to 120'."""
    if "enum" in schema:
        return f"one of: {', '.join(map(str, schema['enum']))}"
    if "const" in schema:
        return str(schema["const"])
    for either in ("oneOf", "anyOf"):
        if either in schema:
            return " or ".join(limits(each) for each in schema[either])
    types = schema.get("type", "string" if "pattern" in schema else ())
    kind = (
        " or ".join(TYPES[each] for each in ([types] if isinstance(types, str) else types))
        or "something else"
    )
    if "pattern" in schema:
        return f"{kind} of {_letters(schema['pattern'])}"
    if "minimum" in schema and "maximum" in schema:
        return f"{kind} from {schema['minimum']:g} to {schema['maximum']:g}"
    ends = (
        ("minimum", "at least"),
        ("exclusiveMinimum", "more than"),
        ("maximum", "at most"),
        ("exclusiveMaximum", "less than"),
    )
    given = [f"{words} {schema[end]:g}" for end, words in ends if end in schema]
    return " ".join([kind, " and ".join(given)]) if given else kind


def _letters(pattern: str) -> str:
    return PATTERNS.get(pattern, f"the pattern {pattern}")


def _hint(place: Place, value: Any, schema: Schema) -> str:
    """What was probably meant, if anything is known."""
    if isinstance(value, bool):
        words = {"string": "put it in quotes"}.get(str(schema.get("type")), "write it out")
        return f"YAML reads yes, no, on and off as true and false; {words}"
    if schema.get("type") in ("number", "integer"):
        return _number_hint(place, value, schema)
    if schema.get("type") == "string" and not isinstance(value, (str, list, Mapping)):
        return "put it in quotes"
    if isinstance(value, str) and "pattern" in schema and (meant := _tidied(value, schema["pattern"])):
        return f"write {meant}"
    if isinstance(value, str) and "enum" in schema:
        near = get_close_matches(value.strip(), [str(each) for each in schema["enum"]], n=1)
        return f"did you mean {near[0]!r}?" if near else ""
    return ""


def _number_hint(place: Place, value: Any, schema: Schema) -> str:
    if isinstance(value, str):
        return next((words for pattern, words in NO_NUMBERS if re.fullmatch(pattern, value)), "")
    if not isinstance(value, (int, float)) or abs(value) > sys.float_info.max:
        return ""
    return next(
        (
            f"was it given in {unit}? Write {value * factor:.6g}"
            for unit, factor in _units(place)
            if _likely(value * factor, schema)
        ),
        "",
    )


def _units(place: Place) -> tuple[tuple[str, float], ...]:
    """Other units of a place, by the last of its keys that names one."""
    for key in reversed([part for part in place if isinstance(part, str)]):
        if key in SHARES:
            return UNITS["share"]
        fitting = [unit for unit in UNITS if key == unit or key.endswith(f"_{unit}")]
        if fitting:
            return UNITS[max(fitting, key=len)]
    return ()


def _likely(value: float, schema: Schema) -> bool:
    """Whether it lies in the limits, and is no crumb of the highest."""
    highest = schema.get("maximum", schema.get("exclusiveMaximum", 0.0))
    return abs(value) >= highest / 500 and _within(value, schema)


def _within(value: float, schema: Schema) -> bool:
    return (
        schema.get("minimum", value) <= value <= schema.get("maximum", value)
        and ("exclusiveMinimum" not in schema or value > schema["exclusiveMinimum"])
        and ("exclusiveMaximum" not in schema or value < schema["exclusiveMaximum"])
    )


def _tidied(text: str, pattern: str) -> str:
    """The text in lower case, without blanks at its ends, where the pattern asks for it; else nothing."""
    meant = text.strip().lower().replace(" ", "_").replace("-", "_")
    return meant if re.search(pattern, meant) else ""


def _unknown_keys(error: ValidationError) -> list[str]:
    known, patterns = error.schema.get("properties", {}), error.schema.get("patternProperties", {})
    return sorted(
        key
        for key in map(str, error.instance)
        if key not in known and not any(re.search(p, key) for p in patterns)
    )


def _unknown(place: Place, key: str, schema: Schema) -> str:
    known, patterns = sorted(schema.get("properties", {})), list(schema.get("patternProperties", {}))
    near = get_close_matches(key, known, n=1) or get_close_matches(key.strip().lower(), known, n=1)
    where = f"{dotted(place)} has no key {key!r}" if place else f"there is no key {key!r}"
    if near:
        return f"{where}; did you mean {near[0]!r}?"
    if patterns:
        meant = _tidied(key, patterns[0])
        return f"{where}: a name has {_letters(patterns[0])} only{f'; write {meant}' if meant else ''}"
    return f"{where}; choose one of: {', '.join(known)}"
