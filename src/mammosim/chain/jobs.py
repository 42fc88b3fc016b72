"""One job of the workflow: products are made and written to its outputs."""

from collections.abc import Iterable, Mapping

from mammosim.chain.files import SECONDS, grouped
from mammosim.chain.graph import Chain
from mammosim.chain.stages import STAGES
from mammosim.io.tables import write_json


def make(chain: Chain, products: Iterable[str], files: Mapping[str, str], job: Mapping[str, str]) -> None:
    """Make products and write them to the outputs of a job.

    job: the columns that tell the rows of tables apart, with their values.
    """
    paths, told = grouped(files), set()
    for name in products:
        STAGES[name].save(chain[name], paths[name], job)
        took = {each: s for each, s in chain.seconds(name).items() if s > 0 and each not in told}
        told |= set(took)
        write_json(took, paths[SECONDS][name])
