"""One published model on one breast: its row, and its stress-free shape."""

import _stage
import pandas as pd

from mammosim.chain.files import grouped
from mammosim.chain.graph import Chain
from mammosim.chain.subject import Subject
from mammosim.core.errors import MammosimError
from mammosim.io.meshes import write_mesh
from mammosim.io.missing import write_missing
from mammosim.io.tables import read_json, write_table
from mammosim.io.written import read_fiducials
from mammosim.study.models.model import Model
from mammosim.study.models.rows import POSITIONS, measured_row


def main(files: dict, job: dict, settings: dict, out: dict) -> None:
    model = Model.of(job["model"], settings["model"])
    given = settings["given"]
    subject = Subject.of(given["subject"])
    chain = Chain(subject, given["settings"], frozenset(given["effects"]), model.stages).kept(grouped(files))
    nipples = {
        position: read_fiducials(files[f"nipples_{position}"]).point(f"nipple_{job['side']}")
        for position in POSITIONS
        if f"nipples_{position}" in files
    }
    took = sum(seconds for path in files["took"] for seconds in read_json(path).values())
    row = measured_row(chain, nipples, took=took)
    write_table(pd.DataFrame([{**job, **model.words, **row}]), out["row"])
    try:
        write_mesh(chain["stress_free"].mesh, out["shape"])
    except MammosimError as error:  # the row says so, too
        write_missing(out["shape"], " ".join(str(error).split()), job=job)


if __name__ == "__main__":
    with _stage.run(snakemake) as job:
        files, out = (dict(each.items()) for each in (snakemake.input, snakemake.output))
        main(files, job, _stage.settings(snakemake), out)
