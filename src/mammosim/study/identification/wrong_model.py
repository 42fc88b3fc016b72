"""What a fit costs whose model leaves out what a woman has: beside a reference volunteer without it."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

KEYS = ["position", "fitted", "quantity"]


def costs(validation: pd.DataFrame, references: Mapping[str, str]) -> pd.DataFrame:
    """woman, reference, KEYS, right_mm of her reference, wrong_mm of the woman, cost_mm, the difference.

    validation: rows of validation.csv of both; references: woman -> reference volunteer.
    """
    parts = []
    for woman, reference in references.items():
        wrong, right = (
            validation[validation.volunteer == name].set_index(KEYS).value_mm for name in (woman, reference)
        )
        both = pd.DataFrame({"right_mm": right, "wrong_mm": wrong}).reindex(right.index).reset_index()
        both.insert(0, "woman", woman)
        both.insert(1, "reference", reference)
        parts.append(both.assign(cost_mm=both.wrong_mm - both.right_mm))
    return pd.concat(parts, ignore_index=True)


def moduli_beside(moduli: pd.DataFrame, references: Mapping[str, str]) -> pd.DataFrame:
    """woman, reference, side, tissue, right_kpa of the reference, wrong_kpa, and times, their ratio."""
    parts = []
    for woman, reference in references.items():
        wrong, right = (
            moduli[moduli.volunteer == name].set_index(["side", "tissue"]).fitted_kpa
            for name in (woman, reference)
        )
        both = pd.DataFrame({"right_kpa": right, "wrong_kpa": wrong}).reindex(right.index).reset_index()
        both.insert(0, "woman", woman)
        both.insert(1, "reference", reference)
        parts.append(both.assign(times=both.wrong_kpa / both.right_kpa))
    return pd.concat(parts, ignore_index=True)


def numbers(table: pd.DataFrame, moduli: pd.DataFrame) -> dict[str, float | str | None]:
    """wrong_model.* by name, of the first woman: nipple at most, markers, skin, stiffness of fat.

    Errors are those of the positions held out; *_cost_fitted_mm of those that were fitted.
    """
    first = table[table.woman == table.woman.iloc[0]]
    held_out, fitted = first[~first.fitted.astype(bool)], first[first.fitted.astype(bool)]
    found: dict[str, float | str | None] = {
        "woman": first.woman.iloc[0],
        "reference": first.reference.iloc[0],
    }
    for name, quantity in (("nipple", "nipple"), ("marker", "marker_mean"), ("skin", "skin_mean")):
        right, wrong = (_largest(held_out, quantity, column) for column in ("right_mm", "wrong_mm"))
        found |= {
            f"{name}_right_mm": _plain(right),
            f"{name}_wrong_mm": _plain(wrong),
            f"{name}_cost_mm": _plain(wrong - right),
        }
    cost = _largest(fitted, "nipple", "wrong_mm") - _largest(fitted, "nipple", "right_mm")
    fat = moduli[(moduli.woman == first.woman.iloc[0]) & (moduli.tissue == "adipose")].times
    found |= {"nipple_cost_fitted_mm": _plain(cost), "adipose_times": _plain(float(fat.mean()))}
    return {f"wrong_model.{name}": value for name, value in found.items()}


def _largest(rows: pd.DataFrame, quantity: str, column: str) -> float:
    return float(rows[column][rows.quantity.str.startswith(quantity)].max())


def _plain(value: float) -> float | None:
    return value if np.isfinite(value) else None
