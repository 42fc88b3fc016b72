"""Distance between the estimated and the true stress-free skin."""

import _stage

from mammosim.io.meshes import read_mesh
from mammosim.io.tables import write_table
from mammosim.io.transforms import read_transform
from mammosim.study.identification.scores import score_row, shape_error


def main(files: dict[str, str], volunteer: str, method: str, out: str) -> None:
    motion = read_transform(files["motion"])
    error = shape_error(read_mesh(files["shape"]), read_mesh(files["truth"]), motion=motion)
    write_table(score_row(volunteer, {"method": method}, error), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(
            dict(snakemake.input.items()),
            snakemake.wildcards.w,
            snakemake.wildcards.method,
            snakemake.output[0],
        )
