"""One draw of the fit between the plates: its force and its glandular dose."""

import _stage
import pandas as pd

from mammosim.chain.files import chain_of
from mammosim.chain.stress_free import StressFree
from mammosim.core.settings import read
from mammosim.io.meshes import read_point_data, write_mesh
from mammosim.io.tables import read_table, write_table
from mammosim.study.identification.moduli import Materials
from mammosim.study.identification.propagation import FIT, by_stiffness, drawn_body


def main(files: dict, job: dict, settings: dict) -> None:
    chain, draw = chain_of(settings["given"], files), FIT
    if job["rank"] != "fit":
        energies = read_table(files["order"][0]).stored_energy_mj.to_numpy()
        draw = int(by_stiffness(energies, settings["pressed"])[int(job["rank"])])
    mesh = chain["mesh"]
    assumed = read(Materials, chain.setting("tissues"), "tissues")
    body = drawn_body(mesh, read_table(files["samples"]).iloc[draw], assumed)
    rest = mesh.moved_to(read_point_data(files["rests"], f"draw_{draw}"))
    drawn = chain.given({"pressed_body": body, "stress_free": StressFree(rest)})
    found, dose = drawn["pressed"], drawn["exposed_dose"]
    row = job | {"draw": draw, "force_n": found.row["force_n"]}
    write_table(
        pd.DataFrame([row | {"agd_mgy": dose.dose_mgy, "agd_se_mgy": dose.dose_se_mgy}]), files["row"]
    )
    write_mesh(found.mesh, files["shape"])


if __name__ == "__main__":
    with _stage.run(snakemake) as job:
        main(
            dict(snakemake.input.items()) | dict(snakemake.output.items()),
            job,
            _stage.settings(snakemake),
        )
