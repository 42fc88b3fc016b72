import json
import platform

import numpy as np
import pandas as pd
import pytest

from mammosim import __version__
from mammosim.study.report.summary import (
    assumptions,
    author_year,
    digest,
    entries,
    made_words,
    numbers,
    provenance,
)


def test_numbers_are_named_by_table_row_and_column():
    table = pd.DataFrame({"volunteer": ["small", "large"], "kpa": [0.5, 20.0], "error_mm": [1.25, np.nan]})
    found = numbers({"sweep": table}, {"sweep": ("volunteer", "kpa")})
    assert found == {"sweep.small.0.5.error_mm": 1.25, "sweep.large.20.error_mm": None}
    assert json.loads(json.dumps(found)) == found


def test_rows_that_share_a_name_are_rejected():
    table = pd.DataFrame({"volunteer": ["small", "small"], "error_mm": [1.0, 2.0]})
    with pytest.raises(ValueError, match="not told apart by volunteer"):
        numbers({"sweep": table}, {"sweep": ("volunteer",)})


def test_assumptions_are_read_with_the_lines_that_go_on():
    text = (
        "x = 1\n    # ASSUME: skin weighs nothing,\n    # and does not bend.\ny = 2\n# ASSUME: no friction.\n"
    )
    found = assumptions({"b.py": text, "a.py": "# just a comment\n"})
    assert found.assumption.tolist() == ["skin weighs nothing, and does not bend.", "no friction."]
    assert set(found.file) == {"b.py"}


def test_the_digest_of_a_configuration_depends_on_its_values_not_their_order():
    assert digest({"a": 1, "b": {"c": 2, "d": 3}}) == digest({"b": {"d": 3, "c": 2}, "a": 1})
    assert digest({"a": 1}) != digest({"a": 2})


def test_a_footer_says_what_made_the_results_and_not_on_which_machine():
    made = provenance({"seed": 7}, lock="", assumed=assumptions({}), commit="abc", command="snakemake study")
    jobs = pd.DataFrame(
        {"rule": ["a", "b"], "s": 3600.0, "cpu_time": [7200.0, 3600.0], "max_rss": [10, 2500]}
    )
    short = made_words(made, date="today", jobs=jobs.assign(max_rss=float("nan")))
    assert short["Durations"] == "2 jobs, 3.0 processor hours, 2.0 hours one after another"
    found = made_words(made, date="today", jobs=jobs)
    assert (found["Commit"], found["Command"], found["Seeds"][:2]) == ("abc", "snakemake study", "7,")
    assert found["Durations"] == (
        "2 jobs, 3.0 processor hours, 2.0 hours one after another; at most 2.5 GB (b)"
    )
    assert platform.node() not in json.dumps(made)
    assert made_words({key: made[key] for key in made if key != "commit"}, date="d")["Commit"] == "unknown"


def test_authors_are_cited_as_in_a_text():
    def cited(author):
        return author_year({"author": author, "year": "2009"})

    assert cited("Carter, Timothy John") == "Carter 2009"
    assert cited("Dance, David R. and Sechopoulos, Ioannis") == "Dance and Sechopoulos 2009"
    assert cited("Badano, Aldo and others") == cited("Badano, A. and B, C. and D, E.") == "Badano et al. 2009"
    accents = entries('@book{a1,\n  author = {Bj{\\"o}rn, M{\\^\\i}ra},\n  year = {2009}\n}\n')
    assert accents[0]["author"] == "Björn, Mîra"


def test_provenance_names_versions_and_can_be_written():
    found = provenance({"seed": 1}, lock="numpy==2", assumed=assumptions({}))
    assert found["packages"]["numpy"] == np.__version__
    assert found["packages"]["mammosim"] == __version__
    json.dumps(found)
