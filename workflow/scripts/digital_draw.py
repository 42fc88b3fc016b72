"""Draw a digital volunteer until she has a stable state in every position; every refused draw is named."""

import logging
import sys

import _log
import pandas as pd

from mammosim.digital.anatomy import make_anatomy
from mammosim.digital.constitution import Constitution
from mammosim.digital.draw import Ranges, drawn_woman, first_accepted, refusal
from mammosim.digital.loading import truth_mesh
from mammosim.digital.motion import gravity_in_body, motion
from mammosim.io.tables import write_json, write_table


def main(files: dict[str, str], volunteer: str, settings: dict, gravities: dict) -> None:
    edges, ranges, stream = settings["element_mm"], Ranges(**settings["ranges"]), settings["stream"]

    def why_refused(woman: dict) -> str:
        anatomy = make_anatomy(woman)
        mesh = truth_mesh(anatomy, breast_mm=edges["breast"], chest_mm=edges["chest"])
        made_of = Constitution.from_parameters(woman, settings["tissues"])
        if why := refusal(anatomy, mesh, made_of, gravities):
            logging.warning("%s has no stable state and is drawn again; %s", volunteer, why)
            sys.stderr.write(f"{volunteer} has no stable state and is drawn again; {why}\n")
        return why

    numbers = range(1, settings["draws"] + 1)
    drawn = (drawn_woman(ranges, settings["between"], stream=(*stream, number)) for number in numbers)
    woman, reasons = first_accepted(drawn, why_refused)
    write_json(woman, files["woman"])
    rows = {"volunteer": volunteer, "draw": range(1, len(reasons) + 1), "refused": reasons}
    write_table(pd.DataFrame(rows), files["draws"])


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    settings, volunteer = dict(snakemake.params.items()), snakemake.wildcards.w
    lying = settings["moving"] | {"stream": (settings["stream"][0], volunteer)}
    main(
        dict(snakemake.output.items()),
        volunteer,
        settings,
        {p: gravity_in_body(p, motion(p, **lying)) for p in settings["positions"]},
    )
