"""What the codes of label maps mean: presets, tables, and names of other programs as tissues.

Light: it is imported where the table of volunteers is checked.
"""

import re
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from pathlib import Path

from mammosim.core.errors import ConfigurationError
from mammosim.core.labels import Label
from mammosim.io.plain import tabulated_plain

# Beside Label, in a map of tissues: fat and gland under one code, and voxels that nobody labelled.
BREAST, IGNORE = 253, 254
TISSUES = {**{label.tissue: int(label) for label in Label}, "breast": BREAST, "ignore": IGNORE}
OWN = "mammosim"  # the preset of this program's own codes
COLUMNS = ("code", "tissue")  # of a table that explains codes
ELSEWHERE = "outside"  # tissue of a code whose voxels are explained by another file only
SNAP = re.compile(r'^\s*(-?\d+)\s+\d+\s+\d+\s+\d+\s+[\d.]+\s+\d+\s+\d+\s+"(.*)"\s*$')
SIDES = re.compile(r"\b(left|right|l|r)\b")


def fits(found: Iterable[int]) -> str:
    """Which presets have all of these codes, in words."""
    fitting = [name for name, meaning in presets().items() if set(found) <= set(meaning)]
    return f"fits preset {' or '.join(fitting)}" if fitting else f"presets are: {', '.join(presets())}"


@cache
def presets() -> dict[str, dict[int, str]]:
    """Preset -> code -> tissue."""
    found: dict[str, dict[int, str]] = {}
    for row in tabulated_plain("label_codes"):
        found.setdefault(row["preset"], {})[int(row["code"])] = row["tissue"]
    return found


def is_preset(codes: str) -> bool:
    """Whether this names a preset, and no file."""
    return codes in presets()


def explained(path: str) -> Mapping[int, str]:
    """Code -> tissue of a file. Raises ConfigurationError where there is none, or it is another kind."""
    if not Path(path).is_file():
        raise ConfigurationError(
            f"codes {path!r} is no file and no preset; presets are: {', '.join(presets())}"
        )
    readers: Mapping[str, Callable[[str], Mapping[int, str]]] = {
        ".json": _of_nnunet, ".tsv": _of_table, ".csv": _of_table,
    }  # fmt: skip
    return readers.get(Path(path).suffix.lower(), _of_snap)(path)


def _of_table(path: str) -> Mapping[int, str]:
    from mammosim.io.given import given_table  # it needs pandas, which a start of the workflow does without

    table = given_table(path, error=ConfigurationError, columns=COLUMNS, comments=True)
    table = table.rename(columns=str.lower)
    if not set(COLUMNS) <= set(table):
        raise ConfigurationError(f"{path} has the columns {', '.join(table)}; it needs code and tissue")
    tissues = [str(name).lower() for name in table["tissue"]]
    found: dict[int, str] = {}
    for row, (code, tissue) in enumerate(zip(table["code"], tissues), 1):
        where = f"{path}: row {row}, column"
        if not _is_whole(str(code).removesuffix(".0")):
            raise ConfigurationError(f"{where} code: a code is no whole number; write 0, 1, -2")
        if tissue not in TISSUES:
            meant = meaning_of(tissue)
            advice = f"did you mean {meant}?" if meant else f"choose among: {', '.join(TISSUES)}"
            raise ConfigurationError(f"{where} tissue: it names no tissue; {advice}")
        if (number := int(float(code))) in found:
            raise ConfigurationError(f"{where} code: a code stands twice; give each one row")
        found[number] = tissue
    return found


def _of_snap(path: str) -> Mapping[int, str]:
    from mammosim.io.given import given_text

    lines = given_text(path).splitlines()
    found = {int(match[1]): match[2] for line in lines if (match := SNAP.match(line))}
    if not found:
        raise ConfigurationError(
            f"{path} is no label description file of ITK-SNAP; nor .tsv, .csv, or nnU-Net's .json"
        )
    return of_names(found)


def _of_nnunet(path: str) -> Mapping[int, str]:
    """nnU-Net writes names with codes, its first version codes with names; of regions nothing can be said."""
    from mammosim.io.given import given_json

    try:
        labels = given_json(path, error=ConfigurationError)["labels"]
        pairs = [(code, name) if _is_whole(code) else (name, code) for code, name in labels.items()]
        return of_names({int(code): str(name) for code, name in pairs})
    except (ValueError, KeyError, TypeError, AttributeError):
        raise ConfigurationError(
            f"{path} has no `labels` with a whole number each, as nnU-Net writes; export it again, or give a "
            "table of code and tissue"
        ) from None


def _is_whole(text: str) -> bool:
    return bool(re.fullmatch(r"-?\d+", text))


def of_names(names: Mapping[int, str]) -> Mapping[int, str]:
    """Code -> tissue, '' for a name of none, which no message shows: it is free text, maybe a patient's."""
    return {0: "air", **{code: meaning_of(name) for code, name in names.items()}}


def meaning_of(name: str) -> str:
    """The tissue that a name stands for, '' for none."""
    words = re.sub(r"[^a-z]+", " ", name.lower().replace("'s", ""))
    plain = " ".join(SIDES.sub(" ", words).split())
    return _names().get(plain, "")


@cache
def _names() -> dict[str, str]:
    return {row["name"]: row["tissue"] for row in tabulated_plain("label_names")}
