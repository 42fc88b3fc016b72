"""One draw of the fit between the plates: its force and its glandular dose."""

import _stage
import pandas as pd

from mammosim.chain.view import spectrum_from
from mammosim.core.rng import seed_of
from mammosim.io.fiducials import read_fiducials
from mammosim.io.images import read_labels
from mammosim.io.meshes import read_mesh, read_point_data, write_mesh
from mammosim.io.tables import read_json, read_table, write_table
from mammosim.io.transforms import read_transform
from mammosim.study.identification.propagation import FIT, by_stiffness, drawn_body
from mammosim.study.identification.propagation_press import Measured, glandular_dose, pressed


def main(files: dict, job: dict, settings: dict, seed: int) -> None:
    mesh, tissues = read_mesh(files["mesh"]), settings["tissues"]
    measured = Measured(
        mesh,
        read_fiducials(files["fiducials"]).point(f"nipple_{job['side']}"),
        read_labels(files["labels"]),
        read_transform(files["transform"]).inverse()(mesh.points),
    )
    draw = FIT
    if job["rank"] != "fit":
        energies = read_table(files["order"][0]).stored_energy_mj.to_numpy()
        draw = int(by_stiffness(energies, settings["pressed"])[int(job["rank"])])
    body = drawn_body(mesh, read_table(files["samples"]).iloc[draw], tissues)
    rest = read_point_data(files["rests"], f"draw_{draw}")
    between = pressed(measured, body, rest, thickness_mm=settings["thickness_mm"], **settings["plates"])
    spectrum = spectrum_from(read_table(files["spectrum"]), read_json(files["facts"]))
    view = settings["view"] | {"skin_mm": tissues["skin"]["thickness_mm"]}
    dose = glandular_dose(measured, between, spectrum, side=job["side"], settings=view, seed=seed)
    write_table(pd.DataFrame([job | {"draw": draw, "force_n": between.force_n, **dose}]), files["row"])
    write_mesh(between.mesh.moved_to(between.found.points), files["shape"])


if __name__ == "__main__":
    with _stage.run(snakemake):
        job = {key: snakemake.wildcards[key] for key in ("side", "rank")}
        volunteer = snakemake.wildcards.v
        main(
            dict(snakemake.input.items()) | dict(snakemake.output.items()),
            {"volunteer": volunteer} | job,
            dict(snakemake.params.items()),
            seed_of(snakemake.params.seed, volunteer, *job.values(), "photons"),
        )
