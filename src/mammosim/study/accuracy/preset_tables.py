"""Presets as tables and as files of settings, with the error of each setting beside it."""

from collections.abc import Mapping
from typing import Any

import pandas as pd
from numpy import format_float_scientific

from mammosim.chain.graph import nested
from mammosim.core.errors import ConfigurationError
from mammosim.study.accuracy.presets import CHAIN, Choice, chosen

COLUMNS = ["preset", "knob", "value", "quantity", "error", "tolerance", "seconds", "outcome"]


Limits = Mapping[str, Mapping[str, float]]  # preset -> quantity -> tolerance


def choices(measured: pd.DataFrame, limits: Limits) -> dict[str, Choice | ConfigurationError]:
    """What each preset is, or why its limits cannot be met."""
    found: dict[str, Choice | ConfigurationError] = {}
    for preset, wanted in limits.items():
        try:
            found[preset] = chosen(measured, wanted)
        except ConfigurationError as refusal:
            found[preset] = refusal
    return found


def presets(made: Mapping[str, Choice | ConfigurationError], limits: Limits) -> pd.DataFrame:
    """COLUMNS: per preset and quantity a row for the whole chain, then one per knob; seconds of the chain.

    A preset whose limits cannot be met is a row that says why.
    """
    found = []
    for preset, choice in made.items():
        if isinstance(choice, Choice):
            found.append(_rows(preset, choice, limits[preset]))
        else:
            found.append(pd.DataFrame([{"preset": preset, "knob": CHAIN, "outcome": f"refused: {choice}"}]))
    return pd.concat(found).reindex(columns=COLUMNS) if found else pd.DataFrame(columns=COLUMNS)


def _rows(preset: str, choice: Choice, wanted: Mapping[str, float]) -> pd.DataFrame:
    whole = [
        {"knob": CHAIN, "quantity": q, "error": e, "tolerance": wanted[q], "seconds": choice.seconds}
        for q, e in choice.errors.items()
    ]
    return pd.concat([pd.DataFrame(whole), choice.table]).assign(preset=preset, outcome="ok")


def preset_text(preset: str, choice: Choice | ConfigurationError) -> str:
    """A choice as a file of overrides of the configuration, each setting with the errors that it leaves.

    A refusal is a comment.
    """
    if not isinstance(choice, Choice):
        return f"# Preset {preset} was refused: {choice}\n"
    totals = ", ".join(f"{q} {e:.2g}" for q, e in choice.errors.items())
    head = [f"# Preset {preset}: {totals}; about {choice.seconds:.0f} s of one processor for one breast."]
    return "\n".join([*head, *_lines(nested(choice.settings), "", _comments(choice))]) + "\n"


def _comments(choice: Choice) -> dict[str, str]:
    """Dotted name -> the errors of the knob that set it."""
    found: dict[str, str] = {}
    for knob, names in choice.names.items():
        rows = choice.table[(choice.table.knob == knob) & (choice.table.error > 0)]
        each = ", ".join(f"{q} {e:.2g}" for q, e in zip(rows["quantity"], rows.error))
        found |= dict.fromkeys(names, each or "the reference")
    return found


def _lines(tree: Mapping[str, Any], above: str, comments: Mapping[str, str]) -> list[str]:
    """Lines of YAML; a value that is a mapping, a list or a number stands on one line."""
    found = []
    for key, value in tree.items():
        name, depth = f"{above}{key}", 2 * above.count(".")
        if name in comments:
            found.append(f"{' ' * depth}{key}: {_flow(value)} # {comments[name]}")
        else:
            found += [f"{' ' * depth}{key}:", *_lines(value, f"{name}.", comments)]
    return found


def _flow(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key}: {_flow(each)}" for key, each in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_flow, value)) + "]"
    return format_float_scientific(value) if isinstance(value, float) and 0 < value < 1e-3 else str(value)
