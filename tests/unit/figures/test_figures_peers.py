"""One picture per case, one line per program that converged; a point per X-ray task, a bar per goal."""

import pandas as pd

from mammosim.figures.peers import processor_time, tasks


def test_each_program_has_a_line_in_each_case_that_it_solved():
    rows = [
        (case, program, unknowns, unknowns**1.2 * factor, "converged")
        for case in ("stiff", "soft")
        for program, factor in (("mammosim", 1e-5), ("felupe", 5e-5))
        for unknowns in (20_000, 50_000)
    ]
    rows.append(("soft", "calculix", 20_000, 9.0, "stopped after 240 s of processor time"))
    figure = processor_time(pd.DataFrame(rows, columns=["case", "program", "unknowns", "cpu_s", "outcome"]))
    assert [len(ax.lines) for ax in figure.axes] == [2, 2]
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["mammosim", "felupe"]


def test_each_program_has_a_point_and_each_goal_a_bar():
    rows = [
        ("one_view", "view", "mammosim", 0.1, None, "converged"),
        ("one_view", "view", "gecatsim", 0.25, None, "converged"),
        ("sart", "slices", "mammosim", 2.0, None, "converged"),
        ("dose", "dose", "mammosim", 2.5, 4e6, "converged"),
        ("dose", "dose", "egsnrc", None, None, "not installed: name a command"),
    ]
    table = pd.DataFrame(rows, columns=["task", "kind", "program", "seconds", "histories_per_s", "outcome"])
    goals = [("seconds", "one_view", "at most 0.25"), ("histories_per_s", "dose", "at least 4e+06")]
    figure = tasks(table, pd.DataFrame(goals, columns=["what", "task", "target"]))
    seconds, rates = figure.axes
    assert [text.get_text() for text in seconds.get_yticklabels()] == ["one view", "sart"]
    assert [len(ax.lines) for ax in figure.axes] == [3, 2]
    assert seconds.lines[-1].get_xdata()[0] == 0.25
    assert rates.lines[-1].get_xdata()[0] == 4e6
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["mammosim", "gecatsim"]
