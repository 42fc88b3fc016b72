"""Spectra of mammographic beams: photons against energy, and their half-value layers."""

import pandas as pd
from matplotlib.figure import Figure

from mammosim.figures.style import INK, QUIET, SERIES, new_figure, styled


@styled
def spectra(table: pd.DataFrame, quality: pd.DataFrame) -> Figure:
    """The first beam over the others; beside it the half-value layer of each, before and behind the paddle.

    table: energy_kev, photons_per_mm2_mas, beam; quality: rows of xray.quality.quality_table of these beams.
    """
    figure = new_figure(3.0)
    left, right = figure.subplots(1, 2, width_ratios=(1.5, 1))
    names = list(quality.beam)
    for number, name in reversed(list(enumerate(names))):
        rows = table[table.beam == name]
        share = rows.photons_per_mm2_mas / rows.photons_per_mm2_mas.sum()
        colour, width = (INK, 2.0) if number == 0 else (SERIES[(number - 1) % len(SERIES)], 1.0)
        left.plot(rows.energy_kev, share, color=colour, lw=width, label=name)
    left.set(xlabel="energy (keV)", ylabel="share of the photons")
    left.set_ylim(bottom=0)
    left.legend(reverse=True, fontsize=7)
    places = range(len(names))
    right.barh(places, quality.hvl_behind_mm_al, color=QUIET, height=0.6, label="behind the paddle")
    right.plot(quality.hvl_mm_al, places, "o", color=INK, ms=4, label="before it")
    right.set_yticks(places, names, fontsize=7)
    right.invert_yaxis()
    right.set(xlabel="half-value layer (mm Al)")
    right.grid(False, axis="y")
    right.legend(fontsize=7, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    return figure
