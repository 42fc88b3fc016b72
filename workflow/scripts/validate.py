"""One measured position against the prediction of the fitted body: a row per quantity, and the shape."""

import _stage

from mammosim.chain.outcome import CONVERGED
from mammosim.core.fiducials import midline_mm
from mammosim.core.positions import gravity_vector
from mammosim.core.settings import read
from mammosim.io.meshes import read_mesh, write_mesh
from mammosim.io.tables import read_table, write_table
from mammosim.io.tabulated import tabulated
from mammosim.io.transforms import read_transform
from mammosim.io.written import read_fiducials
from mammosim.study.identification.moduli import Materials, Moduli
from mammosim.study.identification.validation import Start, errors, predicted, rows


def main(files: dict[str, str], job: dict, settings: dict) -> None:
    mesh = read_mesh(files["start"])
    start = Start(mesh, read_fiducials(files["start_fiducials"]), read_mesh(files["stress_free"]).points)
    body = Moduli.of_rows(read_table(files["moduli"])).body(
        mesh,
        read(Materials, settings["tissues"], "tissues"),
        middle_mm=midline_mm(start.fiducials),
        poisson_ratio=float(read_table(files["fit"]).poisson_ratio.iloc[0]),
    )
    gravity = read_transform(files["transform"]).R @ gravity_vector(settings["gravity"])
    found = predicted(start, body, gravity)
    measured = read_mesh(files["measured"]), read_fiducials(files["fiducials"])
    published = tabulated("published_errors").query("source == 'Mira 2018'").set_index("what").error_mm
    table = rows(
        job,
        found,
        found=errors(start, found.points, *measured) if found.outcome == CONVERGED else {},
        before=errors(start, mesh.points, *measured),
        published={"skin_hausdorff": published.get(job["position"], float("nan"))},
    )
    write_table(table, files["rows"])
    write_mesh(mesh.moved_to(found.points), files["shape"])


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(
            dict(snakemake.input.items()) | dict(snakemake.output.items()),
            {
                "volunteer": snakemake.wildcards.v,
                "position": snakemake.wildcards.p,
                "fitted": snakemake.params.fitted,
            },
            _stage.settings(snakemake),
        )
