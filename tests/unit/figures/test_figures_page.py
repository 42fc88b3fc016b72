"""All figures: letters of panels, texts inside, legends beside the data, sources that exist."""

import re

import numpy as np
import pandas as pd
from conftest import title
from matplotlib.figure import Figure

from mammosim.core.fiducials import Fiducials
from mammosim.figures import volunteers
from mammosim.figures.style import new_figure, styled


@styled
def of_panels(number: int, *, twin: bool = False, words: bool = False) -> Figure:
    figure = new_figure(2.0)
    for n, ax in enumerate(figure.subplots(1, number + words, squeeze=False)[0][:number]):
        ax.plot([0, 1], [0, 1])
        ax.set_title("first" if n == 0 else "")
        if twin:
            ax.twinx().plot([0, 1], [1, 0])
    return figure


def test_panels_are_lettered_and_a_single_one_is_not():
    lettered = [ax.get_title(loc="left") for ax in of_panels(3, twin=True).axes]
    assert lettered == ["a  first", "b", "c", "", "", ""], "second scales have no letter"
    assert [ax.get_title(loc="left") for ax in of_panels(1).axes] == ["first"]
    assert [ax.get_title(loc="left") for ax in of_panels(2, words=True).axes] == ["a  first", "b", ""]
    many = [ax.get_title(loc="left") for ax in of_panels(28).axes]
    assert many[25:] == ["z", "aa", "ab"]


def test_markers_are_drawn_at_the_slice_only_since_others_would_float_in_air(torso):
    near, far = torso.fiducials.point("nipple_left"), np.array([-60.0, -48.0, 85.0])
    points = Fiducials(("nipple_left", "chest_1"), ("nipple", "chest"), np.array([near, far]))
    figure = volunteers.positions(
        {"prone": torso.image}, {"prone": points}, {"prone": np.array([0, -1.0, 0])}
    )
    axial, sagittal = figure.axes
    assert [len([line for line in ax.lines if len(line.get_xdata())]) for ax in (axial, sagittal)] == [1, 1]
    assert "within" in figure.legends[0].get_title().get_text()


def test_a_step_that_leaves_markers_farther_apart_shows_what_it_gains(torso):
    steps = pd.DataFrame(
        {"step": ["landmarks", "image"], "marker_residual_mm": [0.7, 1.8], "correlation": [0.95, 0.97]}
    )
    figure = volunteers.registration(torso.image, torso.image, torso.image, steps, at_mm=0.0)
    gained = next(ax for ax in figure.axes if title(ax) == "inside the rib cage")
    np.testing.assert_array_equal(gained.lines[0].get_ydata(), [0.95, 0.97])


def test_every_source_that_a_text_cites_is_in_the_bibliography(repository):
    known = set(re.findall(r"^@\w+\{([^,\s]+)", (repository / "config/references.bib").read_text(), re.M))
    files = [*(repository / "workflow/report").glob("*.yaml"), *(repository / "config").rglob("*.yaml")]
    cited = {key for file in files for key in re.findall(r"@([a-z]+\d{4}[a-z]?)\b", file.read_text())}
    assert len(cited) > 5
    assert cited <= known
