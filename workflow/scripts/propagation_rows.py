"""The interval of everything that follows from the moduli, and the draws that were pressed."""

import _stage
import pandas as pd

from mammosim.io.missing import missing_rows
from mammosim.io.tables import read_rows, read_table, read_those_there, write_table
from mammosim.io.written import read_fiducials
from mammosim.study.identification.propagation import FIT, position_rows, pressed_rows


def main(files: dict, volunteer: str) -> None:
    rows = position_rows(read_table(files["nipples"]), read_fiducials(files["fiducials"]))
    every = pd.concat(map(read_rows, files["pressed"]), ignore_index=True)
    gone = missing_rows(every)
    pressed = every[~gone].drop(columns="outcome", errors="ignore")
    if len(pressed):
        order = read_those_there(files["order"])
        pressed = pressed.merge(order, on=["volunteer", "side", "draw"], how="left")
        for side, draws in pressed.groupby("side", sort=False):
            shaped = order[(order.side == side) & (order.draw > FIT)].stored_energy_mj.notna()
            rows += pressed_rows(draws, ranked=int(shaped.sum()))
    table = pd.DataFrame(rows)
    table.insert(0, "volunteer", volunteer)
    write_table(table, files["rows"])
    # The reasons of draws that were not pressed stay in their table.
    reasons = every.loc[gone, ["volunteer", "side", "rank", "outcome"]] if gone.any() else pressed.iloc[:0]
    write_table(pd.concat([pressed, reasons]), files["pressed_rows"])


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(dict(snakemake.input.items()) | dict(snakemake.output.items()), snakemake.wildcards.v)
