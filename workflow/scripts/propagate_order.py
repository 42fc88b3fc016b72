"""How much energy every draw would store in the fit's shape between the plates."""

import _stage
import numpy as np
import pandas as pd

from mammosim.core.settings import read
from mammosim.core.units import UJ_PER_MJ
from mammosim.io.meshes import read_mesh, read_point_data
from mammosim.io.tables import read_table, write_table
from mammosim.study.identification.moduli import Materials
from mammosim.study.identification.propagation import drawn_body, stored_energy


def main(files: dict[str, str], job: dict, settings: dict, out: str) -> None:
    mesh, x = read_mesh(files["mesh"]), read_mesh(files["fit"]).points
    assumed, energies = read(Materials, settings["tissues"], "tissues"), []
    for number, draw in read_table(files["samples"]).head(settings["draws"]).iterrows():
        rest = read_point_data(files["rests"], f"draw_{number}")
        body = drawn_body(mesh, draw, assumed)
        known = np.isfinite(rest).all()
        energies.append(stored_energy(body, mesh.moved_to(rest), x) / UJ_PER_MJ if known else np.nan)
    table = pd.DataFrame({"draw": range(len(energies)), "stored_energy_mj": energies})
    write_table(table.assign(**job)[[*job, "draw", "stored_energy_mj"]], out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(
            dict(snakemake.input.items()),
            {"volunteer": snakemake.wildcards.v, "side": snakemake.wildcards.side},
            _stage.settings(snakemake),
            snakemake.output[0],
        )
