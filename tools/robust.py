"""Run the published study as it is, on other meshes and with larger breasts, and say what each lacks.

usage: robust.py SNAKEMAKE CORES. Each variant of config/robust runs in robust/{variant}, from the results of
the study where these are there. Exits with 1 unless every one ends with its report and lacks nothing.
"""

import csv
import shutil
import subprocess
import sys
import time
from pathlib import Path

HOME = Path(__file__).parents[1]
KEPT = ("results", ".snakemake/metadata")


def main(snakemake: str, cores: str) -> int:
    rows = [row("published", snakemake, ["--cores", cores])]
    for variant in sorted((HOME / "config/robust").glob("*.yaml")):
        folder = HOME / "robust" / variant.stem
        if not folder.exists():
            start_from_the_study(folder)
        where = ["--configfile", str(variant), "--directory", str(folder)]
        rows.append(row(variant.stem, snakemake, ["--cores", cores, *where], folder=folder))
    out = HOME / "robust/outcome.csv"
    out.parent.mkdir(exist_ok=True)
    with out.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    sys.stdout.write(f"\n{out}:\n{out.read_text(encoding='utf-8')}")
    return int(any(each["report"] != "made" or each["missing"] for each in rows))


def start_from_the_study(folder: Path) -> None:
    """Copy the study's results and what Snakemake knows of them, so that only what differs is made again."""
    folder.mkdir(parents=True)
    for name in KEPT:
        if (HOME / name).exists():
            shutil.copytree(HOME / name, folder / name, symlinks=True)


def row(name: str, snakemake: str, arguments: list[str], *, folder: Path = HOME) -> dict[str, str | float]:
    """Run one study: whether it made its report, minutes by the clock, and what it lacks."""
    began = time.time()
    sys.stdout.write(f"\n{name}: {' '.join(arguments)}\n")
    sys.stdout.flush()
    ended = subprocess.run([snakemake, *arguments], cwd=HOME, check=False).returncode == 0
    made = folder / "results/study/missing.csv"
    missing = list(csv.DictReader(made.open(encoding="utf-8"))) if ended else []
    return {
        "study": name,
        "report": "made" if ended else "not made",
        "minutes": round((time.time() - began) / 60, 1),
        "missing": "; ".join(each["reason"] for each in missing),
    }


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
