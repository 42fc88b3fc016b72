"""The interval of everything that follows from the moduli, and the draws that were pressed."""

import _stage
import pandas as pd

from mammosim.io.fiducials import read_fiducials
from mammosim.io.tables import read_table, read_those_there, write_table
from mammosim.study.propagation import FIT, position_rows, pressed_rows


def main(files: dict, volunteer: str) -> None:
    pressed, order = (read_those_there(files[name]) for name in ("pressed", "order"))
    pressed = pressed.merge(order, on=["volunteer", "side", "draw"])
    rows = position_rows(read_table(files["nipples"]), read_fiducials(files["fiducials"]))
    rows += pressed_rows(pressed, ranked=int(order.stored_energy_mj[order.draw > FIT].notna().sum()))
    table = pd.DataFrame(rows)
    table.insert(0, "volunteer", volunteer)
    write_table(table, files["rows"])
    write_table(pressed, files["pressed_rows"])


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(dict(snakemake.input.items()) | dict(snakemake.output.items()), snakemake.wildcards.v)
