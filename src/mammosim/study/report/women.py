"""The page of one woman before a run: what was understood of her data, and what is planned."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import pandas as pd

from mammosim.core.marks import literal
from mammosim.study.report.pages import Listing, Picture, Section

# What is not planned, and why; '' where it is planned.
Plan = Sequence[tuple[str, str]]
# What one or more things beside her data would allow.
Gains = Iterable[tuple[Sequence[str], Sequence[str]]]


@dataclass(frozen=True)
class Checked:
    """One position as it was understood.

    used: whether anything is made of it; files: kind -> path; reasons: a line each, why it cannot be used;
    quality: imaging.quality.image_quality, empty where nothing could be read; notes: what was mended; read:
    how the files were understood, and who says so.
    """

    position: str
    used: bool
    files: Mapping[str, str]
    reasons: tuple[str, ...]
    quality: Mapping[str, str | float]
    pictures: tuple[Picture, ...]
    notes: tuple[str, ...] = ()
    read: Mapping[str, str] = field(default_factory=dict)


def checked_sections(
    checked: Sequence[Checked], plan: Plan, gains: Gains, *, thickness: str, waits: bool
) -> tuple[Section, ...]:
    """The page before a run.

    thickness: to what she is pressed, in words; waits: whether her scans are still to be made.
    """
    rows = [(each.position, each.used, why) for each in checked for why in each.reasons]
    stops = [why for _, used, why in rows if used]
    text = (
        "Her data can be used: nothing in them would stop the study. **Look at the pictures**: a wrong side, "
        "a wrong direction of gravity or a wrong spacing is seen at once."
    )
    if waits:
        text = "Her scans are made by the study itself, which checks them before it uses them."
    if stops:
        text = f"**{_reasons(len(stops))} to stop.** Correct what is listed; nothing is computed before."
    faults = Listing(
        pd.DataFrame(rows, columns=["position", "used", "reason"]), "What cannot be used, and why."
    )
    return (
        Section("Verdict", text, (faults,) if rows else ()),
        *(_of_position(each) for each in checked),
        *_planned_sections(plan, gains, thickness=thickness),
    )


def _of_position(each: Checked) -> Section:
    """Pictures, files and what was measured of one position."""
    used = "This position is not used: it cannot be brought into one frame with the others."
    words = " ".join(
        [
            *([] if each.used else [used]),
            *([f"Noted: {'; '.join(map(literal, each.notes))}."] if each.notes else []),
        ]
    )
    rows = [*each.files.items(), *each.read.items(), *_shown(each.quality)]
    frame = pd.DataFrame(rows, columns=["what", "value"])
    caption = (
        "What is given, how it was read, and what was measured in it; margins are the distances of the body "
        "from a border."
    )
    title = each.position.replace("_", " ").capitalize()
    return Section(title, words, (*each.pictures, Listing(frame, caption)))


def _shown(quality: Mapping[str, str | float]) -> list[tuple[str, str]]:
    """Names and values as text."""
    return [
        (name.replace("_", " "), f"{value:.4g}" if isinstance(value, float) else str(value))
        for name, value in quality.items()
    ]


def _planned_sections(plan: Plan, gains: Gains, *, thickness: str) -> tuple[Section, ...]:
    """What her data allow, what not and why, and what more would add."""
    done = pd.DataFrame([(what, not why, why) for what, why in plan], columns=["what", "planned", "why not"])
    listing = Listing(done, "Each part of the chain and of the study.")
    return Section("What her data allow", thickness, (listing,)), gains_section(gains)


def gains_section(gains: Gains) -> Section:
    """What more than is given of her would add."""
    more = pd.DataFrame(
        [(" and ".join(names), ", ".join(whats)) for names, whats in gains],
        columns=["with", "there would also be"],
    )
    return Section(
        "What more data would add",
        "" if len(more) else "Nothing: all that the study can do is planned for her.",
        (Listing(more, "What further data would add to those given."),) if len(more) else (),
    )


def _reasons(count: int) -> str:
    return "1 reason" if count == 1 else f"{count} reasons"


def verdict(found: Mapping[str, object], page: str) -> str:
    """One line: who, whether she stops the study and why first, and her page."""
    stops = [str(each) for each in found["stops"]] if isinstance(found["stops"], list) else []
    more = f" ({_reasons(len(stops))}, this is the first)" if len(stops) > 1 else ""
    ready = "her scans are made by the study" if found["waits"] else "her data can be used"
    first = " ".join(stops[0].split()) if stops else ready
    return f"{found['volunteer']}: {first}{more}; see {page}"
