"""The hemisphere as every program reads it."""

import _log

from mammosim.io.meshes import write_mesh_arrays
from mammosim.study.peers.mechanics import hemisphere


def main(edge_mm: float, layer_mm: float, out: str) -> None:
    write_mesh_arrays(hemisphere(edge_mm, layer_mm=layer_mm), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(float(snakemake.wildcards.edge), float(snakemake.wildcards.layer), snakemake.output[0])
