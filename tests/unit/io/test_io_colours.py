"""Programs that show label maps find the name and the colour of every value."""

import re
from pathlib import Path

from mammosim.core.labels import Label
from mammosim.io.colours import write_slicer_colours, write_snap_labels

COLOURS = {label: f"#{label:d}0{label:d}1ff" for label in Label}


def test_slicer_finds_a_line_for_every_value(tmp_path: Path) -> None:
    write_slicer_colours(COLOURS, tmp_path / "tissues.ctbl")
    rows = [
        line.split()
        for line in (tmp_path / "tissues.ctbl").read_text().splitlines()
        if not line.startswith("#")
    ]
    assert [(int(value), name) for value, name, *_ in rows] == [(label, label.tissue) for label in Label]
    assert [list(map(int, rest)) for _, _, *rest in rows][1:3] == [
        [0x10, 0x11, 255, 255],
        [0x20, 0x21, 255, 255],
    ]
    assert rows[Label.AIR][-1] == "0", "air is transparent"


def test_itk_snap_finds_a_line_of_eight_fields_for_every_value(tmp_path: Path) -> None:
    write_snap_labels(COLOURS, tmp_path / "tissues.txt")
    rows = [line for line in (tmp_path / "tissues.txt").read_text().splitlines() if not line.startswith("#")]
    fields = [
        re.fullmatch(r'\s*(\d+)\s+(\d+)\s+(\d+)\s+(\d+)\s+([01])\s+([01])\s+([01])\s+"(.+)"', row)
        for row in rows
    ]
    assert [int(found[1]) for found in fields] == list(Label)
    assert [found[8] for found in fields] == ["Clear Label", *(label.tissue for label in Label if label)]
    assert [int(n) for n in fields[Label.SKIN].groups()[1:7]] == [0x30, 0x31, 255, 1, 1, 1]
