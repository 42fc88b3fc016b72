"""Draw the picture of README from a finished study: a breast pressed as usual and less, its dose and d'."""

import sys
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mammosim.figures.style import BLUE, VERMILION, styled
from mammosim.io.images import read_image
from mammosim.io.tables import read_table

PICTURE = Path(__file__).resolve().parents[1] / "docs/pictures/result.png"
VOLUNTEER, SIDE, STRATEGIES = "large", "left", ("standard", "reduced")
# Attenuation, -ln(transmission), that is drawn black and white.
BLACK, WHITE = 0.5, 5.0
MARGIN_MM = 8.0
PANELS = {"dose_mgy": "glandular dose (mGy)", "calcification_d_expected": "calcifications, d'"}


def draw_mammogram(ax: Axes, path: Path, title: str) -> None:
    """One mammogram, the chest wall at the left, mm."""
    layers = read_image(path)
    image, pixel = layers.values[0], float(layers.grid.spacing[0])
    shown = np.log(np.percentile(image, 99) / np.maximum(image, 1e-6 * image.max())).T
    extent = (0, shown.shape[1] * pixel, shown.shape[0] * pixel, 0)
    ax.imshow(shown, cmap="gray", vmin=BLACK, vmax=WHITE, extent=extent)
    rows = np.flatnonzero((shown > BLACK).any(axis=1)) * pixel
    limits = (rows.max() + MARGIN_MM, rows.min() - MARGIN_MM)
    ax.set(title=title, xlim=(0, 75), ylim=limits, xlabel="mm from the chest wall", yticks=[])
    ax.grid(False)


def draw_against_thickness(ax: Axes, table: pd.DataFrame, column: str) -> None:
    """One quantity of every strategy, a line for each woman."""
    for colour, (name, rows) in zip((BLUE, VERMILION), table.groupby("volunteer")):
        rows = rows.sort_values("thickness_mm")
        ax.plot(rows.thickness_mm, rows[column], "o-", color=colour, label=name, markersize=4)
    ax.set(ylabel=PANELS[column], ylim=(0, 1.1 * table[column].max()))


@styled
def result(results: Path) -> Figure:
    """Two mammograms of one breast, and dose and d' against thickness, of all that were X-rayed."""
    table = read_table(results / "study/trade_off.csv")
    figure = Figure(figsize=(7.6, 3.6), layout="constrained")
    grid = figure.add_gridspec(2, 3, width_ratios=(1, 1, 2.2))
    here = table[(table.volunteer == VOLUNTEER) & (table.side == SIDE)].set_index("strategy")
    for column, strategy in enumerate(STRATEGIES):
        path = results / f"xray/{VOLUNTEER}/{SIDE}/{strategy}_gravity_mammogram.nii.gz"
        title = f"{here.thickness_mm[strategy]:.0f} mm, {here.force_n[strategy]:.1f} N"
        draw_mammogram(figure.add_subplot(grid[:, column]), path, title)
    for row, column in enumerate(PANELS):
        ax = figure.add_subplot(grid[row, 2])
        draw_against_thickness(ax, table, column)
    ax.set_xlabel("compressed thickness (mm)")
    ax.legend(title="digital volunteer", loc="lower right")
    return figure


if __name__ == "__main__":
    PICTURE.parent.mkdir(exist_ok=True)
    result(Path(sys.argv[1] if len(sys.argv) > 1 else "results")).savefig(PICTURE, dpi=120)
    sys.stdout.write(f"{PICTURE}: {PICTURE.stat().st_size / 1000:.0f} kB\n")
