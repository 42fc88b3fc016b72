"""What a thicker breast costs in the image: exposure, dose, scatter and contrast of every strategy."""

import pandas as pd

from mammosim.chain.strategies import STANDARD
from mammosim.core.errors import ConfigurationError
from mammosim.io.missing import missing_rows

KEY = ["volunteer", "side", "strategy", "moduli"]
PRESSED = ["thickness_mm", "force_n", "mean_pressure_kpa", "logarithmic_p95"]
SEEN = ["mas", "dose_mgy", "dose_se_mgy", "scatter_to_primary", "cnr", "cnr_se", "cnr_quantum",
        "calcification_cnr", "calcification_d_expected", "calcification_d", "calcification_d_low",
        "calcification_d_high"]  # fmt: skip


def trade_off(compression: pd.DataFrame, image: pd.DataFrame) -> pd.DataFrame:
    """Rows of compression.csv and image.csv side by side: KEY, PRESSED, SEEN, one per image.

    dose_change_percent and thickness_change_mm: against the standard strategy of the same breast and moduli.
    An image that is missing has its KEY and the `outcome` that says why, and no numbers.
    Raises ConfigurationError for an image of a strategy that has no row in the first table.
    """
    gone = missing_rows(image)
    if gone.any():
        return pd.concat([trade_off(compression, image[~gone]), image.loc[gone, [*KEY, "outcome"]]])
    pressed = compression.reindex(columns=[*KEY, *PRESSED])
    rows = image.reindex(columns=[*KEY, *SEEN]).merge(pressed, on=KEY, how="left", indicator=True)
    alone = rows[rows._merge != "both"]
    if len(alone):
        names = "; ".join(" ".join(row) for row in alone[KEY].values)
        raise ConfigurationError(f"images of strategies that were not compressed: {names}; press them first")
    rows = rows.drop(columns="_merge")
    standard = rows[rows.strategy == STANDARD].drop(columns="strategy")
    beside = rows.merge(
        standard, on=[name for name in KEY if name != "strategy"], suffixes=("", "_0"), how="left"
    )
    rows["dose_change_percent"] = 100 * (beside.dose_mgy / beside.dose_mgy_0 - 1)
    rows["thickness_change_mm"] = beside.thickness_mm - beside.thickness_mm_0
    return rows[[*KEY, *PRESSED, *SEEN, "dose_change_percent", "thickness_change_mm"]]
