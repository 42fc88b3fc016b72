"""Whether the detectors hold the shadow of one compressed breast, and with how much room."""

import sys

import _stage

from mammosim.chain.field import HELD, field_rows
from mammosim.io.images import read_labels
from mammosim.io.tables import read_json, write_table


def main(files: dict[str, str], job: dict, settings: dict) -> None:
    labels, plates = read_labels(files["phantom"]), read_json(files["plates"])
    rows = field_rows(labels, chest_y_mm=plates["chest_y_mm"], **settings)
    for row in rows[rows.outcome != HELD].itertuples():
        sys.stderr.write(f"\n{row.view} {' '.join(job.values())}: {row.outcome}\n\n")
    write_table(rows.assign(**job)[[*job, *rows.columns]], files["rows"])


if __name__ == "__main__":
    with _stage.run(snakemake):
        names = {name: snakemake.wildcards[name] for name in ("side", "strategy", "moduli")}
        main(
            dict(snakemake.input.items()) | dict(snakemake.output.items()),
            {"volunteer": snakemake.wildcards.v} | names,
            dict(snakemake.params.items()),
        )
