"""One volunteer upright, with skins of several moduli."""

import _stage

from mammosim.figures.deformation import upright
from mammosim.io.fiducials import read_fiducials
from mammosim.io.figures import write_figure
from mammosim.io.meshes import read_mesh, read_point_data
from mammosim.io.tables import read_table


def main(files: dict[str, str], shapes: dict[str, str], volunteer: str, out: str) -> None:
    measured = read_mesh(files["measured"])
    meshes = {"measured, prone": measured}
    for name, path in shapes.items():
        meshes[name] = measured.moved_to(read_point_data(path, "predicted"))
    table = read_table(files["table"])
    x = read_fiducials(files["fiducials"]).point("nipple_left")[0]
    write_figure(upright(meshes, table[table.volunteer == volunteer], x_mm=x), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        inputs = {name: snakemake.input[name] for name in ("measured", "table", "fiducials")}
        names = ["without skin" if E == 0 else f"skin {E:g} kPa" for E in snakemake.params.skin_kpa]
        main(inputs, dict(zip(names, snakemake.input.shapes)), snakemake.wildcards.v, snakemake.output[0])
