"""Where each question is answered: every link leads somewhere."""

from pathlib import Path

import pytest
import yaml

from mammosim.core.errors import ConfigurationError
from mammosim.core.settings import read
from mammosim.study.report.layout import Contents, Layout, sections, titles
from mammosim.study.report.pages import Listing, Section, report
from mammosim.study.report.questions import NOWHERE, Questions

FOLDER = Path(__file__).parents[3] / "workflow/report"


def layout(name: str) -> Layout:
    return read(Layout, yaml.safe_load((FOLDER / name).read_text()), name)


PAGES = {path.stem: layout(path.name) for path in FOLDER.glob("*.yaml") if path.stem != "sections"}
TITLES = {name: page.title for name, page in PAGES.items()}
WHOLE = titles(layout("sections.yaml"), PAGES.values())
ASKED = read(Questions, yaml.safe_load((FOLDER.parent / "questions.yaml").read_text()), "questions.yaml")


def places(made=(), lacking=()):
    """The sections of the report, and where each question is answered."""
    shown = sections(layout("sections.yaml"), Contents({}, {}), pages=PAGES, made=made, lacking=lacking)
    return shown, ASKED.table(shown, TITLES, made, WHOLE)


@pytest.mark.parametrize("made", [(), tuple(PAGES)])
def test_every_link_leads_to_a_section_or_to_a_page_that_was_made(made):
    shown, table = places(made)
    there = {f"#{section.anchor}" for section in shown} | {f"{page}.html" for page in made}
    links = [each.partition("](")[2].rstrip(")") for each in table.answered_in if each.startswith("[")]
    assert set(links) <= there
    assert NOWHERE not in set(table.answered_in)
    unlinked = [each for each in table.answered_in if not each.startswith("[")]
    assert all(each.startswith("made on demand by snakemake ") for each in unlinked)
    assert not (made and unlinked)


def test_a_section_that_is_left_out_is_no_link():
    _, table = places(lacking=["fit"])
    row = table[table.question.str.contains("her moduli")].iloc[0]
    assert row.answered_in == NOWHERE


def test_a_question_names_a_section_or_a_page():
    with pytest.raises(ConfigurationError, match=r"questions\[0\]: 'Why\?' names a section or a page"):
        read(Questions, {"questions": [{"question": "Why?"}]}, "questions.yaml")
    asked = read(Questions, {"questions": [{"question": "Why?", "page": "nothing"}]}, "questions.yaml")
    with pytest.raises(ConfigurationError, match="no page 'nothing'; there are: accuracy"):
        asked.table((), TITLES, (), WHOLE)


def test_a_section_that_no_report_has_is_no_lack_of_data():
    asked = read(Questions, {"questions": [{"question": "Why?", "section": "Validaton"}]}, "questions.yaml")
    with pytest.raises(ConfigurationError, match=r"no section 'Validaton'; did you mean 'Validation'\?"):
        asked.table((), TITLES, (), WHOLE)


def test_a_cell_that_is_a_link_is_one_and_nothing_else_is():
    _, table = places()
    table.loc[len(table)] = ["Bad?", "[x](javascript:alert)"]
    table.loc[len(table)] = ["Worse?", "[<b>x</b>](#here)"]
    page = report("T", (Section("Which", blocks=(Listing(table, "Where."),)),), numbers={})
    assert '<a href="#validation">Validation</a>' in page
    assert "[x](javascript:alert)" in page
    assert "&lt;b&gt;x&lt;/b&gt;</a>" in page
