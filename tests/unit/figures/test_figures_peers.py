"""One picture per case, one line per program that converged."""

import pandas as pd

from mammosim.figures.peers import processor_time


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
