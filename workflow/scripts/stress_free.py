"""The shape without gravity by one method: mesh, and the residual at every iteration."""

import _stage
import pandas as pd

from mammosim.chain.configuration import gravity_vector
from mammosim.core.tissues import tissues_by_label
from mammosim.io.meshes import read_mesh, write_mesh
from mammosim.io.tables import write_table
from mammosim.io.transforms import read_transform
from mammosim.mechanics.body import Body, Skin
from mammosim.mechanics.unloaded import UnloadingSettings
from mammosim.mechanics.unloading import METHODS


def main(files: dict[str, str], job: dict, settings: dict) -> None:
    measured = read_mesh(files["mesh"])
    gravity = read_transform(files["transform"]).R @ gravity_vector(settings["gravity"])
    tissues, skin = settings["tissues"]["tissues"], settings["tissues"]["skin"]
    found = METHODS[job["method"]](
        measured,
        Body(tissues_by_label(tissues), (Skin(**skin),)),
        gravity=gravity,
        start=read_mesh(files["start"]).points if files["start"] else None,
        settings=UnloadingSettings(settings["tolerance_mm"], settings["iterations"]),
    )
    columns = {name: [getattr(step, name) for step in found.history] for name in HISTORY}
    write_table(pd.DataFrame(columns).assign(**job)[[*job, *HISTORY]], files["history"])
    write_mesh(measured.moved_to(found.points), files["shape"])


HISTORY = ["iteration", "mean_mm", "max_mm", "damping", "factorisations", "seconds"]

if __name__ == "__main__":
    with _stage.run(snakemake):
        main(
            dict(snakemake.input.items()) | dict(snakemake.output.items()),
            {
                "volunteer": snakemake.wildcards.v,
                "position": snakemake.wildcards.p,
                "method": snakemake.wildcards.method,
            },
            dict(snakemake.params.items()),
        )
