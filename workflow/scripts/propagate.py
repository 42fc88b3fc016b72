"""Every draw of the fit unloaded, and loaded in a new position: its nipples, and its shape at rest."""

from functools import partial

import _stage

from mammosim.core.positions import gravity_vector
from mammosim.core.settings import read
from mammosim.io.meshes import read_mesh, write_mesh
from mammosim.io.tables import read_table, write_table
from mammosim.io.transforms import read_transform
from mammosim.io.written import read_fiducials
from mammosim.mechanics.body import SIDES
from mammosim.mechanics.inverse import InverseSettings, inverse
from mammosim.study.identification.moduli import Materials
from mammosim.study.identification.propagation import drawn_body, nipple_table, repositioned

# Of the weight: Newton has then two steps behind it, and its next one moves the skin by 0.01 mm or less.
TOLERANCE = 1e-2


def main(files: dict[str, str], volunteer: str, settings: dict) -> None:
    mesh, fiducials = read_mesh(files["mesh"]), read_fiducials(files["fiducials"])
    samples = read_table(files["samples"]).head(settings["draws"])
    turned = [read_transform(files[name]).R for name in ("from_transform", "to_transform")]
    gravity, new_gravity = (R @ gravity_vector(text) for R, text in zip(turned, settings["gravity"]))
    assumed = read(Materials, settings["tissues"], "tissues")
    draws = repositioned(
        mesh,
        [drawn_body(mesh, draw, assumed) for _, draw in samples.iterrows()],
        unload=partial(inverse, settings=InverseSettings(tolerance=TOLERANCE)),
        gravity=gravity,
        new_gravity=new_gravity,
        rest=read_mesh(files["stress_free"]).points,
    )
    nipples = {side: fiducials.point(f"nipple_{side}") for side in SIDES}
    table = nipple_table(mesh, nipples, draws)
    table.insert(0, "volunteer", volunteer)
    write_table(table, files["nipples"])
    write_mesh(mesh, files["rests"], point_data={f"draw_{n}": draw.rest for n, draw in enumerate(draws)})


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(
            dict(snakemake.input.items()) | dict(snakemake.output.items()),
            snakemake.wildcards.v,
            _stage.settings(snakemake),
        )
