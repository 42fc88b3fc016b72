"""How far the estimated rigid motion is from the true one, at the breast markers and nipples."""

import _stage

from mammosim.io.tables import read_table, write_table
from mammosim.io.transforms import read_transform
from mammosim.io.written import read_fiducials
from mammosim.study.identification.scores import registration_error, score_row


def main(files: dict[str, str], volunteer: str, position: str, out: str) -> None:
    fiducials, steps = read_fiducials(files["fiducials"]), read_table(files["steps"])
    points = fiducials.points[[kind != "chest" for kind in fiducials.kinds]]
    motions = (read_transform(files[name]) for name in ("estimated", "true_moving", "true_fixed"))
    error = registration_error(*motions, points)
    error["marker_residual_mm"] = float(steps.marker_residual_mm[steps.used].iloc[0])
    write_table(score_row(volunteer, {"position": position}, error), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(
            dict(snakemake.input.items()),
            snakemake.wildcards.w,
            snakemake.wildcards.p,
            snakemake.output[0],
        )
