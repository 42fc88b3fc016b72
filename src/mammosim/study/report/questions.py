"""Which question is answered where: a table of links to the sections of a report and to pages beside it."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches

import pandas as pd

from mammosim.core.errors import ConfigurationError
from mammosim.core.settings import Settings
from mammosim.study.report.pages import Section

NOWHERE = "not in this study: no data of its volunteers allow it"


@dataclass(frozen=True)
class Question(Settings):
    """A question, and the title of the section, or the target of the page, that answers it.

    Raises ConfigurationError unless there is exactly one of both.
    """

    question: str
    section: str = ""
    page: str = ""

    def __post_init__(self) -> None:
        super().__post_init__()
        if bool(self.section) == bool(self.page):
            raise ConfigurationError(f"{self.question!r} names a section or a page; give one of them")


@dataclass(frozen=True)
class Questions(Settings):
    """The file of questions, in the order in which they are read."""

    questions: tuple[Question, ...]

    def table(
        self,
        sections: Sequence[Section],
        pages: Mapping[str, str],
        made: Collection[str],
        titles: Collection[str],
    ) -> pd.DataFrame:
        """question, answered_in: a link '[words](where)', or why there is none.

        sections: of the report; pages: the title of each page by its target; made: those that were made;
        titles: of all sections that a report may have.
        Raises ConfigurationError for a page without title, and for a section that no report has.
        """
        for each in self.questions:
            if each.section and each.section not in titles:
                near = get_close_matches(each.section, titles, n=1)
                advice = f"did you mean {near[0]!r}?" if near else f"there are: {', '.join(titles)}"
                raise ConfigurationError(f"{each.question!r} names no section {each.section!r}; {advice}")
        anchors = {section.title: section.anchor for section in sections}
        rows = [(each.question, _place(each, anchors, pages, made)) for each in self.questions]
        return pd.DataFrame(rows, columns=["question", "answered_in"])


def _place(
    asked: Question, anchors: Mapping[str, str], pages: Mapping[str, str], made: Collection[str]
) -> str:
    if asked.page and asked.page not in pages:
        raise ConfigurationError(f"no page {asked.page!r}; there are: {', '.join(sorted(pages))}")
    if asked.page in made and asked.page:
        return f"[{pages[asked.page]}]({asked.page}.html)"
    title = pages[asked.page] if asked.page else asked.section
    if title in anchors:
        return f"[{title}](#{anchors[title]})"
    return f"made on demand by snakemake {asked.page}" if asked.page else NOWHERE
