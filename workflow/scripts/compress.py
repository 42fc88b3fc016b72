"""One breast between two plates from its stress-free shape: shape, force along the way, pressure, strain."""

import _log
import pandas as pd

from mammosim.core.tissues import tissues_by_label
from mammosim.io.fiducials import read_fiducials
from mammosim.io.meshes import read_mesh, write_mesh
from mammosim.io.tables import write_json, write_table
from mammosim.mechanics.body import Skin, body_effects
from mammosim.mechanics.compression import compress
from mammosim.mechanics.control import Thickness
from mammosim.mechanics.strain import cell_strain
from mammosim.study.points import MaterialPoints
from mammosim.study.press import craniocaudal_plates, plate_facts


def main(files: dict[str, str], job: dict, settings: dict) -> None:
    mesh, measured = read_mesh(files["mesh"]), read_mesh(files["measured"])
    nipple = read_fiducials(files["fiducials"]).point(f"nipple_{job['side']}")
    nipple = MaterialPoints.on(measured, nipple[None]).carry(mesh.points)[0]
    tissues = tissues_by_label(settings["tissues"]["tissues"])
    plates = craniocaudal_plates(
        mesh, nipple, plate_mm=settings["plate_mm"], chest_gap_mm=settings["chest_gap_mm"]
    )
    effects = body_effects(mesh, tissues, skin=Skin(**settings["tissues"]["skin"]))
    found = compress(mesh, effects, plates=plates, control=Thickness(settings["thickness_mm"]))
    strain = cell_strain(mesh, found.points)
    write_mesh(
        mesh.moved_to(found.points),
        files["shape"],
        point_data={"stress_free": mesh.points},
        cell_data={"J": strain.J, "largest_principal_strain": strain.principal[:, 2]},
    )
    write_table(found.path.assign(**job)[[*job, *found.path.columns]], files["path"])
    pressures = {
        name: contact.face_pressure for name, contact in zip(("paddle_kpa", "support_kpa"), found.contacts)
    }
    write_table(pd.DataFrame(pressures), files["faces"])
    columns = {f"principal_{i + 1}": strain.principal[:, i] for i in range(3)}
    write_table(pd.DataFrame(columns | {"J": strain.J, "tissue": mesh.tissue}), files["strain"])
    write_json(plate_facts(plates, settings["thickness_mm"]), files["plates"])


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        dict(snakemake.input.items()) | dict(snakemake.output.items()),
        {"volunteer": snakemake.wildcards.v, "side": snakemake.wildcards.side},
        dict(snakemake.params.items()),
    )
