"""The table of all programs: do they agree, how much faster is which, and is that what was aimed at."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from mammosim.study.peers.aims import OURS, best, counts, judged, only

DIRECT = ("felupe", "dolfinx_mumps", "ngsolve", "calculix", "scikit_fem")
FOUR_DIGITS = 1e-4


def with_agreement(table: pd.DataFrame) -> pd.DataFrame:
    """The table with `agrees`: the apex within FOUR_DIGITS of the median of programs with the same law.

    Empty where nothing was found, or by one program alone.
    """
    same = table.groupby(["case", "edge_mm", "law"], dropna=False).apex_mm
    median, count = same.transform("median"), same.transform("count")
    agrees = ((table.apex_mm - median).abs() <= FOUR_DIGITS * median.abs()).astype(object)
    return table.assign(agrees=agrees.where(table.apex_mm.notna() & (count > 1), None))


def targets(table: pd.DataFrame, aims: Mapping[str, list[Mapping[str, Any]]]) -> pd.DataFrame:
    """One row per aim: what, case, edge_mm, the fastest or leanest peer, measured, goal, met.

    table: rows (case, edge_mm, program, unknowns, cpu_s, memory_mb, outcome); aims: lists under
    faster, slower, growth and leaner. measured is nan, and the aim not met, where a row is missing.
    """
    converged = table[table.outcome == "converged"]
    kinds = {"faster": _faster, "slower": _slower, "growth": _growth, "leaner": _leaner}
    return pd.DataFrame([kinds[kind](converged, aim) for kind in kinds for aim in aims.get(kind, [])])


def numbers(table: pd.DataFrame, aims: pd.DataFrame) -> dict[str, Any]:
    """What the page quotes."""
    speed = aims[aims.what == "times faster"].measured.dropna()
    named = aims.assign(edge_mm=[f"{edge:g} mm" for edge in aims.edge_mm])
    return {
        "peers.rows": len(table),
        "peers.programs": int(table.program.nunique()) - 1,
        "peers.not_converged": int((table.outcome != "converged").sum()),
        "peers.disagree": int((table.agrees == False).sum()),  # noqa: E712, empty where nothing was found
        "peers.times_faster": f"{speed.min():.1f} to {speed.max():.1f}" if len(speed) else "never compared",
        "peers.seconds": float(table.cpu_s.sum()),
        **counts(named, ["case", "edge_mm"], prefix="peers"),
    }


def _one(table: pd.DataFrame, case: str, edge_mm: float, program: str, column: str) -> float:
    return only(table[(table.case == case) & (table.edge_mm == edge_mm) & (table.program == program)], column)


def _aim(what: str, aim: Mapping[str, Any], peer: str, measured: float) -> dict[str, Any]:
    edge_mm = aim.get("edge_mm", np.nan)
    return {"what": what, "case": aim["case"], "edge_mm": edge_mm, "peer": peer, **judged(measured, aim)}


def _faster(table: pd.DataFrame, aim: Mapping[str, Any]) -> dict[str, Any]:
    """The fastest peer's seconds, in the case `against`, over ours."""
    case, edge = aim.get("against", aim["case"]), aim["edge_mm"]
    peers = table[(table.case == case) & (table.edge_mm == edge) & (table.program != OURS)]
    peer, seconds = best(peers, "cpu_s")
    return _aim("times faster", aim, peer, seconds / _one(table, aim["case"], edge, OURS, "cpu_s"))


def _slower(table: pd.DataFrame, aim: Mapping[str, Any]) -> dict[str, Any]:
    """Our seconds over our seconds in the case `than`."""
    seconds = [_one(table, case, aim["edge_mm"], OURS, "cpu_s") for case in (aim["case"], aim["than"])]
    return _aim(f"times the time of {aim['than']}", aim, OURS, seconds[0] / seconds[1])


def _growth(table: pd.DataFrame, aim: Mapping[str, Any]) -> dict[str, Any]:
    """The exponent p of our seconds ~ unknowns^p, least squares over all meshes of the case."""
    rows = table[(table.case == aim["case"]) & (table.program == OURS)]
    exponent = np.nan
    if len(rows) > 1:
        exponent = float(np.polyfit(np.log(rows.unknowns.astype(float)), np.log(rows.cpu_s), 1)[0])
    return _aim("exponent of the time", aim, OURS, exponent)


def _leaner(table: pd.DataFrame, aim: Mapping[str, Any]) -> dict[str, Any]:
    """Our memory over that of the leanest direct peer."""
    here = (table.case == aim["case"]) & (table.edge_mm == aim["edge_mm"])
    peer, memory = best(table[here & table.program.isin(DIRECT)], "memory_mb")
    ours = _one(table, aim["case"], aim["edge_mm"], OURS, "memory_mb")
    return _aim("times the memory", aim, peer, ours / memory)
