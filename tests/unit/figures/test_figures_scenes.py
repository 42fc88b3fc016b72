"""Effects and answers of scenes drawn: what is kept is framed, what is too far off is of another colour."""

import numpy as np
import pandas as pd
from matplotlib.colors import to_rgba
from matplotlib.patches import Rectangle

from mammosim.figures.identification import softening
from mammosim.figures.scenes import effects, scenes
from mammosim.figures.style import BLUE, SERIES, VERMILION

DECISIONS = pd.DataFrame(
    {
        "scene": ["a", "a", "a", "b"],
        "effect": ["skin", "gland", "noise", "skin"],
        "quantity": ["force_n"] * 3 + ["nipple_mm"],
        "change": [0.4, 0.001, np.nan, np.nan],
        "tolerance": [0.2, 0.2, 0.2, 1.0],
        "included": [True, False, True, True],
        "reason": [
            "without it",
            "without it",
            "means nothing without it",
            "without it there is no answer: it slides",
        ],
    }
)
ANSWERS = pd.DataFrame(
    {
        "scene": ["a", "b"],
        "quantity": ["force_n", "nipple_mm"],
        "difference": [0.1, 2.0],
        "tolerance": [0.2, 1.0],
        "within": [True, False],
        "seconds_full": [10.0, 20.0],
        "seconds_screened": [2.0, 5.0],
    }
)


def test_what_is_kept_is_framed_and_what_has_no_number_is_marked():
    ax = effects(DECISIONS).axes[0]
    assert sum(isinstance(patch, Rectangle) for patch in ax.patches) == 3
    assert sorted(text.get_text() for text in ax.texts) == ["x", "–"]
    assert [label.get_text() for label in ax.get_yticklabels()] == ["a: force_n", "b: nipple_mm"]


def test_an_answer_outside_of_its_tolerance_has_another_colour():
    apart, time = scenes(ANSWERS).axes
    colours = [bar.get_facecolor() for bar in apart.patches]
    assert colours[0] != colours[1]
    assert colours == [to_rgba(BLUE), to_rgba(VERMILION)]
    assert [bar.get_width() for bar in time.patches] == [10.0, 20.0, 2.0, 5.0]


def test_softening_has_a_line_for_gland_and_for_all_of_every_breast_and_all_pass_today():
    table = pd.DataFrame(
        {"tissue": ["all", "glandular", "all"], "factor": [1.0, 0.7, 0.7], "nipple_moved_mm": [0.0, 1.0, 3.0],
         "force_n": [2.0, 1.8, 1.4], "thickness_mm": [45.0, 44.0, 41.0], "agd_mgy": [2.0, 1.9, 1.7]}
    ).assign(volunteer="small", side="left")  # fmt: skip
    axes = softening(table).axes
    assert len(axes) == 4
    for ax in axes:
        assert len(ax.lines) == 2
        assert all(0.0 in line.get_xdata() for line in ax.lines)


def test_softening_draws_more_breasts_than_there_are_colours():
    one = pd.DataFrame(
        {"tissue": ["all", "glandular", "all"], "factor": [1.0, 0.7, 0.7], "nipple_moved_mm": [0.0, 1.0, 3.0],
         "force_n": [2.0, 1.8, 1.4], "thickness_mm": [45.0, 44.0, 41.0], "agd_mgy": [2.0, 1.9, 1.7]}
    )  # fmt: skip
    breasts = len(SERIES) + 2
    figure = softening(
        pd.concat([one.assign(volunteer=f"v{number}", side="left") for number in range(breasts)])
    )
    assert [len(ax.lines) for ax in figure.axes] == [2 * breasts] * 4
    named = [text.get_text() for text in figure.legends[0].get_texts()]
    assert named[:breasts] == [f"v{number} left" for number in range(breasts)]
