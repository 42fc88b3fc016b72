"""The compressed breast as voxels between the plates, with a lesion, and what was conserved on the way."""

import _stage
import numpy as np

from mammosim.chain.phantom import Lesion, conservation, field_box, field_grid, voxel_breast, with_lesion
from mammosim.core.labels import Label
from mammosim.io.fiducials import read_fiducials
from mammosim.io.images import read_labels, write_labels
from mammosim.io.meshes import read_mesh
from mammosim.io.tables import read_json, write_table
from mammosim.io.transforms import read_transform


def main(files: dict[str, str], job: dict, settings: dict) -> None:
    mesh, plates = read_mesh(files["shape"]), read_json(files["plates"])
    segmentation = read_labels(files["labels"])
    to_scanner = read_transform(files["transform"]).inverse()
    measured = to_scanner(read_mesh(files["measured"]).points)
    low, high = field_box(
        job["side"],
        midline_mm=0.0,
        chest_wall_mm=plates["chest_y_mm"],
        bottom_mm=plates["support_z_mm"],
        top_mm=plates["paddle_z_mm"],
    )
    grid = field_grid(mesh, low, high, voxel_mm=settings["voxel_mm"])
    healthy = voxel_breast(mesh, measured, segmentation, grid=grid, skin_mm=settings["skin_mm"])
    density = {Label[name.upper()]: value for name, value in settings["density_g_cm3"].items()}
    table = conservation(mesh, measured, segmentation, healthy, density_g_cm3=density)
    for position, (name, value) in enumerate(job.items()):
        table.insert(position, name, value)
    write_table(table, files["conservation"])
    nipple = to_scanner(read_fiducials(files["fiducials"]).point(f"nipple_{job['side']}")[None])[0]
    centre = nipple + np.array([0.0, settings["lesion"]["depth_mm"], 0.0])
    lesion = Lesion(centre, settings["lesion"]["diameter_mm"] / 2)
    write_labels(with_lesion(healthy, mesh, measured, lesion), files["phantom"])


if __name__ == "__main__":
    with _stage.run(snakemake):
        job = {"volunteer": snakemake.wildcards.v} | {
            name: snakemake.wildcards[name] for name in ("side", "strategy", "moduli")
        }
        main(
            dict(snakemake.input.items())
            | {"phantom": snakemake.output.labels, "conservation": snakemake.output.conservation},
            job,
            dict(snakemake.params.items()),
        )
