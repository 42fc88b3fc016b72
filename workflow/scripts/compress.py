"""One breast pressed by one strategy from its stress-free shape: shape, way, thickness, strain, pressure."""

import sys

import _stage
import numpy as np
import pandas as pd

from mammosim.chain.points import MaterialPoints
from mammosim.chain.pressed import pressed, refused
from mammosim.chain.strategies import STANDARD, NoStandard, Scene, Strategy, Way
from mammosim.core.errors import MechanicsError, MeshError, MissingResult
from mammosim.io.fiducials import read_fiducials
from mammosim.io.meshes import read_mesh, read_point_data, write_mesh
from mammosim.io.missing import PREFIX, write_missing
from mammosim.io.tables import read_json, read_table, write_json, write_table


def main(files: dict, job: dict, settings: dict) -> None:
    mesh, measured = read_mesh(files["mesh"]), read_mesh(files["measured"])
    nipple = read_fiducials(files["fiducials"]).point(f"nipple_{job['side']}")
    nipple = MaterialPoints.on(measured, nipple[None]).carry(mesh.points)[0]
    scene = Scene.craniocaudal(
        mesh, nipple, settings, moduli=job["moduli"], standard=way_of(files["standard"])
    )
    shapes = {"stress_free": mesh.points}
    try:
        found = Strategy.of(settings["strategy"]).press(scene)
        made = pressed(scene, found, settings["thresholds"])
        shapes |= Way.of(found).point_data() if job["strategy"] == STANDARD else {}
        write_json(made.plates, files["plates"])
    except (MechanicsError, MeshError) as error:
        reason, outcome = why(error, job, files["standard"])
        made = refused(mesh, outcome)
        write_missing(files["plates"], reason)
    cells = {name: made.cells[name].to_numpy() for name in made.cells.columns.drop("tissue")}
    write_mesh(mesh.moved_to(made.points), files["shape"], point_data=shapes, cell_data=cells)
    write_table(made.faces, files["faces"])
    tables = {"path": made.path, "amounts": made.amounts, "thickness": made.thickness}
    for name, table in (tables | {"row": pd.DataFrame([made.row])}).items():
        write_table(table.assign(**job)[[*job, *table.columns]], files[name])


def why(error: Exception, job: dict, standard: list[str]) -> tuple[str, str]:
    """Why a strategy is missing, for what follows from it, and for its own row."""
    if isinstance(error, NoStandard):
        try:
            read_json(standard[2])
        except MissingResult as root:
            return str(root), f"{PREFIX}{root}"
    words = " ".join(str(error).split())
    sys.stderr.write(f"\nmissing, and the other jobs go on: compress {' '.join(job.values())}: {words}\n\n")
    return f"compress {' '.join(job.values())}: {words}", f"refused: {words}"


def way_of(files: list[str]) -> Way:
    """The way of the standard strategy; without steps where this is that one, or that one was refused."""
    path = read_table(files[1]) if files else pd.DataFrame()
    return Way(path, np.array([read_point_data(files[0], name) for name in Way.names(len(path))]))


if __name__ == "__main__":
    with _stage.run(snakemake):
        job = {"volunteer": snakemake.wildcards.v} | {
            name: snakemake.wildcards[name] for name in ("side", "strategy", "moduli")
        }
        files = dict(snakemake.input.items()) | dict(snakemake.output.items())
        main(files, job, dict(snakemake.params.items()))
