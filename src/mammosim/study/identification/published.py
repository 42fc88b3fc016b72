"""This study's moduli among published ones: fitted under gravity, and used under compression."""

from typing import Any

import numpy as np
import pandas as pd

HERE = "this study"
COLUMNS = ["source", "tissue", "low_kpa", "high_kpa", "middle_kpa", "under", "status"]


def beside(published: pd.DataFrame, fitted: pd.DataFrame) -> pd.DataFrame:
    """Published moduli and this study's fits in one table, COLUMNS, kPa.

    published: the table `published_biomechanics`; fitted: volunteer, side, tissue, fitted_kpa, low_kpa,
    high_kpa, identifiable. under: gravity, compression, ex vivo or assumed; middle_kpa: the fit, or the
    geometric mean of both ends; status: a fit is `identifiable` or `not identifiable`, whose ends are the fit
    itself where it states no interval.
    """
    theirs = published.assign(middle_kpa=np.sqrt(published.low_kpa * published.high_kpa))
    ours = pd.DataFrame(
        {
            "source": HERE + ", " + fitted.volunteer + " " + fitted.side,
            "tissue": fitted.tissue,
            "low_kpa": fitted.low_kpa.fillna(fitted.fitted_kpa),
            "high_kpa": fitted.high_kpa.fillna(fitted.fitted_kpa),
            "middle_kpa": fitted.fitted_kpa,
            "under": "gravity",
            "status": np.where(fitted.identifiable.astype(bool), "identifiable", "not identifiable"),
        }
    )
    known = ours[ours.middle_kpa.notna()]
    return pd.concat([theirs[COLUMNS], known[COLUMNS]], ignore_index=True)


# ASSUME: a modulus of the whole breast, which some fit under gravity, stands for its fat and for its gland.
def ratios(rows: pd.DataFrame) -> pd.DataFrame:
    """How much stiffer a tissue is under compression than under gravity: a row per tissue that has both.

    rows: of `beside`; fits that are not identifiable do not count. gravity_kpa, compression_kpa: geometric
    means of the middles; ratio of these; ratio_low, ratio_high: of the nearest and of the farthest ends.
    """
    counted = rows[rows.status != "not identifiable"]
    found: list[dict[str, Any]] = []
    for tissue, pressed in counted[counted.under == "compression"].groupby("tissue", sort=False):
        names = (tissue, "breast") if tissue in ("adipose", "glandular") else (tissue,)
        hung = counted[(counted.under == "gravity") & counted.tissue.isin(names)]
        if len(hung):
            gravity, compression = (np.exp(np.log(part.middle_kpa).mean()) for part in (hung, pressed))
            found.append(
                {
                    "tissue": tissue,
                    "gravity_kpa": gravity,
                    "compression_kpa": compression,
                    "ratio": compression / gravity,
                    "ratio_low": pressed.low_kpa.min() / hung.high_kpa.max(),
                    "ratio_high": pressed.high_kpa.max() / hung.low_kpa.min(),
                    "gravity_values": len(hung),
                    "compression_values": len(pressed),
                }
            )
    return pd.DataFrame(found)
