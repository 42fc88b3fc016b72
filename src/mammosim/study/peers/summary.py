"""The tables of all programs: do they agree, which is how much faster, and are the targets met."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import pandas as pd

from mammosim.core.errors import ConfigurationError
from mammosim.core.settings import Positive, Settings

OURS = "mammosim"
DIRECT = ("felupe", "dolfinx_mumps", "ngsolve", "calculix", "scikit_fem")
PLAIN = "plain_transport"  # ours, too, without what lessens the variance
FOLLOWED = "dose"  # the kind of task in which every photon is followed to its end
FOUR_DIGITS = 1e-4


@dataclass(frozen=True, kw_only=True)
class Target(Settings):
    """A performance target: one of at_least and at_most. Raises ConfigurationError for both or none."""

    at_least: Positive | None = None
    at_most: Positive | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if (self.at_least is None) == (self.at_most is None):
            raise ConfigurationError("a target has one of at_least and at_most; give exactly one")

    def row(self, table: pd.DataFrame) -> dict[str, Any]:
        """What was measured, of whom, beside the target; table: what converged."""
        raise NotImplementedError

    def reached(self, measured: float) -> dict[str, Any]:
        """measured, target in words, met; not met where nothing was measured."""
        if self.at_least is not None:
            return {
                "measured": measured,
                "target": f"at least {self.at_least:g}",
                "met": measured >= self.at_least,
            }
        return {
            "measured": measured,
            "target": f"at most {self.at_most:g}",
            "met": measured <= (self.at_most or 0),
        }


@dataclass(frozen=True, kw_only=True)
class MechanicsTarget(Target):
    """For one case, on one mesh."""

    case: str
    edge_mm: Positive

    def one(self, table: pd.DataFrame, column: str, case: str | None = None) -> float:
        """Our value, in this case or another."""
        here = (table.case == (case or self.case)) & (table.edge_mm == self.edge_mm)
        return _only(table[here & (table.program == OURS)], column)

    def measured(self, what: str, peer: str, measured: float) -> dict[str, Any]:
        return {
            "what": what,
            "case": self.case,
            "edge_mm": self.edge_mm,
            "peer": peer,
            **self.reached(measured),
        }


@dataclass(frozen=True, kw_only=True)
class Faster(MechanicsTarget):
    """The fastest peer's seconds, in the case `against` if there is one, over ours."""

    against: str | None = None

    def row(self, table: pd.DataFrame) -> dict[str, Any]:
        case = self.against or self.case
        peers = table[(table.case == case) & (table.edge_mm == self.edge_mm) & (table.program != OURS)]
        peer, seconds = _best(peers, "cpu_s")
        return self.measured("times faster", peer, seconds / self.one(table, "cpu_s"))


@dataclass(frozen=True, kw_only=True)
class Slower(MechanicsTarget):
    """Our seconds over our seconds in the case `than`."""

    than: str

    def row(self, table: pd.DataFrame) -> dict[str, Any]:
        ratio = self.one(table, "cpu_s") / self.one(table, "cpu_s", self.than)
        return self.measured(f"times the time of {self.than}", OURS, ratio)


@dataclass(frozen=True, kw_only=True)
class Growth(Target):
    """The exponent p of our seconds ~ unknowns^p, least squares over all meshes of the case."""

    case: str

    def row(self, table: pd.DataFrame) -> dict[str, Any]:
        rows = table[(table.case == self.case) & (table.program == OURS)]
        exponent = np.nan
        if len(rows) > 1:
            exponent = float(np.polyfit(np.log(rows.unknowns.astype(float)), np.log(rows.cpu_s), 1)[0])
        words = {"what": "exponent of the time", "case": self.case, "edge_mm": np.nan, "peer": OURS}
        return words | self.reached(exponent)


@dataclass(frozen=True, kw_only=True)
class LessMemory(MechanicsTarget):
    """Our memory over that of the leanest direct peer."""

    def row(self, table: pd.DataFrame) -> dict[str, Any]:
        here = (table.case == self.case) & (table.edge_mm == self.edge_mm)
        peer, memory = _best(table[here & table.program.isin(DIRECT)], "memory_mb")
        return self.measured("times the memory", peer, self.one(table, "memory_mb") / memory)


@dataclass(frozen=True)
class MechanicsTargets(Settings):
    """As configured, by kind."""

    faster: tuple[Faster, ...] = ()
    slower: tuple[Slower, ...] = ()
    growth: tuple[Growth, ...] = ()
    less_memory: tuple[LessMemory, ...] = ()

    def all(self) -> tuple[Target, ...]:
        """In the order of the table."""
        return (*self.faster, *self.slower, *self.growth, *self.less_memory)


@dataclass(frozen=True, kw_only=True)
class XrayTarget(Target):
    """For one task: a column of ours, or `times faster`: seconds of the fastest other program over ours.

    `times the error`: ours over that program's; `difference`: relative, of our value from plain transport's.
    """

    task: str
    what: Literal["seconds", "histories_per_s", "error", "times faster", "times the error", "difference"]

    def row(self, table: pd.DataFrame) -> dict[str, Any]:
        rows = table[table.task == self.task]
        ours, plain = rows[rows.program == OURS], rows[rows.program == PLAIN]
        others = rows[~rows.program.isin((OURS, PLAIN))]
        peer, seconds = _best(others, "seconds")
        if self.what == "times faster":
            measured = seconds / _only(ours, "seconds")
        elif self.what == "times the error":
            measured = _only(ours, "error") / _only(others[others.program == peer], "error")
        elif self.what == "difference":
            peer, measured = PLAIN, abs(_only(ours, "value") / _only(plain, "value") - 1)
        else:
            peer, measured = OURS, _only(ours, self.what)
        return {"what": self.what, "task": self.task, "peer": peer, **self.reached(measured)}


def reached(table: pd.DataFrame, targets: Iterable[Target]) -> pd.DataFrame:
    """One row per target: what, of which case and edge_mm or task, peer, measured, target, met.

    measured is nan, and the target not met, where a row of the table is missing or did not converge.
    """
    converged = table[table.outcome == "converged"]
    return pd.DataFrame([target.row(converged) for target in targets])


def with_agreement(table: pd.DataFrame) -> pd.DataFrame:
    """The table with `agrees`: the apex within FOUR_DIGITS of the median of programs with the same law.

    Empty where nothing was found, or by one program alone.
    """
    same = table.groupby(["case", "edge_mm", "law"], dropna=False).apex_mm
    median, count = same.transform("median"), same.transform("count")
    agrees = ((table.apex_mm - median).abs() <= FOUR_DIGITS * median.abs()).astype(object)
    return table.assign(agrees=agrees.where(table.apex_mm.notna() & (count > 1), None))


def numbers(table: pd.DataFrame, targets: pd.DataFrame) -> dict[str, Any]:
    """What the page of the mechanics quotes; targets: rows of `reached`."""
    speed = targets[targets.what == "times faster"].measured.dropna()
    named = targets.assign(edge_mm=[f"{edge:g} mm" for edge in targets.edge_mm])
    return {
        "peers.rows": len(table),
        "peers.programs": int(table.program.nunique()) - 1,
        "peers.not_converged": int((table.outcome != "converged").sum()),
        "peers.disagree": int((table.agrees == False).sum()),  # noqa: E712, empty where nothing was found
        "peers.times_faster": f"{speed.min():.1f} to {speed.max():.1f}" if len(speed) else "never compared",
        "peers.seconds": float(table.cpu_s.sum()),
        **_counts(named, ["case", "edge_mm"], prefix="peers"),
    }


def xray_numbers(table: pd.DataFrame, targets: pd.DataFrame) -> dict[str, Any]:
    """What the page of the X-ray tasks quotes, of a table that has kind, cpu_s and runs, too."""
    absent = table[table.outcome.str.startswith("not installed")]
    speed = targets[targets.what == "times faster"]
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
        **_counts(targets, ["task"], prefix="peers_xray"),
    }


def _best(table: pd.DataFrame, column: str) -> tuple[str, float]:
    """The program with the smallest value, and it; 'none' and nan where there is no row."""
    rows = table[table[column].notna()]
    if rows.empty:
        return "none", np.nan
    row = rows.loc[rows[column].idxmin()]
    return str(row.program), float(row[column])


def _only(rows: pd.DataFrame, column: str) -> float:
    """The value of the first row, nan where there is none."""
    return float(rows[column].iloc[0]) if len(rows) else np.nan


def _counts(targets: pd.DataFrame, where: list[str], *, prefix: str) -> dict[str, Any]:
    """How many targets there are and were met, and which were missed; where: columns that say of what."""
    missed = targets.loc[~targets.met.astype(bool), ["what", *where]]
    words = [", ".join(row) for row in missed.astype(str).to_numpy()]
    return {
        f"{prefix}.targets": len(targets),
        f"{prefix}.targets_met": int(targets.met.sum()),
        f"{prefix}.targets_missed": "; ".join(words) or "none",
    }
