"""A position that no fit saw, predicted over measured, and the distances of the skin in every position."""

import _stage
import numpy as np

from mammosim.core.errors import MissingResult
from mammosim.figures.validation import SkinMap, prediction
from mammosim.io.fiducials import read_fiducials
from mammosim.io.figures import write_figure
from mammosim.io.meshes import read_mesh
from mammosim.meshing.distance import distance_opposite, distance_to_rim
from mammosim.study.identification.validation import CUT_MM, skin_distances


def main(files: dict, position: str, fitted: dict[str, bool], out: str) -> None:
    pairs = {}
    for name, shape, measured in zip(fitted, files["shapes"], files["measured"]):
        try:
            pairs[name] = read_mesh(shape), read_mesh(measured)
        except MissingResult:
            if name == position:
                raise
    known = {name: pair for name, pair in pairs.items() if np.isfinite(pair[0].points).all()}
    distances = {
        f"{name.replace('_', ' ')}, {'fitted' if fitted[name] else 'held out'}": skin_distances(*pair)
        for name, pair in known.items()
    }
    measured = pairs[position][1]
    shapes, away = {"measured": measured}, np.full(len(measured.boundary_nodes("skin")), np.nan)
    if position in known:
        shapes["predicted"] = known[position][0]
        near_cut = distance_to_rim(measured) < CUT_MM
        away = np.where(near_cut, np.nan, distance_opposite(measured, shapes["predicted"]))
    x, _, z = read_fiducials(files["fiducials"]).point("nipple_left")
    write_figure(prediction(shapes, SkinMap(measured, away), distances, x_mm=x, z_mm=z), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(
            dict(snakemake.input.items()),
            snakemake.wildcards.p,
            dict(snakemake.params.fitted),
            snakemake.output[0],
        )
