"""The files that a path of the table of volunteers stands for: of a folder, and the data beside a header."""

import re
from collections.abc import Iterable
from hashlib import sha256
from pathlib import Path

from mammosim.io.hidden import is_hidden

DETACHED = re.compile(r"^\s*(?:ElementDataFile\s*=|data ?file:)\s*(?P<name>[^\n]+?)\s*$", re.I | re.M)
HEADERS = (".mhd", ".nhdr")
INSIDE = ("local", "list")  # no name of a file: the data follow, or a list of names does
HEAD = 4096  # bytes: the identifiers of a DICOM file stand among the first


def parts(path: str) -> list[str]:
    """All files below a folder, or a file with those that its header names; of an empty path nothing.

    Without those that a system leaves beside them, and that no reader opens.
    """
    if not path:
        return []
    place = Path(path)
    if place.is_dir():
        files = (file for file in place.rglob("*") if file.is_file())
        return sorted(str(file) for file in files if not is_hidden(file.relative_to(place)))
    if not place.is_file():
        return []
    return [path, *_detached(place)]


def _detached(header: Path) -> list[str]:
    """The data that a header of MetaImage or NRRD names."""
    if header.suffix.lower() not in HEADERS:
        return []
    text = header.read_text(encoding="latin-1")
    found = DETACHED.search(text)
    if found is None:
        return []
    first = found["name"]
    names = text[found.end() :].split("\n") if first.lower().startswith(INSIDE) else [first]
    files = [header.parent / name.strip() for name in names if name.strip()]
    return [str(file) for file in files if file.is_file()]


def recorded(files: Iterable[str]) -> list[str]:
    """The files that a workflow can record by their names; the others it knows by `heads` alone.

    Snakemake takes braces for wildcards, and ends where a name is no UTF-8 or has a line break.
    """
    return [file for file in files if _is_utf8(file) and not set(file) & set("{}\r\n")]


def _is_utf8(name: str) -> bool:
    try:
        name.encode("utf-8")
    except UnicodeEncodeError:
        return False
    return True


def heads(files: Iterable[str]) -> str:
    """16 hex digits of the sizes and the first bytes of files, in their order: other images have others.

    A file that was overwritten by one with an older date is found by them; one with a newer date, by that.
    """
    found = sha256()
    for file in files:
        with Path(file).open("rb") as opened:
            found.update(f"{Path(file).stat().st_size} ".encode() + opened.read(HEAD))
    return found.hexdigest()[:16]
