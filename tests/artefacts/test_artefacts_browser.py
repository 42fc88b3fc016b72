"""The pages of the small run in a browser: whole, without errors, light, and open to every reader."""

import pandas as pd
import pytest

pytestmark = pytest.mark.workflow
MB = 1e6


def test_the_report_is_light_and_has_no_serious_fault_of_access(page, results):
    report = results / "study/report.html"
    assert report.stat().st_size < 2 * MB
    read = page.open(report)
    read.evaluate("scrollTo(0, document.documentElement.scrollHeight)")
    assert page.violations() == []
    assert read.locator("main > section").count() > 10


def test_the_folder_of_the_study_is_below_30_mb(results):
    assert sum(file.stat().st_size for file in (results / "study").rglob("*") if file.is_file()) < 30 * MB


def test_every_body_of_the_small_run_is_drawn(page, results):
    read = page.open(results / "study/view.html", width=450, height=500)
    read.wait_for_function("document.querySelector('#body option')")
    names = read.eval_on_selector_all("#volunteer option", "all => all.map((each) => each.value)")
    assert names == sorted(set(pd.read_csv(results / "study/compression.csv").volunteer))
    for name in names:
        read.select_option("#volunteer", name)
        read.wait_for_function(f"told.textContent.startsWith('{name}, ')")
        bodies = read.eval_on_selector_all("#body option", "all => all.map((each) => each.textContent)")
        assert {"prone", "supine", "standard"} <= set(bodies)
    assert read.text_content("#absent") == ""
