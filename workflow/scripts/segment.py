"""Tissue labels of one image from a few strokes, and the probability of gland."""

import _stage

from mammosim.core.rng import seed_of
from mammosim.imaging.segmentation import Settings, segment
from mammosim.io.images import read_image, write_image, write_labels
from mammosim.io.tables import read_table


def main(image: str, strokes: str, settings: Settings, labels: str, probability: str) -> None:
    found = segment(read_image(image), read_table(strokes), settings=settings)
    write_labels(found.labels, labels)
    write_image(found.probability, probability)


if __name__ == "__main__":
    with _stage.run(snakemake):
        v, p = snakemake.wildcards.v, snakemake.wildcards.p
        main(
            snakemake.input.image,
            snakemake.input.strokes,
            Settings(**snakemake.params.settings, seed=seed_of(snakemake.params.seed, v, p, "segment")),
            snakemake.output.labels,
            snakemake.output.probability,
        )
