"""What a run found of one woman: in sentences, and as tables that a reader outside the field can follow."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pandas as pd

from mammosim.io.missing import missing_rows
from mammosim.study.report.pages import Listing
from mammosim.study.report.parts import Answer

JOB = ("side", "strategy", "moduli")
FORCES = (
    "Forces depend on moduli that were not measured between plates. In practice 50 to 180 N are applied "
    "(de Groot 2013), most of them to the tissue at the chest wall (Dustler 2021), in front of which these "
    "plates end."
)
LEAST_MM = 1e-3  # a distance below it says nothing about a breast


def shown(rows: pd.DataFrame, answer: Answer) -> Listing:
    """Those columns of a table that say something, distances to a micrometre, and why what is missing is."""
    frame = rows[[name for name in answer.columns if name in rows and rows[name].notna().any()]].copy()
    for name in frame.columns[frame.columns.str.endswith("_mm")]:
        frame[name] = pd.to_numeric(frame[name]).round(3)
    if "outcome" in rows and not (rows["outcome"] == "converged").all():
        frame["outcome"] = rows["outcome"]
    return Listing(frame.rename(columns=dict(answer.columns)), answer.caption)


def telling(name: str, rows: pd.DataFrame, modelled: str) -> tuple[pd.DataFrame, str]:
    """The rows of a table that say something of her, and in words what is left out, or what they mean."""
    if name == "validation":
        return _predicted(rows, modelled)
    if name == "identification" and "identifiable" in rows:
        told = rows["identifiable"].astype(str) == "True"
        return rows.assign(fitted_kpa=rows["fitted_kpa"].where(told)), ""
    return rows, WORDS[name](rows) if name in WORDS else ""


def _predicted(rows: pd.DataFrame, modelled: str) -> tuple[pd.DataFrame, str]:
    """Without the position that the model is made of, which it meets by construction, and single markers."""
    if "quantity" not in rows:
        return rows, ""
    own = (rows["position"] == modelled) & ~missing_rows(rows)
    single = rows["quantity"].astype(str).str.fullmatch(r"breast_\d+")
    left = rows[own & rows["quantity"].astype(str).str.startswith("skin")]["value_mm"].max()
    size = f"less than {LEAST_MM:g} mm" if left < LEAST_MM else f"at most {left:.2g} mm"
    words = (
        f"The model is made of the {modelled} series and meets it by construction: what is left between "
        f"the skins ({size}) is the solver's and no test of the model, so that it is not listed."
    )
    return rows[~own & ~single], words if own.any() else ""


def answers_in_words(tables: Mapping[str, pd.DataFrame]) -> list[str]:
    """A paragraph per breast, of the first strategy that was pressed: thickness, force, dose, what shows."""
    pressed, seen = _there(tables, "compression"), _there(tables, "image")
    if pressed.empty:
        return []
    found = []
    for row in pressed.drop_duplicates("side").itertuples():
        same, images = (_like(row, rows) for rows in (pressed, seen))
        found.append(" ".join([_pressed_words(row, same), *map(_image_words, images.head(1).itertuples())]))
    return found


def _like(row: Any, rows: pd.DataFrame) -> pd.DataFrame:
    """The rows of the same breast and strategy."""
    return rows if rows.empty else rows[(rows.side == row.side) & (rows.strategy == row.strategy)]


def _there(tables: Mapping[str, pd.DataFrame], name: str) -> pd.DataFrame:
    """The rows of a table that are answers."""
    rows = tables.get(name, pd.DataFrame())
    kept = rows[~missing_rows(rows)]
    return kept if set(JOB) <= set(kept) else pd.DataFrame()


def _pressed_words(row: Any, same: pd.DataFrame) -> str:
    """Thickness, and the force between the sets of moduli."""
    least, most = same.force_n.min(), same.force_n.max()
    force = (
        f"{least:.3g} N with {row.moduli} moduli"
        if len(same) == 1
        else f"{least:.3g} to {most:.3g} N, by the moduli assumed"
    )
    return (
        f"**{row.side.capitalize()} breast, {row.strategy} compression: plates {row.plates_mm:.0f} mm "
        f"apart** (thickness {row.thickness_from}), with a force of {force}."
    )


def _image_words(row: Any) -> str:
    """Dose, and how well lesion and calcifications show, as far as they are known."""
    told = (
        (
            row.dose_mgy,
            f"**Mean glandular dose {row.dose_mgy:.2f} mGy** (standard error {row.dose_se_mgy:.2f}) at "
            f"{row.mas:.0f} mAs",
        ),
        (row.cnr, f"contrast to noise of the lesion {row.cnr:.2f} in a pixel"),
        (row.calcification_d, f"d' of the calcifications {row.calcification_d:.1f}"),
    )
    words = "; ".join(words for value, words in told if np.isfinite(value))
    return f"{words[0].upper()}{words[1:]}." if words else ""


def carried_words(rows: pd.DataFrame) -> str:
    """Which method and which moduli carry her weight, where not the default with the moduli as given."""
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


def _pressing_words(rows: pd.DataFrame) -> str:
    """What the forces are worth, and where the plates end."""
    if not {"side", "chest_gap_mm", "chest_gap_from"} <= set(rows):
        return ""
    ends = rows.dropna(subset=["chest_gap_mm"]).drop_duplicates(["side", "chest_gap_mm"])
    gaps = [f"{row.side} {row.chest_gap_mm:.1f} mm ({row.chest_gap_from})" for row in ends.itertuples()]
    where = f" From the ribs to the edge of the plates: {', '.join(gaps)}." if gaps else ""
    return f"{FORCES}{where}"


WORDS: Mapping[str, Callable[[pd.DataFrame], str]] = {
    "stress_free_attempts": carried_words,
    "compression": _pressing_words,
}
