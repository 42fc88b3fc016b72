"""One breast pressed by one strategy from its stress-free shape: shape, way, thickness, strain, pressure."""

import sys

import _stage
import numpy as np
import pandas as pd

from mammosim.core.errors import MechanicsError, MeshError
from mammosim.io.fiducials import read_fiducials
from mammosim.io.meshes import read_mesh, read_point_data, write_mesh
from mammosim.io.missing import write_missing
from mammosim.io.tables import read_table, write_json, write_table
from mammosim.study.points import MaterialPoints
from mammosim.study.pressed import pressed, refused
from mammosim.study.strategies import STANDARD, Scene, Strategy, Way


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
        made = refused(mesh, str(error))
        sys.stderr.write(f"\n{' '.join(job.values())}: {made.row['outcome']}\n\n")
        write_missing(files["plates"], f"compress {' '.join(job.values())}: {error}")
    cells = {name: made.cells[name].to_numpy() for name in made.cells.columns.drop("tissue")}
    write_mesh(mesh.moved_to(made.points), files["shape"], point_data=shapes, cell_data=cells)
    write_table(made.faces, files["faces"])
    tables = {"path": made.path, "amounts": made.amounts, "thickness": made.thickness}
    for name, table in (tables | {"row": pd.DataFrame([made.row])}).items():
        write_table(table.assign(**job)[[*job, *table.columns]], files[name])


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
