"""The report: sections.yaml says which figures and tables stand where; numbers come from the results."""

from pathlib import Path

import _log
import pandas as pd
import yaml

from mammosim.figures.cost import time_and_memory
from mammosim.io.figures import png_of
from mammosim.io.tables import read_json, read_table
from mammosim.io.tabulated import tabulated
from mammosim.study.bibliography import entries
from mammosim.study.report import Listing, Picture, Section, report


def main(files: dict, title: str, out: str) -> None:
    layout = yaml.safe_load(Path(files["text"]).read_text())
    numbers, made = read_json(files["numbers"]), read_json(files["provenance"])
    frames = {Path(path).stem: read_table(path) for path in files["tables"]}
    frames["quality"] = read_table(files["quality"])
    frames["assumptions"] = pd.DataFrame(made["assumptions"])
    frames["versions"] = pd.DataFrame(made["packages"].items(), columns=["package", "version"])
    frames["sources"] = pd.DataFrame(entries(Path(files["bibliography"]).read_text()))
    frames["published"] = tabulated("published_biomechanics")
    pictures = {Path(path).stem: Path(path).read_bytes() for path in files["pictures"]}
    pictures["cost"] = png_of(time_and_memory(benchmarks(Path("results/benchmarks"))))
    sections = tuple(section(part, pictures, frames) for part in layout["sections"])
    Path(out).write_text(report(title, sections, numbers=numbers, subtitle=layout["subtitle"]))


def section(part: dict, pictures: dict[str, bytes], frames: dict[str, pd.DataFrame]) -> Section:
    """One section with the figures whose names begin with the words listed, and its tables."""
    blocks: list[Picture | Listing] = []
    for prefix, caption in part.get("figures", {}).items():
        for name in (name for name in pictures if name == prefix or name.startswith(f"{prefix}_")):
            what = name.removeprefix(prefix).strip("_").replace("_", " ")
            blocks.append(Picture(pictures[name], caption.format(what=what)))
    for name, table in part.get("tables", {}).items():
        if name in frames:
            frame = frames[name]
            blocks.append(Listing(frame[table.get("columns", list(frame.columns))], table["caption"]))
    return Section(part["title"], part.get("text", ""), tuple(blocks))


def benchmarks(folder: Path) -> pd.DataFrame:
    """What Snakemake measured of every job so far."""
    parts = [pd.read_table(path).assign(rule=path.parent.name) for path in sorted(folder.glob("*/*.tsv"))]
    return pd.concat(parts, ignore_index=True)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        dict(snakemake.input.items()),
        f"mammosim: {', '.join(snakemake.params.volunteers)}",
        snakemake.output[0],
    )
