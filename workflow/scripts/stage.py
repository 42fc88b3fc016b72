"""Make products of the chain, each by its stage, and write them."""

import _stage

from mammosim.chain.files import chain_of
from mammosim.chain.jobs import make

if __name__ == "__main__":
    with _stage.run(snakemake) as job:
        chain = chain_of(snakemake.params.given, dict(snakemake.input.items()))
        make(chain, snakemake.params.products, dict(snakemake.output.items()), job)
