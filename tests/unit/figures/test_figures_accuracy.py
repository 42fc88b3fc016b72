"""Figures of accuracy draw every parameter, mark today's setting, and show an error of zero on a log axis."""

import numpy as np
import pandas as pd
import pytest
import yaml
from conftest import title

from mammosim.chain.quantities import QUANTITIES
from mammosim.figures import accuracy as figures
from mammosim.figures.style import VERMILION
from mammosim.study.accuracy.error_budget import budget
from mammosim.study.accuracy.errors import orders


@pytest.fixture
def table():
    """Five parameters with four values each, of second order, in two quantities."""
    rows = []
    names = ("element_size", "newton_tolerance", "voxels", "dose_photons", "contact_depth")
    for number, parameter in enumerate(names):
        for place, h in enumerate((8.0, 4.0, 2.0, 1.0)):
            for quantity, scale in (("nipple_mm", 0.1), ("agd_percent", 1.0)):
                distance, left = scale * (h**2 - 1) * 3.0**-number, scale * (number % 2) * 3.0**-number
                error = distance + left
                about = {"stage": "mesh", "parameter": parameter, "value": f"{h:g}", "size": h}
                about |= {"error": error, "distance": distance, "left": left, "noise": 0.02 * error}
                about |= {"seconds": 40 / h**2, "seconds_spread": 1 / h**2}
                about |= {"today": place == 2, "reference": place == 3, "quantity": quantity}
                rows.append(about)
    same = {"stochastic": False, "outcome": "converged", "memory_mb": 300.0, "repeats": 2, "settings": "{}"}
    return pd.DataFrame(rows).assign(**same)


def test_every_parameter_is_a_picture_with_todays_setting_marked(table):
    figure = figures.accuracy(table, "agd_percent")
    titled = [ax for ax in figure.axes if ax.get_title(loc="left")]
    assert len(titled) == 5
    for ax in titled:
        rings = [line for line in ax.lines if line.get_markeredgecolor() == VERMILION]
        assert len(rings) == 1
        heights = np.concatenate([line.get_ydata() for line in ax.lines])
        assert np.all(heights > 0), "a reference is drawn, also where its error is zero"


def test_a_parameter_of_which_nothing_can_be_said_is_left_out(table):
    table.loc[table.parameter == "voxels", "error"] = np.nan
    figure = figures.accuracy(table, "nipple_mm")
    assert "voxels" not in [title(ax) for ax in figure.axes]


def test_orders_and_budget_name_every_parameter_and_quantity(table):
    names = [label.get_text() for label in figures.orders(orders(table)).axes[0].get_yticklabels()]
    assert len(names) == 10
    assert "element size: nipple_mm" in names
    shares = figures.budget(budget(table))
    assert [label.get_text() for label in shares.axes[0].get_yticklabels()] == ["agd percent", "nipple mm"]
    widths = [bar.get_width() for bar in shares.axes[0].patches]
    assert sum(widths) == pytest.approx(200)


def test_memory_is_a_dot_per_value_with_todays_in_a_ring(table):
    ax = figures.memory(table).axes[0]
    assert [len(dots.get_offsets()) for dots in ax.collections] == [4] * 5
    assert sum(line.get_markeredgecolor() == VERMILION for line in ax.lines) == 5


def test_the_page_has_a_caption_for_every_quantity(repository):
    page = yaml.safe_load((repository / "workflow/report/accuracy.yaml").read_text())
    prefixes = [name for section in page["sections"] for name in section.get("figures", {})]
    for quantity in QUANTITIES:
        assert any(f"accuracy_{quantity}_".startswith(f"{prefix}_") for prefix in prefixes), quantity


def test_a_unit_stands_in_the_name():
    units = [figures.unit_of(name) for name in ("force_n", "d_percent", "scatter_to_primary")]
    assert units == ["N", "%", "-"]
