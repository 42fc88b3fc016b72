"""One breast between the plates: shape, strain, pressure."""

import _stage
import numpy as np

from mammosim.figures.compression import Plate, compressed_breast
from mammosim.io.figures import write_figure
from mammosim.io.meshes import read_cell_data, read_mesh
from mammosim.io.tables import read_json, read_table


def main(files: dict[str, str], out: str) -> None:
    compressed, facts = read_mesh(files["shape"]), read_json(files["plates"])
    mesh = read_mesh(files["stress_free"])
    half = np.array([facts["high_x_mm"] - facts["low_x_mm"], facts["depth_mm"], facts["height_mm"]]) / 2
    x = (facts["low_x_mm"] + facts["high_x_mm"]) / 2
    y = facts["chest_y_mm"] - half[1]
    heights = (facts["paddle_z_mm"] + half[2], facts["support_z_mm"] - half[2])
    figure = compressed_breast(
        mesh,
        compressed,
        tuple(Plate(np.array([x, y, z]), np.eye(3), half) for z in heights),
        strain=read_cell_data(files["shape"], "green_lagrange"),
        pressure=read_table(files["faces"]).paddle_kpa.to_numpy(),
        cut_x_mm=x,
    )
    write_figure(figure, out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(dict(snakemake.input.items()), snakemake.output[0])
