"""Pages in a browser: tables sort and filter, bodies turn and are cut, nothing of a name runs."""

from io import BytesIO
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from browser import new_page
from PIL import Image

from mammosim.core.labels import Label
from mammosim.study.report.explorer import Exploration, explorer
from mammosim.study.report.pages import Listing, Picture, Section, report
from mammosim.study.report.scripts import SCRIPTS
from mammosim.study.report.view import Body, script
from mammosim.study.report.view import page as view_page

EVIL = "<img src=x onerror='window.ran=1'></script><script>window.ran=1</script>"
ROWS = 5000
SOURCES = {"carter2009": "Carter 2009"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory, block) -> Path:
    """A report of a few lines with everything beside it, and bodies of a small block."""
    home = tmp_path_factory.mktemp("pages")
    for part in ("scripts", "figures", "view"):
        (home / part).mkdir()
    for name, write in SCRIPTS.items():
        (home / "scripts" / name).write_bytes(write())
    (home / "figures/a.png").write_bytes(png())
    (home / "report.html").write_text(page_text(), encoding="utf-8")
    mesh = block(2)
    strained = {"von_mises_kpa": np.linspace(0, 1, len(mesh.cells))}
    pressure = {"pressure_kpa": np.linspace(0, 3, len(mesh.boundaries["skin"]))}
    moved = mesh.moved_to(mesh.points * [1, 1, 0.5])
    bodies = [Body("measured", "prone", mesh), Body("pressed", EVIL, moved, strained, pressure)]
    (home / "view/ada.js").write_text(script("ada", bodies, [f"supine is missing: {EVIL}"]), encoding="utf-8")
    colours = dict.fromkeys(Label, "#b5487f")
    (home / "view/cora.js").write_text(script("cora", [], ["prone is missing"]), encoding="utf-8")
    text = view_page("Bodies", ["ada", "bea", "cora"], colours=colours, footer={"Date": "today"})
    (home / "view.html").write_text(text, encoding="utf-8")
    return home


def png() -> bytes:
    data = BytesIO()
    Image.new("RGB", (1140, 480), "teal").save(data, "png", dpi=(150, 150))
    return data.getvalue()


def page_text() -> str:
    numbers = np.random.default_rng(1).permutation(ROWS).astype(float)
    long = pd.DataFrame({"label": [EVIL, *(f"point {i}" for i in range(1, ROWS))], "force_n": numbers})
    short = pd.DataFrame({"volunteer": ["b", EVIL, "a"], "force_n": [9.0, 10.0, 1234.5]})
    odd = pd.DataFrame({"level": [True, False, True, False], "dose_mgy": [np.inf, np.nan, 3.0, -np.inf]})
    moved = pd.DataFrame({"side": "left", "thickness_mm": [60.0, 40.0], "dose_mgy": [4.0, 2.0]})
    wide = pd.DataFrame({f"a_long_name_{i}_mm": [1.0] * 3 for i in range(16)})
    sentence = "no step keeps the cells from inverting: the tissue may be too soft for the measured shape"
    moduli = {f"modulus_{i}_kpa": [1.0, 3.0] for i in range(7)}
    reasons = pd.DataFrame(
        {"beam": ["W/Rh 0.05 mm 28 kVp"] * 2, **moduli, "outcome": [sentence, "converged"]}
    )
    explored = explorer(moved, Exploration("Dose.", "thickness_mm", ("dose_mgy",), ("side",)))
    sources = pd.DataFrame({"key": ["carter2009"], "author": ["Carter, Timothy John"]})
    pictures = [Picture(png(), f"Figure {n}. $x^2$ and {EVIL}", path="figures/a.png") for n in (1, 2)]
    sections = (
        Section("First", "Where friction is. As [@carter2009] says.", (*pictures, Listing(short, EVIL))),
        Section(
            "Second", "A second text.", (Listing(long, "All points.", "points.csv"), Listing(wide, "Wide."))
        ),
        Section(
            "Third",
            "",
            (
                explored,
                Listing(sources, "Sources.", anchors="key"),
                Listing(reasons, "Reasons."),
                Listing(odd, "Odd."),
            ),
        ),
    )
    return report(
        f"Report {EVIL}", sections, numbers={}, sources=SOURCES, footer={"Command": EVIL}, scripts="scripts"
    )


@pytest.fixture(scope="module")
def opened(browser, folder):
    """The report, opened once: each test touches parts of its own."""
    with new_page(browser) as opened:
        opened.open(folder / "report.html")
        yield opened


@pytest.fixture
def read(opened):
    return opened.page


def paged(read):
    """The long table, as soon as it is one that is paged."""
    table = read.locator("#table-2")
    table.scroll_into_view_if_needed()
    table.locator(".dt-search input").wait_for()
    return table


def shows(table, number: int, wanted: list[str], *, rows: str = "") -> None:
    """Wait until a column of the body of a table, or those rows of it, reads so.

    The page sorts and filters after the click has returned.
    """
    from playwright.sync_api import expect

    expect(table.locator(f"tbody tr{rows} td:nth-child({number})")).to_have_text(wanted)


def test_nothing_of_a_name_runs(read):
    table = paged(read)
    table.locator(".dt-search input").fill("onerror")
    shows(table, 1, [EVIL])
    table.locator(".dt-search input").fill("")
    read.locator("#table-1 th button").first.click()
    read.fill("#search", "onerror")
    assert read.evaluate("window.ran") is None
    assert read.locator("main img").count() == 2


def test_a_short_table_sorts_numbers_as_numbers(read):
    heading = read.locator("#table-1 th").nth(1)
    heading.locator("button").click()
    shows(read.locator("#table-1"), 2, ["9", "10", "1,234"])
    heading.locator("button").click()
    shows(read.locator("#table-1"), 2, ["1,234", "10", "9"])
    assert heading.get_attribute("aria-sort") == "descending"


def test_truths_sort_as_words_and_infinite_numbers_as_numbers(read):
    table = read.locator("figure.table", has_text="Odd.")
    table.locator("th button").first.click()
    shows(table, 1, ["no", "no", "yes", "yes"])
    table.locator("th button").last.click()
    shows(table, 2, ["–", "-inf", "3", "inf"])


def test_a_table_of_5000_rows_is_paged_sorted_filtered_and_downloaded(read, tmp_path):
    table = paged(read)
    assert table.locator("tbody tr").count() == 15
    table.locator("th").nth(1).click()
    shows(table, 2, ["0", "1", "2"], rows=":nth-child(-n+3)")
    table.locator(".dt-search input").fill("point 4321")
    shows(table, 1, ["point 4321"])
    with read.expect_download() as download:
        table.locator("button.buttons-csv").click()
    download.value.save_as(tmp_path / "rows.csv")
    assert pd.read_csv(tmp_path / "rows.csv").iloc[:, 0].tolist() == ["point 4321"]


def test_sentences_have_a_column_wide_enough_and_short_labels_one_line(read):
    cell = read.locator("td", has_text="no step keeps").first
    assert cell.bounding_box()["width"] > 250
    assert cell.bounding_box()["height"] < 120
    label = read.locator("td", has_text="W/Rh 0.05 mm 28 kVp").last
    assert label.evaluate("each => getComputedStyle(each).whiteSpace") == "nowrap"


def test_search_leads_to_texts_and_captions(read):
    read.fill("#search", "friction where")
    assert read.text_content(".search output") == "1 found"
    read.press("#search", "Enter")
    assert read.url.split("#")[1].startswith("text-")
    read.fill("#search", "nowhere")
    assert read.text_content(".search output") == "0 found"


def test_figures_are_enlarged_by_the_keyboard(read):
    read.locator("a.enlarge").first.focus()
    read.keyboard.press("Enter")
    dialog = read.locator("dialog")
    assert dialog.locator("p").text_content().startswith("Figure 1.")
    read.keyboard.press("ArrowRight")
    assert dialog.locator("p").text_content().startswith("Figure 2.")
    assert dialog.locator("img").evaluate("image => image.width") == 1460, "twice its size in print"
    read.keyboard.press("Escape")
    assert not dialog.evaluate("each => each.open")


def test_a_citation_leads_to_its_source_and_a_formula_is_drawn(read):
    read.click("text=Carter 2009")
    assert read.locator("tr:target").text_content().startswith("carter2009")
    assert read.locator("figcaption math msup").count() == 2


def test_on_a_phone_nothing_is_wider_than_the_screen_and_letters_can_be_read(page, folder):
    read = page.open(folder / "report.html", width=390, height=844)
    paged(read)
    assert read.evaluate("document.documentElement.scrollWidth") == 390
    smallest = read.evaluate(
        """Math.min(...[...document.querySelectorAll("body *")].filter((each) => each.offsetParent &&
        [...each.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim()))
        .map((each) => parseFloat(getComputedStyle(each).fontSize)))"""
    )
    assert smallest >= 11
    assert read.locator("figure img").first.evaluate("image => image.getBoundingClientRect().width") >= 730


def test_in_print_no_table_or_figure_is_wider_than_the_paper(page, folder):
    read = page.open(folder / "report.html", width=688, height=1000)  # A4 less its margins
    read.emulate_media(media="print")
    paged_off = read.evaluate(
        """[...document.querySelectorAll("figure")].filter((each) => each.scrollWidth > 690).length"""
    )
    assert paged_off == 0
    assert not read.locator("nav[aria-label=Contents]").is_visible()


def test_a_slider_reads_between_the_rows_of_a_table(read):
    figure = read.locator("figure.explorer")
    figure.scroll_into_view_if_needed()
    figure.locator(".main-svg").first.wait_for()
    assert figure.locator("output").text_content() == "thickness (mm) 50.0, dose (mGy): left 3.00"
    figure.locator("input").press("Home")
    read.wait_for_function("document.querySelector('.explorer output').textContent.includes('left 2.00')")


def test_a_report_has_no_serious_fault_of_access(opened, read):
    paged(read)
    assert opened.violations() == []


def pixels(read) -> np.ndarray:
    return np.asarray(Image.open(BytesIO(read.locator("#plot").screenshot())).convert("RGB")).astype(int)


def eye(read) -> dict[str, float]:
    return read.evaluate("document.getElementById('plot')._fullLayout.scene._scene.getCamera().eye")


@pytest.fixture(scope="module")
def bodies(browser, folder):
    """The page of the bodies when it has drawn the first one."""
    with new_page(browser) as opened:
        read = opened.open(folder / "view.html", width=450, height=500)
        read.wait_for_function("document.querySelector('#plot canvas') && told.textContent.includes('faces')")
        yield opened


@pytest.fixture
def viewed(bodies):
    return bodies.page


def test_bodies_are_drawn_turned_coloured_and_cut(viewed):
    whole = pixels(viewed)
    assert (np.abs(whole - whole[2, 2]).max(axis=2) > 30).mean() > 0.05, "the canvas is not blank"
    before, box = eye(viewed), viewed.locator("#plot").bounding_box()
    viewed.mouse.move(box["x"] + 200, box["y"] + 150)
    viewed.mouse.down()
    viewed.mouse.move(box["x"] + 300, box["y"] + 180, steps=4)
    viewed.mouse.up()
    assert eye(viewed) != before
    viewed.select_option("#body", "1")
    viewed.select_option("#field", "von_mises_kpa")
    assert "von Mises stress (kPa)" in viewed.text_content("#plot")
    viewed.select_option("#field", "pressure_kpa")
    assert "contact pressure on the skin (kPa)" in viewed.text_content("#plot")
    drawn = pixels(viewed)
    viewed.fill("#cut", "40")
    viewed.wait_for_function("told.textContent.includes('x = 12 mm')")
    assert (pixels(viewed) != drawn).any(axis=2).mean() > 0.02


def test_bodies_turn_by_keys_and_buttons_and_faults_are_told(bodies, viewed):
    assert bodies.violations() == []
    viewed.click("[data-turn=reset]")
    before = eye(viewed)
    viewed.locator("#plot").focus()
    viewed.keyboard.press("ArrowLeft")
    turned = eye(viewed)
    assert turned != before
    viewed.click("[data-turn='0 15']")
    assert eye(viewed)["z"] > turned["z"]
    assert viewed.text_content("#absent") == f"supine is missing: {EVIL}"
    assert viewed.evaluate("window.ran") is None
    viewed.select_option("#volunteer", "bea")
    viewed.wait_for_function("told.textContent.includes('view/bea.js is not beside this page')")
    bodies.wrong.clear()  # the browser tells of the file that is not there


@pytest.mark.parametrize("name", ["bea", "cora"])
def test_where_there_is_no_body_every_control_does_nothing(bodies, viewed, name):
    """cora has a file without bodies, bea has none."""
    viewed.select_option("#volunteer", "ada")
    viewed.wait_for_function("told.textContent.includes('faces')")
    viewed.select_option("#volunteer", name)
    viewed.wait_for_function("/no body of cora|bea.js is not beside/.test(told.textContent)")
    bodies.wrong.clear()
    assert viewed.locator("#body option").count() == viewed.locator("#field option").count() == 0
    viewed.fill("#cut", "40")
    for turn in ("reset", "20 0"):
        viewed.click(f"[data-turn='{turn}']")
    viewed.locator("#plot").focus()
    viewed.keyboard.press("ArrowLeft")
    viewed.select_option("#axis", "1")
    viewed.wait_for_timeout(50)
    assert bodies.wrong == []
    viewed.select_option("#volunteer", "ada")
    viewed.wait_for_function("told.textContent.includes('faces')")
