"""Every way to the stress-free shape of one digital volunteer, with the right moduli, for one modulus."""

import _stage
import pandas as pd

from mammosim.core.positions import gravity_direction
from mammosim.core.tissues import tissues_by_label
from mammosim.digital.anatomy import make_anatomy
from mammosim.digital.loading import truth_mesh
from mammosim.digital.patient import VirtualPatient
from mammosim.io.tables import write_table
from mammosim.mechanics.body import Body, Skin
from mammosim.study.unloading import Case, rows, soft


def main(job: dict, woman: dict, tissues: dict, element_mm: dict, out: str) -> None:
    truth = truth_mesh(
        make_anatomy(VirtualPatient.read(woman)), breast_mm=element_mm["breast"], chest_mm=element_mm["chest"]
    )
    materials = soft(tissues_by_label(tissues["tissues"]), job["youngs_modulus_kpa"])
    body = Body(materials, (Skin(**tissues["skin"]),))
    found = rows(Case(truth, body, gravity_direction("prone")))
    write_table(pd.DataFrame([{**job, "nodes": len(truth.points), **row} for row in found]), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(
            {"volunteer": snakemake.wildcards.w, "youngs_modulus_kpa": float(snakemake.wildcards.kpa)},
            snakemake.params.woman,
            snakemake.params.tissues,
            snakemake.params.element_mm,
            snakemake.output[0],
        )
