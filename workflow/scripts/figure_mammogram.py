"""The mammogram of one breast as it is read."""

import _stage

from mammosim.figures.radiograph import mammogram
from mammosim.io.figures import write_figure
from mammosim.io.images import read_image
from mammosim.io.tables import read_table


def main(files: dict[str, str], side: str, out: str) -> None:
    layers = read_image(files["image"])
    image, lesion, _ = layers.values
    row = read_table(files["row"]).iloc[0].to_dict()
    pixel = float(layers.grid.spacing[0])
    write_figure(mammogram(image, pixel_mm=pixel, lesion=lesion > 0.5, row=row, side=side), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(dict(snakemake.input.items()), snakemake.wildcards.side, snakemake.output[0])
