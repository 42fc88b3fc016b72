"""The two pages of one woman: what was understood of her data before a run, and what was done with them."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import PurePosixPath

import pandas as pd

from mammosim.io.missing import missing_rows
from mammosim.study.report.pages import Listing, Picture, Section

# What is not planned, and why; '' where it is planned.
Plan = Sequence[tuple[str, str]]
# What one or more things beside her data would allow.
Gains = Iterable[tuple[Sequence[str], Sequence[str]]]
ANSWERS: Mapping[str, tuple[str, tuple[str, ...]]] = {
    "stress_free_attempts": (
        "Her shape without gravity: what was tried, in its order. The last one is what is pressed.",
        ("position", "method", "moduli_factor", "adipose_kpa", "glandular_kpa", "skin_kpa", "largest_mm"),
    ),
    "compression": (
        "Her breast between the plates; moduli_factor: by what all moduli of the set were multiplied; "
        "chest_gap_mm: from the ribs to the edge of the plates.",
        (
            *("side", "strategy", "moduli", "moduli_factor", "plates_mm", "thickness_from"),
            *("chest_gap_mm", "chest_gap_from", "force_n", "mean_pressure_kpa"),
        ),
    ),
    "image": (
        "Exposure, dose, and how well the lesion (contrast to noise) and the calcifications (d') show.",
        ("side", "strategy", "moduli", "mas", "dose_mgy", "dose_se_mgy", "cnr", "cnr_se", "calcification_d"),
    ),
    "identification": (
        "Moduli fitted to her positions.",
        ("side", "tissue", "fitted_kpa", "low_kpa", "high_kpa", "identifiable"),
    ),
    "validation": ("Predicted against measured positions.", ()),
    "registration": ("How her positions were brought into one frame, and how well they agree.", ()),
}


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
        "Nothing that is given of her would stop the study. **Look at the pictures**: a wrong side, a wrong "
        "direction of gravity or a wrong spacing is seen at once."
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
        *planned_sections(plan, gains, thickness=thickness),
    )


def _of_position(each: Checked) -> Section:
    """Pictures, files and what was measured of one position."""
    used = "This position is not used: it cannot be brought into one frame with the others."
    words = " ".join(
        [*([] if each.used else [used]), *([f"Noted: {'; '.join(each.notes)}."] if each.notes else [])]
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


def planned_sections(
    plan: Plan, gains: Gains, *, thickness: str, missing: Section | None = None
) -> tuple[Section, ...]:
    """What her data allow, what not and why, and what more would add; missing: what could not be had."""
    done = pd.DataFrame([(what, not why, why) for what, why in plan], columns=["what", "planned", "why not"])
    more = pd.DataFrame(
        [(" and ".join(names), ", ".join(whats)) for names, whats in gains],
        columns=["with", "there would also be"],
    )
    return (
        Section(
            "What her data allow", thickness, (Listing(done, "Each part of the chain and of the study."),)
        ),
        *([missing] if missing else []),
        Section(
            "What more data would add",
            "" if len(more) else "Nothing: all that the study can do is planned for her.",
            (Listing(more, "Beside what is given of her."),) if len(more) else (),
        ),
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


def done_sections(
    tables: Mapping[str, pd.DataFrame],
    links: Mapping[str, Sequence[str]],
    missing: pd.DataFrame,
    plan: Plan,
    gains: Gains,
    *,
    given: pd.DataFrame,
    thickness: str,
    home: str,
) -> tuple[Section, ...]:
    """The page after a run.

    tables: name -> her rows, with those in the place of missing results; links: what -> paths of her files;
    missing: study.jobs.completeness.missing_results; given: what is given of her; home: the page's folder.
    """
    return (
        Section("What was given", "", (Listing(given, "Her positions, and what is given of each."),)),
        *_answers(tables),
        *planned_sections(plan, gains, thickness=thickness, missing=_could_not(missing)),
        _linked(links, home),
    )


def _answers(tables: Mapping[str, pd.DataFrame]) -> tuple[Section, ...]:
    """The tables that answer what was asked, where she has them."""
    listings = []
    for name, (caption, columns) in ANSWERS.items():
        if name in tables:
            rows = tables[name]
            shown = [c for c in (columns or rows.columns) if c in rows] + ["outcome"] * ("outcome" in rows)
            listings.append(Listing(rows[list(dict.fromkeys(shown))], caption))
    words = carried_words(tables)
    return (Section("What was found", words, tuple(listings)),) if listings else ()


def carried_words(tables: Mapping[str, pd.DataFrame]) -> str:
    """Which method and which moduli carry her weight, where not the default with the moduli as given."""
    rows = tables.get("stress_free_attempts", pd.DataFrame())
    if len(rows) < 2 or missing_rows(rows).any():
        return ""
    first, used = rows.iloc[0], rows.iloc[-1]
    method = f"**{first.method} found no shape of her breast without gravity; {used.method} did"
    if used.moduli_factor == 1.0:
        return f"{method}, with the moduli as given.**"
    return (
        f"{method}, with all moduli times {used.moduli_factor:g}** (fat {used.adipose_kpa:g}, gland "
        f"{used.glandular_kpa:g}, skin {used.skin_kpa:g} kPa): the softest of those tried that carry her. "
        "All that follows from `gravity` moduli has these. How stiff hers are is not known, and forces "
        "grow with them: published moduli of fat go from 0.2 to 5 kPa (Mira 2018, Badano 2018). With "
        "`compression` moduli the same shape is pressed at the upper end. A supine series would tell more."
    )


def _could_not(missing: pd.DataFrame) -> Section:
    """What was asked and could not be had."""
    if missing.empty:
        return Section("What could not be had", "Everything that was planned for her is there.")
    listing = Listing(missing, "Why, and which of her tables and figures lack it.")
    return Section("What could not be had", "", (listing,))


def _linked(links: Mapping[str, Sequence[str]], home: str) -> Section:
    """Where her files are, from the folder of the page."""
    up = "../" * len(PurePosixPath(home).parts)
    lines = [
        f"{what}: " + ", ".join(f"[{path.removeprefix('results/')}]({up}{path})" for path in paths) + "."
        for what, paths in links.items()
        if paths
    ]
    return Section("Her tables and figures", "\n\n".join(lines))
