"""Glandular dose and scatter of the pressed breast by photon Monte Carlo. Effect: scatter."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass

import pandas as pd

from mammosim.chain.graph import Inputs
from mammosim.chain.mammogram import dose_in, scatter_behind, scatter_cells, xray_phantom
from mammosim.core.rng import seed_of
from mammosim.io.tables import read_table, write_table
from mammosim.xray.dose import GlandularDose
from mammosim.xray.dose_routes import Beam, three_routes

PERCENT = 100.0


@dataclass(frozen=True)
class ExposedDose:
    """mGy of a mammogram at its mAs, with its standard error."""

    dose_mgy: float
    dose_se_mgy: float

    @classmethod
    def of(cls, dose: GlandularDose, mas: float) -> "ExposedDose":
        """Of the dose per mAs."""
        return cls(dose.mgy_per_mas * mas, dose.standard_error_mgy_per_mas * mas)


def dose(inputs: Inputs) -> GlandularDose:
    """Per mAs."""
    return dose_in(
        inputs["phantom"],
        inputs["geometry"],
        inputs["spectrum"],
        relative_error=inputs.setting("xray.dose_error_percent") / PERCENT,
        seed=seed_of(*inputs.subject.streams, "photons"),
    )


def save_dose(dose: GlandularDose, files: Mapping[str, str], job: Mapping[str, str]) -> None:
    """A row."""
    more = {"mgy_per_mgy": dose.mgy_per_mgy, "relative_error": dose.relative_error}
    write_table(pd.DataFrame([{**job, **asdict(dose), **more}]), files["rows"])


def load_dose(files: Mapping[str, str]) -> GlandularDose:
    """What save_dose wrote."""
    row = read_table(files["rows"]).iloc[0]
    return GlandularDose(**{name: row[name] for name in GlandularDose.__dataclass_fields__})


def exposed_dose(inputs: Inputs) -> ExposedDose:
    """At automatic exposure."""
    return ExposedDose.of(inputs["dose"], inputs["exposure"])


def scatter(inputs: Inputs) -> pd.DataFrame:
    """Cells of chain.mammogram.scatter_cells."""
    found = scatter_behind(
        inputs["phantom"],
        inputs["geometry"],
        inputs["spectrum"],
        relative_error=inputs.setting("xray.scatter_error_percent") / PERCENT,
        cell_mm=inputs.setting("xray.scatter_pixel_mm"),
        seed=seed_of(*inputs.subject.streams, "scatter"),
    )
    return scatter_cells(found)


def save_scatter(cells: pd.DataFrame, files: Mapping[str, str], job: Mapping[str, str]) -> None:
    """The cells."""
    write_table(cells, files["cells"])


def load_scatter(files: Mapping[str, str]) -> pd.DataFrame:
    """What save_scatter wrote."""
    return read_table(files["cells"])


def dose_routes(inputs: Inputs) -> pd.DataFrame:
    """The dose of this breast and of its standard breast by three routes, see xray.dose_routes."""
    combination = f"{inputs.setting('xray.anode')}/{inputs.setting('xray.filter')}"
    return three_routes(
        inputs["dose"],
        xray_phantom(inputs["phantom"]),
        Beam(inputs["spectrum"], combination),
        thickness_mm=inputs["pressed"].plates["thickness_mm"],
        relative_error=inputs.setting("xray.dose_error_percent") / PERCENT,
        seed=seed_of(*inputs.subject.streams, "routes"),
    )


def save_dose_routes(table: pd.DataFrame, files: Mapping[str, str], job: Mapping[str, str]) -> None:
    """Its rows."""
    write_table(table.assign(**job)[[*job, *table.columns]], files["rows"])
