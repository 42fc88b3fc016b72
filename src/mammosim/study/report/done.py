"""The page of one woman after a run: what was done, what could not be and why, and what more would add."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath

import pandas as pd

from mammosim.chain.allowed import TOLD
from mammosim.io.missing import missing_rows, reason_of
from mammosim.study.report.answers import answers_in_words, shown, telling
from mammosim.study.report.pages import Listing, Picture, Section
from mammosim.study.report.parts import PARTS, Part
from mammosim.study.report.women import Gains, Plan, gains_section

# Of a part of TOLD: the tables and figures of hers that show whether it could be had.
EVIDENCE: Mapping[str, tuple[str, ...]] = {
    "labels": ("segmentation", "mesh_quality"),
    "mesh": ("mesh_quality",),
    "scan": ("positions",),
    "segmentation": ("segmentation",),
    "registration": ("registration",),
    "mean_shape": ("morph",),
    "fit": ("identification",),
    "validation": ("validation",),
    "propagation": ("propagation",),
    "stress_free": ("stress_free_attempts",),
    "pressed": ("compression",),
    "mammogram": ("image",),
    "exposed_dose": ("dose",),
    "slices": ("slices",),
}
GIVEN = "listed"  # of TOLD, what nothing is made for
# What her page does not wait for, and the words that make it.
ELSEWHERE: Mapping[str, str] = {"sweep": "study", "upright": "study", "softening": "softening"}
READ: Mapping[str, str] = {
    "positions": "What was read: slices through the left nipple. Filled symbols lie near the slice; the "
    "arrow is gravity."
}
CAUTION = (
    "All of it is a model's answer and none is a finding about her: the lesion and the calcifications are "
    "the program's, put in to measure how well they would show."
)


@dataclass(frozen=True)
class Done:
    """What there is of one woman after a run.

    tables: name -> her rows, those of missing results among them; pictures: name -> bytes of a PNG;
    files: table -> paths of her files; missing: study.jobs.completeness.missing_results; given: what is given
    of her; modelled: the position that her model is made of; home: the page's folder.
    """

    volunteer: str
    tables: Mapping[str, pd.DataFrame]
    pictures: Mapping[str, bytes]
    files: Mapping[str, Sequence[str]]
    missing: pd.DataFrame
    given: pd.DataFrame
    modelled: str
    home: str


def done_sections(done: Done, plan: Plan, gains: Gains, *, thickness: str) -> tuple[Section, ...]:
    """The page from its summary to her files; thickness: to what she is pressed, in words."""
    gained = list(gains)
    parts = (_part(part, done) for part in PARTS)
    return (
        _summary(done, plan, gained, thickness),
        _given(done),
        *(each for each in parts if each.blocks),
        _could_not(done.missing),
        gains_section(gained),
        _files(done),
    )


def _summary(done: Done, plan: Plan, gains: Gains, thickness: str) -> Section:
    """The answers, and each part of the chain: done, or why not."""
    by_status: dict[tuple[str, str], list[str]] = {}
    for what, why in plan:
        by_status.setdefault(_status(what, why, done), []).append(what)
    rows = [(status, ", ".join(whats), why) for (status, why), whats in by_status.items()]
    words = [*answers_in_words(done.tables), thickness, *_gained_words(gains)]
    listing = Listing(
        pd.DataFrame(rows, columns=["done", "what", "why not"]), "Each part of the chain and of the study."
    )
    return Section("In short", "\n\n".join(filter(None, [*words, CAUTION])), (listing,))


def _gained_words(gains: Gains) -> list[str]:
    """What one more thing would add; two or three stand in the table of all."""
    return [
        f"**{names[0].capitalize()} would add:** {', '.join(whats)}."
        for names, whats in gains
        if len(names) == 1
    ]


def _status(what: str, why: str, done: Done) -> tuple[str, str]:
    """Whether a part of the plan was done, and why not: her data, a failure, or that nobody asked for it."""
    if why:
        return "no", why
    part = next((key for key, words in TOLD.items() if words == what), "")
    if part in ELSEWHERE:
        return "not yet", f"her data allow it: snakemake {ELSEWHERE[part]} makes it"
    there, reasons = _evidence(part, done)
    if reasons:
        return "in part" if there else "failed", reasons[0]
    return ("yes", "") if there or part == GIVEN else ("not asked", "the settings do not ask for it")


def _evidence(part: str, done: Done) -> tuple[bool, list[str]]:
    """Whether anything of a part is there, and why the rest is not."""
    names = EVIDENCE.get(part, ())
    there = any(_belongs(picture, name, done) for picture in done.pictures for name in names)
    reasons: list[str] = []
    for rows in (done.tables[name] for name in names if name in done.tables):
        gone = missing_rows(rows)
        there = there or not gone.all()
        reasons += [reason_of(str(each)) for each in rows[gone].get("outcome", ())]
    return there, list(dict.fromkeys(reasons))


def _belongs(picture: str, figure: str, done: Done) -> bool:
    return f"{picture}_".startswith(f"{figure}_{done.volunteer}_")


def _pictures(figures: Mapping[str, str], done: Done) -> list[Picture]:
    """Her figures whose names begin so; {what}: what such a name says beside her own."""
    return [
        Picture(data, caption.format(what=_rest(name, figure, done)))
        for figure, caption in figures.items()
        for name, data in done.pictures.items()
        if _belongs(name, figure, done)
    ]


def _rest(picture: str, figure: str, done: Done) -> str:
    return picture.removeprefix(f"{figure}_{done.volunteer}").strip("_").replace("_", " ")


def _given(done: Done) -> Section:
    """Her positions, and what was read of them."""
    frame = done.given.loc[:, done.given.astype(str).ne("").any()]
    listing = Listing(frame.rename(columns={"listed": "points"}), "Her positions, and what is given of each.")
    return Section("What was given", "", (*_pictures(READ, done), listing))


def _part(part: Part, done: Done) -> Section:
    """A part with all that there is of it; without blocks where there is nothing."""
    listings, words = [], []
    for name, answer in part.answers.items():
        if name in done.tables:
            rows, said = telling(name, done.tables[name], done.modelled)
            words.append(said)
            listings += [shown(rows, answer)] if len(rows) else []
    return Section(part.title, "\n\n".join(filter(None, words)), (*_pictures(part.figures, done), *listings))


def _could_not(missing: pd.DataFrame) -> Section:
    """What was asked and could not be computed."""
    words = (
        "Everything that was planned for her is there."
        if missing.empty
        else "Where another attempt took the place of one that failed, all that follows from it is there."
    )
    failed = Listing(missing, "What failed and why, and which of her tables and figures lack it.")
    return Section("What could not be computed", words, () if missing.empty else (failed,))


def _files(done: Done) -> Section:
    """Where her tables are, from the folder of the page."""
    up = "../" * len(PurePosixPath(done.home).parts)
    lines = [
        f"{name.replace('_', ' ').capitalize()}: "
        + ", ".join(f"[{path.removeprefix('results/')}]({up}{path})" for path in paths)
        + "."
        for name, paths in done.files.items()
        if paths
    ]
    return Section("Her tables", "\n\n".join(lines))
