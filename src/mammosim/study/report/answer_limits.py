"""What the data of each breast, and of any breast of this study, cannot say, why, and what would say it."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from mammosim.chain.allowed import REPORTED
from mammosim.chain.outcome import CONVERGED
from mammosim.chain.thickness import GIVEN
from mammosim.io.missing import missing_rows, reason_of
from mammosim.study.report.answer import Answer
from mammosim.study.report.pressed_breast import BREAST, Tables, of_breast
from mammosim.study.report.strategy_costs import COSTS, WORDS

# What may not be planned of a volunteer.
COMPRESSION, FIT = REPORTED["pressed"], REPORTED["fit"]


@dataclass(frozen=True)
class Known:
    """What is known of the volunteers beside the tables.

    sides: that are pressed; digital: which are; not_planned: volunteer, what and why, of each thing that her
    data do not allow.
    """

    sides: tuple[str, ...]
    digital: tuple[str, ...] = ()
    not_planned: tuple[tuple[str, str, str], ...] = ()

    def why_not_planned(self, volunteer: str, what: str) -> str:
        """Why something is not planned for her; '' where it is."""
        return next((why for v, name, why in self.not_planned if (v, name) == (volunteer, what)), "")


def why_not_pressed(
    asked: Iterable[tuple[str, str]], known: Known, tables: Tables
) -> dict[tuple[str, str], str]:
    """Why a breast is not pressed by the standard strategy: a reason for each that is asked about."""
    rows = tables.get("compression", pd.DataFrame(columns=[*BREAST, "strategy", "moduli", "outcome"]))
    found = {}
    for volunteer, side in asked:
        hers = of_breast(rows, volunteer, side)
        failed = [reason_of(str(why)) for why in hers.outcome if why != CONVERGED]
        if why := known.why_not_planned(volunteer, COMPRESSION):
            found[volunteer, side] = why
        elif side not in known.sides:
            found[volunteer, side] = "the settings do not ask for it (compression.sides)"
        else:
            found[volunteer, side] = failed[0] if failed else "it has no row in compression.csv"
    return found


Reason = tuple[str, str, str]  # what cannot be said, why, and what would say it
COLUMNS = ["cannot_be_said", "because", "breasts", "what_would_say_it"]
# Of every breast: what no result of this study says.
ALWAYS: Sequence[Reason] = (
    (
        "how much it hurts",
        "strain and pressure are no measure of pain; no source says which of them hurts",
        "a questionnaire with each compression",
    ),
    (
        "what a mammography unit would show as force",
        "the plates end before the chest wall, which bears most of a force in practice",
        "a model with the tissue at the chest wall; forces of this study compare with each other",
    ),
    (
        "what half the force means for tissue that stiffens",
        "the laws do not stiffen with strain: less force leaves a breast thicker here than in practice",
        "force and thickness measured while she is pressed",
    ),
    (
        "what a unit with a harder beam for thicker breasts would need",
        "voltage and filter are the same for every thickness; exposure control sets the mAs alone, "
        "which takes more dose",
        "the table of exposure control of that unit",
    ),
    (
        "whether a reader would find the lesion",
        "noise is that of photons and detector; anatomy, which hides lesions, and motion during a longer "
        "exposure are not in it; one mass and one cluster of calcifications stand in one place",
        "readers, or observers of images with anatomical noise",
    ),
    (
        "anything of the oblique view",
        "only the craniocaudal view is computed",
        "a model that reaches the axilla",
    ),
)


def limits_table(found: Sequence[Answer], table: pd.DataFrame, tables: Tables, known: Known) -> pd.DataFrame:
    """COLUMNS: a row per reason, those of single breasts first; table: rows of strategy_costs."""
    reasons: dict[Reason, list[str]] = {}
    for answer in found:
        for reason in _reasons(answer, table, tables, known):
            reasons.setdefault(reason, []).append(f"{answer.volunteer} {answer.side}")
    rows = [(what, why, ", ".join(dict.fromkeys(who)), then) for (what, why, then), who in reasons.items()]
    rows += [(what, why, "all", then) for what, why, then in ALWAYS]
    return pd.DataFrame(rows, columns=COLUMNS)


def _reasons(answer: Answer, table: pd.DataFrame, tables: Tables, known: Known) -> list[Reason]:
    """What cannot be said of one breast."""
    place = answer.volunteer, answer.side
    hers = {name: of_breast(rows, *place) for name, rows in tables.items()}
    if not answer.standard_mm > 0:
        unasked = answer.side not in known.sides and not known.why_not_planned(answer.volunteer, COMPRESSION)
        then = "name the side in compression.sides" if unasked else "see What is missing, and her own page"
        return [("anything of this breast", answer.why, then)]
    rows = of_breast(table, *place)
    return [each for check in CHECKS for each in check(answer, rows, hers, known)]


def _range(answer: Answer, rows: pd.DataFrame, tables: Tables, known: Known) -> Iterable[Reason]:
    """No answer, or one that ends where strategies end."""
    what = "how far compression can be reduced"
    if not answer.shown or (answer.why and not np.isfinite(answer.possible_mm)):
        yield what, answer.why, "more names in compression.strategies and xray.strategies"
    elif not answer.ended and np.isfinite(answer.certain_mm):
        yield f"{what} further", "the thickest strategy still costs less", "a strategy with less compression"


def _unknown_costs(answer: Answer, rows: pd.DataFrame, tables: Tables, known: Known) -> Iterable[Reason]:
    """A loss whose value, or whose interval, is not known of any strategy with less compression."""
    reduced = rows[rows.thickness_mm > answer.standard_mm]
    for quantity in COSTS:
        mine = reduced[reduced["quantity"] == quantity]
        if mine.empty or (mine.complete & mine.change_low_percent.notna()).any():
            continue
        what = f"what less compression does to {WORDS[quantity]}"
        if mine.change_percent.notna().any():
            yield (
                f"how sure the change of {WORDS[quantity]} is",
                "its numerical error was not measured with these settings of X-rays",
                "snakemake accuracy, or settings of config/accuracy/parameters.yaml",
            )
        elif mine.value.notna().any():
            yield (
                what,
                f"the standard strategy, with which it is compared, has no {WORDS[quantity]}",
                "see What is missing",
            )
        elif np.isfinite(answer.possible_mm):
            yield (
                what,
                f"there is no result of {WORDS[quantity]}",
                "xray.strategies and, for d', quantum_noise among xray.effects",
            )


def _moduli(answer: Answer, rows: pd.DataFrame, tables: Tables, known: Known) -> Iterable[Reason]:
    """Whose moduli the forces have."""
    what = "her force and pressure, better than their intervals"
    fit = tables.get("identification", pd.DataFrame())
    fit = fit[~missing_rows(fit)]
    if fit.empty:
        why = known.why_not_planned(answer.volunteer, FIT) or "the fit of her moduli is missing"
        yield (
            what,
            f"her moduli are not determined, those of the literature are assumed: {why}",
            "a supine series beside the prone one",
        )
        return
    free = fit[~fit.identifiable.astype(bool) & fit.tissue.isin(["adipose", "glandular", "skin"])]
    if len(free):
        yield what, f"her data do not determine the modulus of: {', '.join(free.tissue)}", "a third position"
    yield (
        what,
        "moduli fitted under gravity are several times softer than those of the literature between plates",
        "force and thickness measured while she is pressed",
    )


def _pressing(answer: Answer, rows: pd.DataFrame, tables: Tables, known: Known) -> Iterable[Reason]:
    """What was chosen for her."""
    pressed = tables["compression"]
    pressed = pressed[pressed.outcome == CONVERGED]
    if (pressed.get("thickness_from", pd.Series(GIVEN, pressed.index)) != GIVEN).any():
        yield (
            "how thick her breast is in a mammogram",
            "no thickness is given for her, and the standard is a share of her breast's depth",
            "compression.thickness_mm from a mammogram of hers",
        )
    factor = pressed.get("moduli_factor", pd.Series(1.0, pressed.index))
    if (factor != 1).any():
        yield (
            "her shape without gravity with the moduli as assumed",
            f"only moduli times {factor.max():g} carry her weight",
            "a supine series, which shows how stiff hers are",
        )


def _digital(answer: Answer, rows: pd.DataFrame, tables: Tables, known: Known) -> Iterable[Reason]:
    if answer.volunteer in known.digital:
        yield (
            "anything of a real woman",
            "a digital volunteer: her tissues, moduli and images are simulated",
            "a prone series of hers: config/README.md",
        )


Check = Callable[[Answer, pd.DataFrame, Tables, Known], Iterable[Reason]]
CHECKS: Sequence[Check] = (_range, _unknown_costs, _moduli, _pressing, _digital)
