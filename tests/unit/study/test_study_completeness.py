"""What is missing is named once, with every table and figure that lacks it."""

import pandas as pd

from mammosim.study.jobs.completeness import completeness_sentence, missing_results
from mammosim.study.jobs.last_words import missing_in_brief

SIDES = ("left", "right")
JOB = {"volunteer": "large", "side": "left", "strategy": "squash", "moduli": "gravity"}


def test_each_reason_is_named_once_with_what_lacks_it():
    gone = pd.DataFrame(
        [{**JOB, "side": side, "outcome": "missing: mesh large prone: open"} for side in SIDES]
    )
    tables = {"image": gone, "dose": gone, "sweep": pd.DataFrame({"outcome": ["converged", "failed: soft"]})}
    found = missing_results(tables, {"mammogram_large": "mesh large prone: open", "sweep": None})
    assert found.values.tolist() == [["mesh large prone: open", "image, dose", "mammogram_large"]]
    assert "One result could not be computed" in completeness_sentence(found)


def test_a_complete_study_says_so():
    found = missing_results({"image": pd.DataFrame({"dose_mgy": [1.0]})}, {"sweep": None})
    assert found.empty
    assert completeness_sentence(found) == "Every result that was asked for is there."
    assert missing_in_brief(list(found.reason)) == ""


def test_a_terminal_ends_with_few_short_lines():
    gone = pd.DataFrame({"outcome": [f"missing: mesh {n}: {'open ' * 100}" for n in range(30)]})
    lines = missing_in_brief(list(missing_results({"image": gone}, {}).reason)).splitlines()
    assert lines[0] == "30 results could not be computed:"
    assert lines[1].startswith("  mesh 0: open")
    assert lines[-2] == "  and 22 more"
    assert len(lines) < 15
    assert max(map(len, lines)) < 210
