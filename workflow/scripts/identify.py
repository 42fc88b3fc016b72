"""Moduli of one volunteer from two positions: intervals, draws, stress-free shape, way of the fit."""

import _stage
import pandas as pd

from mammosim.io.meshes import write_mesh
from mammosim.io.tables import write_table
from mammosim.study.identification.diagnosis import require_explained, require_one_body
from mammosim.study.identification.fit import FitSettings, FitStep, fitted
from mammosim.study.identification.pair import Errors, read_pair
from mammosim.study.identification.posterior import draws, fit_row, moduli_table
from mammosim.study.identification.problem import Prior, Problem


def main(files: dict[str, str], volunteer: str, gravity: list[str], tissues: dict, settings: dict) -> None:
    pair = read_pair(files, gravity)
    require_one_body(pair)
    problem = Problem(pair, tissues, Prior(**settings["prior"]), settings["model_error"])
    fit = fitted(problem, settings=FitSettings(errors=Errors(**settings["errors"])))
    require_explained(fit)
    table = moduli_table(volunteer, problem, fit, fascia_mm=settings["fascia_mm"])
    write_table(table, files["moduli"])
    stream = (settings["seed"], volunteer, "identification")
    write_table(draws(problem, fit, settings["draws"], stream=stream), files["samples"])
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
            snakemake.params.gravity,
            snakemake.params.tissues,
            snakemake.params.settings | {"seed": snakemake.params.seed},
        )
