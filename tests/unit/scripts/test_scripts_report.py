"""The first page of the report says what is missing, and where each volunteer's own page is."""

import pandas as pd


def test_the_first_page_links_the_page_of_each_volunteer(script):
    nothing = pd.DataFrame(columns=["reason", "tables", "figures"])
    rows = pd.DataFrame([("ada", "fit", "one position")], columns=["volunteer", "not_planned", "reason"])
    section = script("report").completeness(nothing, rows, ["ada", "bea"])
    assert "[ada](../women/ada/what.html), [bea](../women/bea/what.html)" in section.text
    assert [len(block.frame) for block in section.blocks] == [1], "what is empty is not shown"
