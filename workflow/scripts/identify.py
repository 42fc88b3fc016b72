"""Moduli of one volunteer from two positions: intervals, draws, stress-free shape, way of the fit."""

import _stage
import pandas as pd

from mammosim.core.fiducials import midline_mm
from mammosim.core.settings import read
from mammosim.io.meshes import write_mesh
from mammosim.io.tables import write_table
from mammosim.study.identification.diagnosis import require_explained, require_one_body
from mammosim.study.identification.fit import FitStep, fitted
from mammosim.study.identification.moduli import Materials
from mammosim.study.identification.pair import left_by_registration, read_pair
from mammosim.study.identification.posterior import draws, fit_row, moduli_table
from mammosim.study.identification.problem import Problem
from mammosim.study.identification.settings import FitSettings, Identification


def main(
    files: dict[str, str],
    volunteer: str,
    seed: int,
    gravity: list[str],
    assumed: Materials,
    settings: Identification,
) -> None:
    pair = read_pair(files, gravity)
    middle = midline_mm(pair.start.fiducials)
    require_one_body(pair, middle_mm=middle)
    prior = settings.prior.widened(**left_by_registration(files["start_steps"]))
    problem = Problem(pair, assumed, prior, settings.model_error, middle)
    fit = fitted(problem, settings=FitSettings(errors=settings.errors))
    require_explained(fit)
    table = moduli_table(volunteer, problem, fit, fascia_mm=settings.fascia_mm)
    write_table(table, files["moduli"])
    write_table(
        draws(problem, fit, settings.draws, stream=(seed, volunteer, "identification")), files["samples"]
    )
    write_mesh(pair.start.mesh.moved_to(fit.state.rest), files["stress_free"])
    write_table(pd.DataFrame([fit_row(volunteer, problem, fit)]), files["fit"])
    history = pd.DataFrame(fit.history, columns=FitStep._fields)
    history.insert(0, "volunteer", volunteer)
    write_table(history, files["history"])


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(
            dict(snakemake.input.items()) | dict(snakemake.output.items()),
            snakemake.wildcards.v,
            snakemake.params.seed,
            snakemake.params.gravity,
            read(Materials, snakemake.params.tissues, "tissues"),
            read(Identification, snakemake.params.settings, "identification"),
        )
