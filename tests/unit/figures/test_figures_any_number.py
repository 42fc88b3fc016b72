"""One of anything, or a hundred: nothing is lost, colours differ, and no name lies over another one."""

import re
from collections.abc import Callable
from functools import cache
from itertools import pairwise, product
from typing import Any

import numpy as np
import pandas as pd
import pytest
from conftest import make_mesh, title
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from mammosim.figures import (
    accuracy,
    deformation,
    dose,
    hard_cases,
    identification,
    literature,
    peers,
    scenes,
    status,
    strategies,
    unloading,
    validation,
)
from mammosim.figures import models as published
from mammosim.figures.render import render
from mammosim.figures.series import LISTED, SAMPLE, colours, lines, markers, numbered, some
from mammosim.figures.style import SERIES
from mammosim.io.tabulated import tabulated
from mammosim.study.peers.summary import FOLLOWED, OURS

# Figures of a panel each, which take seconds to lay out: 16 of them do what 100 do.
PANELLED = {
    *("convergence, women", "thickness, strategies", "report 195, beams"),
    *("accuracy, parameters", "programs' cases", "models, positions"),
}
SKIN = make_mesh((4, 2, 4), height=52.0)
MARKS = strategies.Marks((50.0, 180.0), "practice", 10.0, "a standard")


def names(n: int, stem: str = "name") -> list[str]:
    return [f"{stem}_{k:02d}" for k in range(n)]


def table(**columns: Any) -> pd.DataFrame:
    """All combinations of what is a list; the rest is the same in each row, or of the row's number."""
    lists = {name: values for name, values in columns.items() if isinstance(values, list)}
    rows = [dict(zip(lists, each)) for each in product(*lists.values())]
    for k, row in enumerate(rows):
        row |= {name: v(k) if callable(v) else v for name, v in columns.items() if name not in lists}
    return pd.DataFrame(rows)


def moduli(n: int) -> list[float]:
    return [float(E) for E in np.geomspace(0.1, 30, n)]


def sweep(women: int, values: int) -> Figure:
    rows = table(volunteer=names(women), youngs_modulus_kpa=moduli(values), nipple_left_mm=lambda k: 1.0 + k,
                 nipple_right_mm=2.0, max_displacement_mm=9.0, supine_left_mm=30.0, supine_right_mm=28.0,
                 outcome="converged")  # fmt: skip
    rows.loc[rows.youngs_modulus_kpa == rows.youngs_modulus_kpa.min(), "outcome"] = "failed: unloading: -"
    return deformation.sweep(rows)


def searched(women: int, methods: int, values: int) -> Figure:
    rows = table(volunteer=names(women), method=names(methods, "way"), youngs_modulus_kpa=moduli(values),
                 outcome="converged", error_mean_mm=1e-3, round_max_mm=0.05,
                 forward_solves=lambda k: 2.0 + k)  # fmt: skip
    rows.loc[::7, "outcome"] = "failed: -"
    return unloading.unloading(rows)


def paths(women: int, ways: int, sets: int) -> Figure:
    rows = table(volunteer=names(women), side="left", strategy=names(ways, "way"), moduli=names(sets, "set"),
                 thickness_mm=[70.0, 60.0, 50.0], force_n=lambda k: 10.0 + k % 90, contact_area_mm2=4e3,
                 mean_pressure_kpa=5.0, peak_pressure_kpa=9.0)  # fmt: skip
    return strategies.curves(rows, MARKS)


def above(women: int, ways: int, sets: int) -> Figure:
    rows = table(volunteer=names(women), side="left", strategy=names(ways, "way"), moduli=names(sets, "set"),
                 measure=["logarithmic", "energy_kpa"], threshold=[0.25, 1.0], tissue="all", unit="cm3",
                 amount=lambda k: 1.0 + k % 9)  # fmt: skip
    return strategies.amounts(rows)


def traded(women: int, ways: int) -> Figure:
    rows = table(volunteer=names(women), side="left", strategy=names(ways, "way"),
                 thickness_mm=lambda k: 40.0 + k % 31, dose_mgy=lambda k: 1 + k % 7 / 7, dose_se_mgy=0.02,
                 mas=55.0, scatter_to_primary=0.5, cnr_quantum=3.0, calcification_cnr=2.0,
                 calcification_d_expected=5.0)  # fmt: skip
    return dose.trade_off(rows)


def routes(women: int, ways: int) -> Figure:
    rows = table(volunteer=names(women), side="left", route=names(ways, "route"), protocol="a protocol",
                 agd_mgy_per_mgy=lambda k: 0.2 + k % 9 / 90, standard_error=0.01)  # fmt: skip
    standard = rows[rows.volunteer == "name_00"].assign(thickness_mm=50.0, glandularity_percent=50.0)
    return dose.dose_routes(rows, standard)


def beams(n: int) -> Figure:
    rows = table(beam=names(n), energy_kev=[10.0, 20.0, 28.0], photons_per_mm2_mas=lambda k: 1.0 + k)
    quality = pd.DataFrame({"beam": names(n), "hvl_mm_al": 0.4, "hvl_behind_mm_al": 0.5})
    return dose.spectra(rows, quality)


def energies(n_beam: int, n: int) -> Figure:
    rows = table(beam=names(n_beam), quantity=names(n, "region"), gate_percent=1.0,
                 difference_percent=lambda k: k % 3 - 1.0, within=True, standard_error_ev=1.0,
                 reference_ev=100.0)  # fmt: skip
    return dose.report195(rows)


def soft(women: int, factors: int) -> Figure:
    rows = table(volunteer=names(women), side="left", tissue=["glandular", "all"],
                 factor=[float(f) for f in np.linspace(0.7, 1.0, factors)], nipple_moved_mm=1.0, force_n=2.0,
                 thickness_mm=45.0, agd_mgy=lambda k: 1.0 + k % 5)  # fmt: skip
    return identification.softening(rows)


def propagated(women: int) -> Figure:
    quantities = [*identification.NIPPLE, "force_n", "agd_mgy"]
    rows = table(volunteer=names(women), side="left", quantity=quantities, fit=1.0, low=0.5, high=2.0,
                 measured=1.2)  # fmt: skip
    return identification.propagation(rows)


def found_again(women: int) -> Figure:
    rows = table(volunteer=names(women), side="left", tissue=["adipose", "skin"],
                 true_kpa=lambda k: 1.0 + k / 9, fitted_kpa=lambda k: 1.1 + k / 9, low_kpa=0.9, high_kpa=1.9,
                 inside_95=True, identifiable=True)  # fmt: skip
    return identification.recovery(rows)


def fitted(n: int) -> Figure:
    side = max(int(np.sqrt(n)), 1)
    grid = table(breast_kpa=moduli(side), skin_kpa=moduli(side), skin_rms_mm=lambda k: 1.0 + k)
    history = pd.DataFrame({"iteration": range(n), "skin_rms_mm": 1.0, "marker_rms_mm": 2.0})
    prior = {key: dict.fromkeys(identification.TISSUES, 2.0) for key in ("median_kpa", "factor")}
    rows = table(side=["left", "right"], tissue=list(identification.TISSUES), fitted_kpa=1.0, low_kpa=0.5,
                 high_kpa=2.0, identifiable=True)  # fmt: skip
    return identification.identification(grid, history, rows, prior)


def fits(women: int) -> pd.DataFrame:
    return table(volunteer=names(women), side="left", tissue=["adipose", "skin"], fitted_kpa=1.0, low_kpa=0.5,
                 high_kpa=2.0, identifiable=True)  # fmt: skip


def ratio() -> pd.DataFrame:
    return pd.DataFrame({"tissue": ["skin"], "ratio": [9.0], "ratio_low": [5.0], "ratio_high": [20.0],
                         "compression_kpa": [90.0]})  # fmt: skip


def errors(parameters: int, quantities: int) -> pd.DataFrame:
    return table(parameter=names(parameters), quantity=[f"{name}_mm" for name in names(quantities, "q")],
                 value=["1", "2"], error=lambda k: 0.1 + k % 5, noise=0.01, seconds=lambda k: 1.0 + k % 3,
                 seconds_spread=0.1, left=0.01, today=False, memory_mb=lambda k: 100.0 + k)  # fmt: skip


def convergence_orders(n: int) -> Figure:
    rows = table(parameter=names(n), quantity="q_mm", order=2.0, order_se=0.1, exponent=1.0, exponent_se=0.1)
    return accuracy.orders(rows)


def budgeted(quantities: int) -> Figure:
    rows = table(quantity=[f"{name}_mm" for name in names(quantities, "q")], parameter=names(7),
                 share_percent=100 / 7, total_error=1.0, next=False)  # fmt: skip
    return accuracy.budget(rows)


def solved_by(cases: int, programs: int) -> Figure:
    rows = table(case=names(cases, "case"), program=[OURS, *names(programs - 1)], unknowns=[2e4, 5e4],
                 cpu_s=lambda k: 1.0 + k, outcome="converged")  # fmt: skip
    return peers.processor_time(rows)


def done_by(programs: int, tasks: int) -> Figure:
    rows = table(task=names(tasks, "task"), program=[OURS, *names(programs - 1)], kind="view",
                 seconds=lambda k: 1.0 + k, histories_per_s=1e6, outcome="converged")  # fmt: skip
    rated = rows[rows.task == "task_00"].assign(task="dose", kind=FOLLOWED)
    return peers.tasks(pd.concat([rows, rated]), pd.DataFrame(columns=["what", "task", "target"]))


def screened(n_effect: int, n_scene: int) -> Figure:
    rows = table(scene=names(n_scene, "scene"), effect=names(n_effect, "effect"), quantity="force_n",
                 change=0.1, tolerance=0.2, included=True, reason="-")  # fmt: skip
    return scenes.effects(rows)


def answered(n: int) -> Figure:
    return scenes.scenes(table(scene=names(n), quantity="force_n", difference=0.1, tolerance=0.2, within=True,
                               seconds_full=9.0, seconds_screened=2.0))  # fmt: skip


def map_of() -> pd.DataFrame:
    return table(outward_mm=[1.0, 3.0, 5.0], across_mm=[-2.0, 0.0, 2.0], thickness_mm=lambda k: 40.0 + k)


def predicted(n: int) -> Figure:
    away = np.ones(len(SKIN.boundary_nodes("skin")))
    shapes = {"measured": SKIN, "predicted": SKIN}
    distances = {name: np.array([1.0, 2.0 + k]) for k, name in enumerate(names(n))}
    return validation.prediction(shapes, validation.SkinMap(SKIN, away), distances, x_mm=75.0, z_mm=0.0)


def models(n: int) -> Figure:
    return validation.wrong_model(table(position=names(n), quantity=list(validation.QUANTITIES), fitted=True,
                                        right_mm=1.0, wrong_mm=2.0))  # fmt: skip


def cases(n: int) -> Figure:
    return hard_cases.hard_cases(table(case=names(n), family="soft", outcome="converged", ok=True, error=0.1,
                                       within=1.0, seconds=3.0))  # fmt: skip


def stood(n: int) -> Figure:
    rows = pd.DataFrame({"skin_kpa": [0.0, *moduli(n)][:n], "max_displacement_mm": 20.0 - np.arange(n) / 9})
    return deformation.upright(dict.fromkeys(names(n), SKIN), rows, x_mm=75.0)


def test_where_a_breast_without_skin_has_no_equilibrium_nothing_is_compared_with_it():
    rows = pd.DataFrame({"skin_kpa": [0.0, 10.0], "max_displacement_mm": [np.nan, 61.9]})
    shown = [text.get_text() for text in deformation.upright({"skin": SKIN}, rows, x_mm=75.0).axes[1].texts]
    assert shown == ["", "61.9"]


def residuals(women: int, methods: int) -> Figure:
    rows = table(volunteer=names(women), method=names(methods, "way"), iteration=[0, 1, 2],
                 max_mm=lambda k: 9.0 - k % 3)  # fmt: skip
    return unloading.convergence(rows, tolerance_mm=0.1)


def compared(n: int) -> Figure:
    """Published models, of which every third found no force."""
    rows = table(title=names(n, "model"), nipple_prone_mm=1.0, nipple_supine_mm=lambda k: 2.0 + k % 5,
                 nipple_upright_mm=np.nan, stress_free_median_mm=lambda k: 1.0 + k % 3,
                 force_n=lambda k: np.nan if k % 3 == 2 else 1.0 + k, seconds=lambda k: 10.0 + k)  # fmt: skip
    return published.models(rows)


def distinct(ax: Axes) -> int:
    """How many colours its lines have."""
    return len({line.get_color() for line in ax.lines if len(line.get_xdata()) > 0})


def titled(figure: Figure) -> int:
    return sum(bool(ax.get_title(loc="left")) for ax in figure.axes)


def outlines(ax: Axes) -> int:
    return sum(isinstance(each, LineCollection) for each in ax.collections)


def bars(ax: Axes) -> int:
    return len(ax.patches)


def ticks(axis: Any) -> int:
    return len(axis.get_majorticklocs())


def unloaded(figure: Figure) -> int:
    """Lines of three moduli, of two methods each, in the panels of the first quantity."""
    panels = [ax for ax in figure.axes if ax.get_ylabel().startswith("error of the skin")]
    every = [line for ax in panels for line in ax.lines if line.get_marker() != "x"]
    return sum(len(line.get_xdata()) == 3 for line in every) // 2


def breasts_with_bars(figure: Figure) -> int:
    """Rows of two panels, or what one row says that it is of."""
    said = re.match(r"median of (\d+) breasts", title(figure.axes[0]))
    return int(said[1]) if said else len(figure.axes) // 2


def fits_beside(figure: Figure) -> int:
    """Of two tissues each; one more is in the legend."""
    colour = literature.COLOURS[literature.FITTED]
    return sum(line.get_color() == colour for line in figure.axes[0].lines) // 2


PUBLISHED = len(tabulated("published_biomechanics")) + 1


# What there is any number of -> how it is drawn, and how many of them the figure shows.
CASES: dict[str, tuple[Callable[[int], Figure], Callable[[Figure], int]]] = {
    "sweep, women": (lambda n: sweep(n, 3), lambda f: distinct(f.axes[1])),
    "sweep, moduli": (lambda n: sweep(2, n), lambda f: len(f.axes[1].lines[0].get_xdata())),
    "upright, skins": (stood, lambda f: bars(f.axes[1])),
    "stress-free shapes": (
        lambda n: deformation.stress_free(dict.fromkeys(names(n), SKIN), x_mm=75.0, z_mm=0.0),
        lambda f: outlines(f.axes[0]),
    ),
    "convergence, women": (lambda n: residuals(n, 2), titled),
    "convergence, methods": (lambda n: residuals(2, n), lambda f: distinct(f.axes[0]) - 1),
    "unloading, women": (lambda n: searched(n, 2, 3), unloaded),
    "unloading, methods": (lambda n: searched(2, n, 3), lambda f: distinct(f.axes[0])),
    "unloading, moduli": (lambda n: searched(2, 2, n), lambda f: len(f.axes[0].lines[0].get_xdata())),
    "curves, breasts": (lambda n: paths(n, 2, 1), lambda f: len(f.axes[1].lines) // 4),
    "curves, strategies": (lambda n: paths(2, n, 1), lambda f: distinct(f.axes[1])),
    "curves, sets of moduli": (
        lambda n: paths(1, 1, n),
        lambda f: sum(distinct(ax) for ax in f.axes[1::4]),
    ),
    "thickness, strategies": (
        lambda n: strategies.thickness_maps(dict.fromkeys(names(n), map_of())),
        titled,
    ),
    "amounts, women": (lambda n: above(n, 2, 1), breasts_with_bars),
    "amounts, strategies": (lambda n: above(1, n, 1), lambda f: bars(f.axes[0]) // 2),
    "amounts, sets of moduli": (lambda n: above(1, 1, n), lambda f: bars(f.axes[0]) // 2),
    "spectra, beams": (beams, lambda f: len(f.axes[0].lines)),
    "report 195, quantities": (lambda n: energies(2, n), lambda f: bars(f.axes[0])),
    "report 195, beams": (lambda n: energies(n, 2), titled),
    "dose, breasts": (lambda n: routes(n, 3), lambda f: ticks(f.axes[0].xaxis)),
    "dose, routes": (lambda n: routes(2, n), lambda f: len(f.axes[1].containers)),
    "trade-off, breasts": (lambda n: traded(n, 2), lambda f: distinct(f.axes[1])),
    "trade-off, strategies": (lambda n: traded(2, n), lambda f: len(f.axes[1].collections)),
    "softening, breasts": (lambda n: soft(n, 2), lambda f: distinct(f.axes[0])),
    "softening, factors": (lambda n: soft(2, n), lambda f: len(set(f.axes[0].lines[1].get_xdata()))),
    "propagation, women": (propagated, lambda f: ticks(f.axes[1].yaxis)),
    "recovery, women": (found_again, lambda f: (len(f.axes[0].lines) - 1) // 2),
    "fit, iterations": (fitted, lambda f: len(f.axes[1].lines[0].get_xdata())),
    "moduli, women": (
        lambda n: literature.moduli(fits(n), {"sweep": (0.5, 20.0)}),
        lambda f: (ticks(f.axes[0].yaxis) - PUBLISHED) // 2,
    ),
    "gravity and compression, women": (
        lambda n: literature.gravity_and_compression(fits(n), ratio()),
        fits_beside,
    ),
    "accuracy, parameters": (lambda n: accuracy.accuracy(errors(n, 1), "q_00_mm"), titled),
    "orders": (convergence_orders, lambda f: ticks(f.axes[0].yaxis)),
    "memory, parameters": (lambda n: accuracy.memory(errors(n, 1)), lambda f: len(f.axes[0].collections)),
    "budget, quantities": (budgeted, lambda f: bars(f.axes[0]) // 7),
    "programs' cases": (lambda n: solved_by(n, 2), titled),
    "programs": (lambda n: solved_by(1, n + 1), lambda f: distinct(f.axes[0]) - 1),
    "programs of tasks": (lambda n: done_by(n, 2), lambda f: distinct(f.axes[0])),
    "tasks": (lambda n: done_by(2, n), lambda f: ticks(f.axes[0].yaxis)),
    "effects": (lambda n: screened(n, 2), lambda f: ticks(f.axes[0].xaxis)),
    "scenes of effects": (lambda n: screened(2, n), lambda f: ticks(f.axes[0].yaxis)),
    "scenes": (answered, lambda f: bars(f.axes[0])),
    "validation, positions": (predicted, lambda f: distinct(f.axes[3])),
    "models, positions": (models, titled),
    "published models": (compared, lambda f: ticks(f.axes[0].yaxis)),
    "hard cases": (cases, lambda f: bars(f.axes[1])),
    "rules": (
        lambda n: status.time_and_memory(table(rule=names(n), s=1.0, max_rss=9.0)),
        lambda f: bars(f.axes[0]),
    ),
}


@cache
def drawn(name: str, n: int) -> Figure:
    """The figure of a case with n of what there is any number of, drawn once for all tests."""
    return CASES[name][0](n)


@pytest.mark.parametrize(
    ("name", "n"), [(name, n) for name in CASES for n in (1, 7, 16 if name in PANELLED else 100)]
)
def test_nothing_is_lost_and_no_name_lies_over_another(name, n):
    figure = drawn(name, n)
    assert CASES[name][1](figure) == n
    require_apart(figure)


def require_apart(figure: Figure) -> None:
    """No name of a tick overlaps the next one, and every legend lies inside the figure."""
    figure.draw_without_rendering()
    for ax in figure.axes:
        for axis in (ax.xaxis, ax.yaxis):
            over = [pair for pair in pairwise(shown_names(axis)) if overlap(*pair)]
            assert not over, (
                f"{[text.get_text() for text in over[0]]} overlap in {ax.get_title(loc='left')!r}"
            )
    legends = [*figure.legends, *(ax.get_legend() for ax in figure.axes if ax.get_legend())]
    for legend in legends:
        box = legend.get_window_extent()
        assert box.x0 >= -2
        assert box.x1 <= figure.bbox.x1 + 2
        assert box.height < 0.9 * figure.bbox.height


def shown_names(axis: Any) -> list[Any]:
    """Texts of its ticks within its limits, in their order."""
    low, high = sorted(axis.get_view_interval())
    marks = sorted(axis.get_major_ticks(), key=lambda tick: tick.get_loc())
    texts = [tick.label1 for tick in marks if low <= tick.get_loc() <= high and axis.axes.axison]
    return [text for text in texts if text.get_visible() and text.get_text()]


def overlap(one: Any, other: Any) -> bool:
    """Of texts that are level or upright, their boxes; of those that lean, their lines of text."""
    a, b = one.get_window_extent(), other.get_window_extent()
    angle = np.radians(one.get_rotation())
    if np.isclose(np.sin(2 * angle), 0, atol=1e-6):
        return bool(a.x1 > b.x0 and b.x1 > a.x0 and a.y1 > b.y0 and b.y1 > a.y0)
    return bool(abs(a.x1 - b.x1) * np.sin(angle) < one.get_fontsize() * one.get_figure().dpi / 72)


@pytest.mark.parametrize(
    ("name", "stem"),
    [
        ("sweep, women", "name"),
        ("trade-off, breasts", "name"),
        ("trade-off, strategies", "way"),
        ("softening, breasts", "name"),
        ("dose, routes", "route"),
        ("curves, breasts", "name"),
        ("curves, strategies", "way"),
        ("curves, sets of moduli", "set"),
        ("unloading, methods", "way"),
        ("amounts, sets of moduli", "set"),
        ("spectra, beams", "name"),
    ],
)
@pytest.mark.parametrize("n", [7, 100])
def test_a_legend_names_all_or_says_how_many_there_are(name, stem, n):
    figure = drawn(name, n)
    legends = [*figure.legends, *(ax.get_legend() for ax in figure.axes if ax.get_legend())]
    texts = [text.get_text() for legend in legends for text in legend.get_texts()]
    named = [
        name for name in names(n, stem) if any(name.replace("_", " ") in t.replace("_", " ") for t in texts)
    ]
    assert named == names(n, stem) or any(text.startswith(f"{n} ") for text in texts)
    if n == 7:
        assert len(named) in (0, 7), "all of a few that colours tell apart are named"


@pytest.mark.parametrize("n", [1, 7, 13])
def test_strain_and_pressure_of_any_number_of_strategies(n, monkeypatch):
    small = lambda solids, camera, columns, extent: render(solids, camera, columns=12, extent=extent)  # noqa: E731
    monkeypatch.setattr(strategies, "render", small)
    cells, faces = len(SKIN.cells), len(SKIN.boundaries["skin"])
    strained = strategies.Strained(SKIN, np.ones(cells), np.ones(cells), np.ones(faces))
    figure = strategies.discomfort(dict.fromkeys(names(n), strained), centre=np.array([75.0, -60.0, 0.0]))
    assert [title(ax) for ax in figure.axes if ax.images][::3] == names(n)
    assert sum(len(ax.images) for ax in figure.axes) == 3 * n


def test_a_few_have_the_colours_and_marks_of_the_style_and_many_have_one_each():
    assert list(colours("abcdef").values()) == list(SERIES)
    assert list(markers("abcdef").values()) == list(numbered("abcdef").values()) == list("osD^vP")
    assert [style["ls"] for style in lines("abcd").values()] == ["-", "--", ":", "-."]
    for n in (7, 40, 100):
        assert len(set(colours(range(n)).values())) == len(set(numbered(range(n)).values())) == n
        assert len({tuple(style.items()) for style in lines(range(n)).values()}) == 1


def test_a_long_legend_is_a_part_of_it_from_first_to_last():
    handles = [Line2D([], [], label=name) for name in names(LISTED + 1)]
    assert some(handles[:-1], "women") == handles[:-1]
    first, *named = some(handles, "women")
    assert first.get_label() == f"{LISTED + 1} women, {SAMPLE} named:"
    assert [named[0], named[-1]] == [handles[0], handles[-1]]
    assert len(named) == SAMPLE
