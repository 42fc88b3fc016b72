"""A figure of files of results, drawn by a function of workflow/scripts/drawn."""

from importlib import import_module

import _stage

from mammosim.io.figures import write_figure


def main(function: str, files: dict, told: dict, job: dict[str, str], out: str) -> None:
    module, name = function.split(".")
    draw = getattr(import_module(f"drawn.{module}"), name)
    write_figure(draw(files, told, job), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(
            snakemake.params.function,
            dict(snakemake.input.items()),
            _stage.settings(snakemake),
            dict(snakemake.wildcards.items()),
            snakemake.output[0],
        )
