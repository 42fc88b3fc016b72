"""The picture of README is drawn from the files of a study."""

import importlib.util

import numpy as np
import pandas as pd
import pytest

from mammosim.core.volume import Grid, Image
from mammosim.io.images import write_image
from mammosim.io.tables import write_table


@pytest.fixture
def tool(repository):
    place = repository / "tools/draw_result.py"
    spec = importlib.util.spec_from_file_location("draw_result", place)
    found = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(found)
    return found


def mammogram(path):
    """Half a disc of breast before the chest wall, three layers as the study keeps them."""
    v, u = np.meshgrid(np.arange(60), np.arange(80), indexing="ij")
    signal = np.where(np.hypot(v, u - 40) < 30, 5.0, 100.0)
    layers = np.stack([signal, np.zeros_like(signal), np.zeros_like(signal)])
    path.parent.mkdir(parents=True, exist_ok=True)
    grid = Grid(layers.shape, np.ones(3), np.zeros(3))
    write_image(Image(grid, layers.astype(np.float32)), path)


def test_the_picture_of_a_study_is_drawn(tool, tmp_path):
    rows = [
        ("large", "left", "standard", 60.0, 2.6, 2.5, 7.4),
        ("large", "left", "reduced", 82.0, 1.3, 5.2, 6.5),
        ("small", "left", "standard", 45.0, 1.5, 2.1, 10.0),
    ]
    columns = ["volunteer", "side", "strategy", "thickness_mm", "force_n", *tool.PANELS]
    (tmp_path / "study").mkdir()
    write_table(pd.DataFrame(rows, columns=columns), tmp_path / "study/trade_off.csv")
    for strategy in tool.STRATEGIES:
        mammogram(tmp_path / f"xray/large/left/{strategy}_gravity_mammogram.nii.gz")
    figure = tool.result(tmp_path)
    titles = [ax.get_title(loc="left")[3:] for ax in figure.axes]
    assert titles[:2] == ["60 mm, 2.6 N", "82 mm, 1.3 N"]
    top, bottom = figure.axes[0].get_ylim()[::-1]
    assert (top, bottom) == pytest.approx((11 - tool.MARGIN_MM, 69 + tool.MARGIN_MM)), (
        "the breast, with a margin"
    )
    lines = figure.axes[2].get_lines()
    assert [list(line.get_xdata()) for line in lines] == [[60, 82], [45]]
