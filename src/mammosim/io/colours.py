"""Names and colours of the labels as 3D Slicer and ITK-SNAP read them, to be loaded beside a label map."""

from collections.abc import Mapping
from pathlib import Path

from mammosim.core.labels import Label
from mammosim.io.atomic import replacing

Colours = Mapping[Label, str]  # "#rrggbb"; the air is transparent
SNAP_HEAD = """\
################################################
# ITK-SnAP Label Description File
# File format:
# IDX   -R-  -G-  -B-  -A--  VIS MSH  LABEL
# Fields:
#    IDX:   Zero-based index
#    -R-:   Red color component (0..255)
#    -G-:   Green color component (0..255)
#    -B-:   Blue color component (0..255)
#    -A-:   Label transparency (0.00 .. 1.00)
#    VIS:   Label visibility (0 or 1)
#    IDX:   Label mesh visibility (0 or 1)
#  LABEL:   Label description
################################################
"""


def write_slicer_colours(colours: Colours, path: str | Path) -> None:
    """Write a colour table `.ctbl`, complete or absent: value, name, red, green, blue, opacity of a label."""
    rows = [
        f"{label:d} {label.tissue} {' '.join(map(str, _rgb(colour)))} {0 if label is Label.AIR else 255}\n"
        for label, colour in colours.items()
    ]
    _write(f"# Color table file {Path(path).name}\n# {len(rows)} values\n{''.join(rows)}", path)


def write_snap_labels(colours: Colours, path: str | Path) -> None:
    """Write ITK-SNAP's label descriptions `.txt`, complete or absent."""
    rows = []
    for label, colour in colours.items():
        r, g, b = (0, 0, 0) if label is Label.AIR else _rgb(colour)
        seen, name = (0, "Clear Label") if label is Label.AIR else (1, label.tissue)
        rows.append(f'{label:5d} {r:5d} {g:4d} {b:4d} {seen:8d} {seen:2d} {seen:2d}    "{name}"\n')
    _write(SNAP_HEAD + "".join(rows), path)


def _rgb(colour: str) -> tuple[int, ...]:
    return tuple(bytes.fromhex(colour.removeprefix("#")))


def _write(text: str, path: str | Path) -> None:
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
