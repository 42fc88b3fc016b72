"""What the codes of label maps mean: presets, tables, and names of other programs as tissues.

Light: it is imported where the table of volunteers is checked.
"""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path

from mammosim.core.errors import ConfigurationError
from mammosim.core.labels import Label
from mammosim.io.plain import repeated, tabulated_plain

# Beside Label, in a map of tissues: fat and gland under one code, and voxels that nobody labelled.
BREAST, IGNORE = 253, 254
TISSUES = {**{label.tissue: int(label) for label in Label}, "breast": BREAST, "ignore": IGNORE}
OWN = "mammosim"  # the preset of this program's own codes
COLUMNS = ("code", "tissue")  # of a table that explains codes
ELSEWHERE = "outside"  # tissue of a code whose voxels are explained by another file only
SNAP = re.compile(r'\s*(-?\d+)(?:\s+\d+){3}\s+[\d.eE+-]+(?:\s+\d+){2}\s+"(.*)"\s*')
SLICER = re.compile(r"\s*(\d+)\s+(\S+)(?:\s+[\d.]+){4}\s*")  # blanks in names are written as _
SLICER_COLUMNS = ("labelvalue", "name")  # of a colour table as .csv, since Slicer 5.8
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
    return readers.get(Path(path).suffix.lower(), _of_lines)(path)


def _of_table(path: str) -> Mapping[int, str]:
    from mammosim.io.given import given_table  # it needs pandas, which a start of the workflow does without

    table = given_table(path, error=ConfigurationError, columns=COLUMNS, comments=True)
    table = table.rename(columns=str.lower)
    if set(SLICER_COLUMNS) <= set(table):
        rows = table[list(SLICER_COLUMNS)].itertuples(index=False)
        return _of_pairs([(_code(code, n, path), str(name)) for n, (code, name) in enumerate(rows, 1)], path)
    if not set(COLUMNS) <= set(table):
        raise ConfigurationError(f"{path} has the columns {', '.join(table)}; it needs code and tissue")
    tissues = [str(name).lower() for name in table["tissue"]]
    found: dict[int, str] = {}
    for row, (code, tissue) in enumerate(zip(table["code"], tissues), 1):
        where, number = f"{path}: row {row}, column", _code(code, row, path)
        if tissue not in TISSUES:
            meant = meaning_of(tissue)
            advice = f"did you mean {meant}?" if meant else f"choose among: {', '.join(TISSUES)}"
            raise ConfigurationError(f"{where} tissue: it names no tissue; {advice}")
        if number in found:
            raise ConfigurationError(f"{where} code: a code stands twice; give each one row")
        found[number] = tissue
    return found


def _code(code: object, row: int, path: str) -> int:
    """The code of a row. Raises ConfigurationError where it is no whole number."""
    if not _is_whole(text := str(code).removesuffix(".0")):
        raise ConfigurationError(f"{path}: row {row}, column code: a code is no whole number; write 0, 1, -2")
    return int(text)


def _of_lines(path: str) -> Mapping[int, str]:
    """Of a label description file of ITK-SNAP, or a colour table of 3D Slicer (.ctbl, .txt)."""
    from mammosim.io.given import given_text

    lines = enumerate(given_text(path).splitlines(), 1)
    rows = [(number, line) for number, line in lines if line.strip() and not line.lstrip().startswith("#")]
    found = [SNAP.fullmatch(line) or SLICER.fullmatch(line) for _, line in rows]
    if not any(found):
        raise ConfigurationError(
            f"{path} is no label description file of ITK-SNAP and no colour table of 3D Slicer; nor .tsv, "
            ".csv, or nnU-Net's .json"
        )
    if odd := [number for (number, _), match in zip(rows, found) if not match]:
        raise ConfigurationError(
            f"{path}: line {odd[0]} is no label as the other lines are; correct it, or begin it with #"
        )
    return _of_pairs([(int(match[1]), match[2]) for match in found if match], path)


def _of_pairs(pairs: Sequence[tuple[int, str]], path: str) -> Mapping[int, str]:
    """Code -> tissue by names. Raises ConfigurationError where a code stands twice."""
    if twice := repeated([code for code, _ in pairs]):
        raise ConfigurationError(f"{path}: code {twice[0]} has two names; give it one")
    return of_names(dict(pairs))


def _of_nnunet(path: str) -> Mapping[int, str]:
    """nnU-Net writes names with codes, its first version codes with names; of regions nothing can be said."""
    from mammosim.io.given import given_json

    try:
        labels = given_json(path, error=ConfigurationError)["labels"]
        pairs = [(code, name) if _is_whole(code) else (name, code) for code, name in labels.items()]
    except (ValueError, KeyError, TypeError, AttributeError):
        pairs = []
    if not pairs or not all(_is_whole(str(code)) for code, _ in pairs):
        raise ConfigurationError(
            f"{path} has no `labels` with a whole number each, as nnU-Net writes where they are no regions; "
            "export it again, or give a table of code and tissue"
        )
    return _of_pairs([(int(code), str(name)) for code, name in pairs], path)


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
