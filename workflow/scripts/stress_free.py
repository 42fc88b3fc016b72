"""The shape without gravity by one method: mesh, and the residual at every iteration."""

import _log
import numpy as np
import pandas as pd

from mammosim.core.mesh import TetMesh
from mammosim.core.tissues import tissues_by_label
from mammosim.io.meshes import read_mesh, write_mesh
from mammosim.io.tables import write_table
from mammosim.io.transforms import read_transform
from mammosim.mechanics.body import Skin, load
from mammosim.mechanics.equilibrium import Equilibrium
from mammosim.mechanics.unloaded import FixedPointSettings, fixed_point, reverse_gravity
from mammosim.study.configuration import gravity_vector


def main(files: dict[str, str], job: dict, settings: dict) -> None:
    measured = read_mesh(files["mesh"])
    gravity = read_transform(files["transform"]).R @ gravity_vector(settings["gravity"])
    tissues = tissues_by_label(settings["tissues"]["tissues"])
    skin = Skin(**settings["tissues"]["skin"])

    def loaded(reference: TetMesh, g: np.ndarray, start: np.ndarray | None) -> Equilibrium:
        return load(reference, tissues, g, skin=skin, start=start)

    if job["method"] == "reverse_gravity":
        found = reverse_gravity(measured, loaded, gravity=gravity)
    else:
        limits = FixedPointSettings(settings["tolerance_mm"], settings["iterations"])
        found = fixed_point(measured, loaded, gravity=gravity, settings=limits)
    columns = {name: [getattr(step, name) for step in found.history] for name in HISTORY}
    write_table(pd.DataFrame(columns).assign(**job)[[*job, *HISTORY]], files["history"])
    write_mesh(measured.moved_to(found.points), files["shape"])


HISTORY = ["iteration", "mean_mm", "max_mm", "damping", "factorisations", "seconds"]

if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        dict(snakemake.input.items()) | dict(snakemake.output.items()),
        {
            "volunteer": snakemake.wildcards.v,
            "position": snakemake.wildcards.p,
            "method": snakemake.wildcards.method,
        },
        dict(snakemake.params.items()),
    )
