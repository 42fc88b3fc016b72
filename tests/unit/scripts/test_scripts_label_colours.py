"""The colours beside the label maps are those of the figures."""

from mammosim.core.labels import Label
from mammosim.figures.style import TISSUE_COLOURS


def test_both_programs_are_given_every_label_in_the_colours_of_the_figures(script, tmp_path):
    slicer, snap = tmp_path / "tissues.ctbl", tmp_path / "tissues.txt"
    script("label_colours").main(str(slicer), str(snap))
    for label in list(Label)[1:]:
        r, g, b = (int(TISSUE_COLOURS[label][n : n + 2], 16) for n in (1, 3, 5))
        assert f"\n{label:d} {label.tissue} {r} {g} {b} 255\n" in slicer.read_text()
        row = next(line for line in snap.read_text().splitlines() if f'"{label.tissue}"' in line)
        assert row.split()[:4] == [str(n) for n in (label.value, r, g, b)]
