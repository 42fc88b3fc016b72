"""Strain, energy and pressure in one breast, by every strategy that found an equilibrium."""

import _stage
import numpy as np

from mammosim.figures.strategies import Strained, discomfort
from mammosim.io.figures import write_figure
from mammosim.io.meshes import read_cell_data, read_mesh
from mammosim.io.tables import read_if_there, read_json


def main(files: dict, strategies: list[str], out: str) -> None:
    pressed = {}
    for name, shape, faces in zip(strategies, files["shapes"], files["faces"]):
        if len(table := read_if_there(faces)):
            measures = {each: read_cell_data(shape, each) for each in ("logarithmic", "energy_kpa")}
            pressed[name] = Strained(read_mesh(shape), pressure_kpa=table.pressure_kpa.to_numpy(), **measures)
    facts = read_json(files["plates"])
    x = (facts["low_x_mm"] + facts["high_x_mm"]) / 2
    z = (facts["support_z_mm"] + facts["paddle_z_mm"]) / 2
    write_figure(discomfort(pressed, centre=np.array([x, facts["chest_y_mm"], z])), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(dict(snakemake.input.items()), snakemake.params.strategies, snakemake.output[0])
