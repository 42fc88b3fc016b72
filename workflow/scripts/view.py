"""The bodies of one woman for the page that turns them: measured, unloaded, predicted and pressed."""

from pathlib import Path

import _stage

from mammosim.core.errors import MissingResult
from mammosim.io.atomic import replacing
from mammosim.io.meshes import read_cell_data, read_mesh, read_point_data
from mammosim.io.tables import read_table
from mammosim.study.report.view import Body, script

STRAIN = ("logarithmic", "von_mises_kpa", "energy_kpa")


def main(volunteer: str, told: list[dict], absent: list[str], out: str) -> None:
    """told: group, name, kind and path of every body; absent: what her data do not allow, and why."""
    bodies, absent = [], list(absent)
    for each in told:
        try:
            bodies.append(body(**each))
        except MissingResult as reason:
            absent.append(f"{each['group']}, {each['name']} is missing: {reason}")
    with replacing(out) as temporary:
        temporary.write_text(script(volunteer, bodies, absent), encoding="utf-8")


def body(group: str, name: str, kind: str, path: str) -> Body:
    mesh = read_mesh(path)
    if kind == "predicted":
        return Body(group, name, mesh.moved_to(read_point_data(path, "predicted")))
    if kind == "pressed":
        pressure = read_table(Path(path).with_name(f"{Path(path).stem}_faces.csv")).pressure_kpa.to_numpy()
        return Body(
            group, name, mesh, {f: read_cell_data(path, f) for f in STRAIN}, {"pressure_kpa": pressure}
        )
    return Body(group, name, mesh)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(snakemake.wildcards.v, snakemake.params.told, snakemake.params.absent, snakemake.output[0])
