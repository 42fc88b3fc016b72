"""Sample a virtual patient until she has a stable state in every position; every one that fails is named."""

import logging
import sys

import _log
import _stage
import pandas as pd

from mammosim.core.settings import read
from mammosim.core.tissues import TissueTable
from mammosim.digital.anatomy import make_anatomy
from mammosim.digital.constitution import Constitution
from mammosim.digital.loading import gravity_in_body, motion, truth_mesh
from mammosim.digital.patient import VirtualPatient
from mammosim.digital.sampling import Ranges, failure, first_stable, sampled_patient
from mammosim.io.tables import write_json, write_table


def main(files: dict[str, str], volunteer: str, settings: dict, gravities: dict) -> None:
    edges, stream = settings["element_mm"], settings["stream"]
    ranges = read(Ranges, settings["ranges"], "ranges")
    common = read(TissueTable, settings["tissues"], "digital.tissues")
    one, other = (VirtualPatient.read(values, at="digital.women") for values in settings["between"])

    def failure_of(patient: VirtualPatient) -> str:
        anatomy = make_anatomy(patient)
        mesh = truth_mesh(anatomy, breast_mm=edges["breast"], chest_mm=edges["chest"])
        if why := failure(anatomy, mesh, Constitution.of(patient, common), gravities):
            logging.warning("%s has no stable state and is sampled again; %s", volunteer, why)
            sys.stderr.write(f"{volunteer} has no stable state and is sampled again; {why}\n")
        return why

    numbers = range(1, settings["draws"] + 1)
    sampled = (sampled_patient(ranges, (one, other), stream=(*stream, number)) for number in numbers)
    patient, failures = first_stable(sampled, failure_of)
    write_json(patient.values(), files["woman"])
    outcomes = [f"failed: {why}" if why else "converged" for why in failures]
    rows = {"volunteer": volunteer, "draw": range(1, len(failures) + 1), "outcome": outcomes}
    write_table(pd.DataFrame(rows), files["draws"])


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    settings, volunteer = _stage.settings(snakemake), snakemake.wildcards.w
    moving = settings["moving"] | {"stream": (settings["stream"][0], volunteer)}
    main(
        dict(snakemake.output.items()),
        volunteer,
        settings,
        {p: gravity_in_body(p, motion(p, **moving)) for p in settings["positions"]},
    )
