"""What each strategy of compression does to a breast, and what it costs, beside the standard one.

Of a quantity q of a strategy, q0 of the standard one of the same breast, and the half widths h, h0 of their
intervals relative to them,

    change = q / q0 - 1 -+ (q / q0) sqrt(h^2 + h0^2),   loss = change of the dose, -change of a detectability.

A mass is seen by an observer who adds the N pixels of its shadow: d' = c sqrt(N), c its contrast over the
noise of one pixel. Force, pressure and strain are taken with other moduli at the same thickness.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from mammosim.chain.quantities import QUANTILE
from mammosim.chain.strategies import STANDARD
from mammosim.core.settings import Positive, Settings
from mammosim.study.report.pressed_breast import BREAST, DONE, FORCE, PressedBreast, is_level

COLUMNS = [*BREAST, "strategy", "level", "thickness_mm", "quantity", "value", "low", "high", "interval_from",
           "change_percent", "change_low_percent", "change_high_percent", "complete", "costs"]  # fmt: skip
DOSE, MASS, CALCIFICATIONS = "dose_mgy", "mass_d", "calcification_d"
# What it costs: the limit that holds for it, and the sign of the change that is a loss.
COSTS: Mapping[str, tuple[str, int]] = {
    DOSE: ("dose", 1),
    MASS: ("detectability", -1),
    CALCIFICATIONS: ("detectability", -1),
}
WORDS: Mapping[str, str] = {
    DOSE: "dose",
    MASS: "d' of the mass",
    CALCIFICATIONS: "d' of the calcifications",
}
LESS, MAY, MORE, UNKNOWN = "less", "may be less", "more", "cannot be said"


@dataclass(frozen=True)
class LossLimits(Settings):
    """`answer.loss_percent`: what a reduced compression may cost against the standard one, percent."""

    dose: Positive
    detectability: Positive


@dataclass(frozen=True)
class Numerical:
    """Half widths that numerical parameters of X-rays leave, percent of a value; NaN: not measured.

    Of the dose, of the contrast of a mass, and of d' of the calcifications.
    """

    dose: float = float("nan")
    contrast: float = float("nan")
    calcification: float = float("nan")

    @classmethod
    def of(cls, errors: Mapping[str, float]) -> "Numerical":
        """Of study.accuracy.presets.errors_at."""
        # ASSUME: what images, mesh and contact leave is the same for each thickness of a breast, and not in a
        # change; what voxels, rays and photons leave is not.
        return cls(errors["agd_percent"], errors["cnr_percent"], errors["d_percent"])


ASKED = ("agd_percent", "cnr_percent", "d_percent")


def kept_in_changes(measured: pd.DataFrame) -> pd.DataFrame:
    """Of the rows of config/accuracy/measured.csv those whose errors do not cancel in a change."""
    # Photons of the dose have a standard error of their own.
    return measured[(measured.stage == "xray") & (measured.parameter != "dose_photons")]


def strategy_costs(
    known: Mapping[tuple[str, str], PressedBreast], *, numerical: Numerical, limits: LossLimits
) -> pd.DataFrame:
    """COLUMNS: a row per breast, strategy, the thinnest first, and quantity.

    level: whether the plates stayed parallel; low, high: the interval of the value, and interval_from: what
    it holds, both empty where none is known; complete: whether it holds every error of a change; costs:
    LESS, MAY, MORE or UNKNOWN against the limits, '' of what has none and of the standard. By an interval
    that is not complete nothing is LESS, and what is MORE is so by the errors that are known.
    """
    rows = [
        {"volunteer": volunteer, "side": side, **row}
        for (volunteer, side), breast in known.items()
        for row in (*_done(breast), *_seen(breast, numerical, limits))
    ]
    return pd.DataFrame(rows, columns=COLUMNS)


def _keys(row: pd.Series) -> dict[str, object]:
    level = bool(is_level(row.to_frame().T).iloc[0])
    return {"strategy": row.strategy, "level": level, "thickness_mm": float(row.thickness_mm)}


def _done(breast: PressedBreast) -> Iterator[dict[str, object]]:
    """Rows of what is done to the breast, with the intervals that the moduli leave."""
    every, others = breast.xrayed, breast.other_moduli()
    standard = every[every.strategy == STANDARD].iloc[0]
    # ASSUME: the draws of the fit, pressed to the standard's thickness, differ by as much at any other one.
    shares = breast.force_share or ()
    for _, row in every.iterrows():
        for quantity, column in DONE.items():
            q, q0 = float(row[column]), float(standard[column])
            at = {name: breast.at(name, quantity, row.thickness_mm) for name in others}
            at0 = {name: breast.at(name, quantity, standard.thickness_mm) for name in others}
            drawn = [q * share for share in shares] if quantity == FORCE else []
            changes = [_percent(q, q0), *(_percent(at[name], at0[name]) for name in others)]
            sources = [
                *(["draws of the fit"] if drawn else []),
                *(f"{n} moduli" for n in others if at[n] > 0),
            ]
            yield _keys(row) | {
                "quantity": quantity,
                "value": q,
                **_interval([q, *drawn, *at.values()], "low", "high"),
                "interval_from": ", ".join(sources),
                "change_percent": changes[0],
                **_interval(changes, "change_low_percent", "change_high_percent"),
                "complete": bool(sources),
                "costs": "",
            }


def _percent(q: float, q0: float) -> float:
    return 100 * (q / q0 - 1) if q0 > 0 else float("nan")


def _interval(values: list[float], low: str, high: str) -> dict[str, float]:
    """Least and greatest of the values that are known; NaN of less than two."""
    known = [value for value in values if np.isfinite(value)]
    ends = (min(known), max(known)) if len(known) > 1 else (np.nan, np.nan)
    return dict(zip((low, high), ends))


def _seen(breast: PressedBreast, numerical: Numerical, limits: LossLimits) -> Iterator[dict[str, object]]:
    """Rows of what it costs, of the strategies that were X-rayed or should have been."""
    every = breast.xrayed
    image = seen(breast.image, numerical).set_index("strategy")
    nothing = pd.Series(index=image.columns, dtype=object)
    standard = image.loc[STANDARD] if STANDARD in image.index else nothing
    for _, row in every.iterrows():
        here = image.loc[row.strategy] if row.strategy in image.index else nothing
        for quantity, (limit, sign) in COSTS.items():
            q, h, why = (here[f"{quantity}{end}"] for end in ("", "_half", "_from"))
            q, h = float(q), float(h)
            change = _change(q, h, float(standard[quantity]), float(standard[f"{quantity}_half"]))
            if row.strategy == STANDARD:
                change = (0.0, 0.0, 0.0) if q > 0 else change
            c, low, high = change
            loss = (low, high) if sign > 0 else (-high, -low)
            complete = bool(np.isfinite(q) and here[f"{quantity}_complete"])
            told = "" if row.strategy == STANDARD else verdict(*loss, getattr(limits, limit))
            told = MAY if told == LESS and not complete else told
            yield _keys(row) | {
                "quantity": quantity, "value": q, "low": q - abs(q) * h, "high": q + abs(q) * h,
                "interval_from": why if h > 0 else "", "change_percent": c, "change_low_percent": low,
                "change_high_percent": high, "complete": complete, "costs": told,
            }  # fmt: skip


def _change(q: float, h: float, q0: float, h0: float) -> tuple[float, float, float]:
    """The change in percent, and its interval."""
    if not q0 > 0:
        return (np.nan,) * 3
    half = abs(q / q0) * np.hypot(h, h0)
    change = q / q0 - 1
    return 100 * change, 100 * (change - half), 100 * (change + half)


def seen(image: pd.DataFrame, numerical: Numerical) -> pd.DataFrame:
    """Of each image the strategy; of each of COSTS the value, `_half`, its half width, `_from`, of what, and
    `_complete`, whether the numerical errors, too.

    image: rows of image.csv of one breast.
    """
    rows = image.reindex(columns=["strategy", "dose_mgy", "dose_se_mgy", "cnr_quantum", "lesion_pixels",
                                  "calcification_d_expected", "calcification_d_low",
                                  "calcification_d_high"])  # fmt: skip
    n, N, dose_mgy = numerical, _amount(rows.lesion_pixels), _amount(rows.dose_mgy)
    photons = QUANTILE * rows.dose_se_mgy / dose_mgy
    # ASSUME: half of the pixels on the rim of a mass's shadow, of which a disc has 2 sqrt(pi N), count by
    # chance.
    counted = QUANTILE / 2 * np.sqrt(2 * np.sqrt(np.pi * N) / 4) / N
    told = (rows.calcification_d_high - rows.calcification_d_low) / (
        rows.calcification_d_high + rows.calcification_d_low
    )
    dose, contrast, calcification = map(np.isfinite, (n.dose, n.contrast, n.calcification))
    return pd.DataFrame({
        "strategy": rows.strategy,
        DOSE: dose_mgy,
        f"{DOSE}_half": np.hypot(photons, np.nan_to_num(n.dose / 100)).astype(float),
        f"{DOSE}_from": "photons, voxels" if dose else "photons",
        f"{DOSE}_complete": dose,
        # ASSUME: the noise of pixels is white; blur, which colours it, lowers d' at each thickness alike.
        MASS: (rows.cnr_quantum * np.sqrt(N)).astype(float),
        f"{MASS}_half": np.hypot(counted, np.nan_to_num(n.contrast / 100)).astype(float),
        f"{MASS}_from": "voxels, rays, pixels" if contrast else "pixels",
        f"{MASS}_complete": contrast,
        CALCIFICATIONS: rows.calcification_d_expected.astype(float),
        f"{CALCIFICATIONS}_half": n.calcification / 100 if calcification else told.astype(float),
        f"{CALCIFICATIONS}_from": "voxels, rays, scatter" if calcification else "the observer's images",
        f"{CALCIFICATIONS}_complete": calcification,
    })  # fmt: skip


def _amount(column: pd.Series) -> pd.Series:
    """The numbers of a column that are one of photons, energy or pixels: above 0 and finite; NaN else."""
    numbers = column.astype(float)
    return numbers.where((numbers > 0) & (numbers < np.inf))


def verdict(low: float, high: float, limit: float) -> str:
    """Whether a loss, whose interval in percent is given, is less than the limit."""
    if not (np.isfinite(low) and np.isfinite(high)):
        return UNKNOWN
    return LESS if high <= limit else MORE if low > limit else MAY


def together(costs: list[str]) -> str:
    """Of the costs of one strategy: more where one is, less where all are."""
    return next((word for word in (MORE, UNKNOWN, MAY) if word in costs), LESS if costs else UNKNOWN)
