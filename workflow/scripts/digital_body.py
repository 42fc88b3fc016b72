"""The stress-free body of a digital volunteer as a mesh, and what it consists of."""

import _log
import numpy as np

from mammosim.core.labels import Label
from mammosim.digital.anatomy import make_anatomy
from mammosim.digital.loading import truth_mesh
from mammosim.io.meshes import write_mesh
from mammosim.io.tables import write_json

COUNTED_MM = 2.0


def main(woman: dict, element_mm: dict, mesh_path: str, facts: str) -> None:
    anatomy = make_anatomy(woman)
    mesh = truth_mesh(anatomy, breast_mm=element_mm["breast"], chest_mm=element_mm["chest"])
    write_mesh(mesh, mesh_path)
    values = {}
    for side, mound in zip(("left", "right"), anatomy.mounds):
        points = anatomy.breast_points(mound, COUNTED_MM)
        labels = anatomy.labels_at(points)
        values[f"breast_{side}_cm3"] = len(points) * COUNTED_MM**3 / 1e3
        values[f"gland_fraction_{side}"] = float(np.mean(labels == Label.GLANDULAR))
    write_json(values, facts)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        snakemake.params.woman,
        snakemake.params.element_mm,
        snakemake.output.mesh,
        snakemake.output.facts,
    )
