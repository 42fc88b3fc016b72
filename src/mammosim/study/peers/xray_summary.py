"""The table of all programs and X-ray tasks: what was aimed at, and the numbers of the page."""

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from mammosim.study.peers.aims import OURS, best, counts, judged, only

PLAIN = "plain_transport"  # ours, too, without what lessens the variance
FOLLOWED = "dose"  # the kind of task in which every photon is followed to its end
QUANTITIES = ("seconds", "histories_per_s", "error")


def targets(table: pd.DataFrame, aims: Sequence[Mapping[str, Any]]) -> pd.DataFrame:
    """One row per aim: what, task, peer, measured, goal, met.

    table: rows (task, program, seconds, histories_per_s, error, value, outcome); aims: task, what, at_least
    or at_most. what is one of QUANTITIES, of ours; `times faster`, seconds of the fastest other program over
    ours; `times the error` of that program; `difference`, relative, of our value from that of plain
    transport. measured is nan, and the aim not met, where a row is missing.
    """
    converged = table[table.outcome == "converged"]
    return pd.DataFrame([_target(converged[converged.task == aim["task"]], aim) for aim in aims])


def _target(rows: pd.DataFrame, aim: Mapping[str, Any]) -> dict[str, Any]:
    what, ours = aim["what"], rows[rows.program == OURS]
    others = rows[~rows.program.isin((OURS, PLAIN))]
    if what in QUANTITIES:
        peer, measured = OURS, only(ours, what)
    elif what == "difference":
        peer = PLAIN
        measured = abs(only(ours, "value") / only(rows[rows.program == PLAIN], "value") - 1)
    else:
        peer, seconds = best(others, "seconds")
        of_peer = others[others.program == peer]
        faster = seconds / only(ours, "seconds")
        measured = faster if what == "times faster" else only(ours, "error") / only(of_peer, "error")
    return {"what": what, "task": aim["task"], "peer": peer, **judged(measured, aim)}


def numbers(table: pd.DataFrame, aims: pd.DataFrame) -> dict[str, Any]:
    """What the page quotes, of a table that has kind, cpu_s and runs, too."""
    absent = table[table.outcome.str.startswith("not installed")]
    speed = aims[aims.what == "times faster"]
    faster = [
        f"{row.measured:.1f} ({row.task}, {row.peer})" for row in speed.itertuples() if row.peer != "none"
    ]
    rates = table.loc[(table.program == OURS) & (table.kind == FOLLOWED), "histories_per_s"]
    return {
        "peers_xray.rows": len(table),
        "peers_xray.programs": int(table.loc[table.outcome == "converged", "program"].nunique()),
        "peers_xray.absent": ", ".join(sorted(set(absent.program))) or "none",
        "peers_xray.times_faster": "; ".join(faster) or "never compared",
        "peers_xray.millions_per_s": f"{rates.max() / 1e6:.1f}" if rates.notna().any() else "no",
        "peers_xray.processor_s": float((table.cpu_s * table.runs).sum()),
        **counts(aims, ["task"], prefix="peers_xray"),
    }
