"""Products of a chain as files of a job: how its inputs and outputs are named, and the chain of a job."""

import hashlib
from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any

from mammosim.chain.graph import Chain, Files
from mammosim.chain.stages import STAGES
from mammosim.chain.subject import Subject

SECONDS = "seconds"
BETWEEN = "__"  # product and file in the name of an input or output of a job


def job_inputs(
    products: Collection[str],
    wildcards: Mapping[str, str],
    chain: Chain,
    *,
    also: Callable[[str], str] = lambda name: "",
) -> dict[str, str]:
    """What a job that makes these products reads: `product__file` -> path.

    Of products that are not kept, what they are made of. also: of a product, what its variant is called.
    """
    needed = nearest_kept(products, chain)
    return _named({name: _files(name).paths({**wildcards, "also": also(name)}) for name in needed})


def variant_of(name: str, chain: Chain, study: Chain) -> str:
    """What a product of a chain is called beside that of the study: nothing where they are the same."""
    key = chain.key(name)
    return "" if key == study.key(name) else f"-{hashlib.sha256(repr(key).encode()).hexdigest()[:8]}"


def nearest_kept(products: Collection[str], chain: Chain) -> tuple[str, ...]:
    """The kept products that a job reads to make these with the settings and effects of a chain."""
    found: dict[str, None] = {}
    for need in (each for product in products for each in chain.needs(product)):
        if need not in products:
            kept = STAGES[need].files is not None
            nearest = (need,) if kept else nearest_kept((need,), chain)
            found |= dict.fromkeys(each for each in nearest if each not in products)
    return tuple(found)


def job_outputs(products: Iterable[str], wildcards: Mapping[str, str]) -> dict[str, str]:
    """What a job writes that makes these products: `product__file` -> path.

    `seconds__product`: the processor time that it took.
    """
    outputs = {name: _files(name).paths(wildcards, beside=True) for name in products}
    return _named(outputs) | _named({SECONDS: {name: seconds_file(name, wildcards) for name in outputs}})


def seconds_file(name: str, wildcards: Mapping[str, str]) -> str:
    """The file that says what a product took."""
    return f"{_files(name).stem.format(**wildcards)}_{name}_seconds.json"


def grouped(files: Mapping[str, str]) -> dict[str, dict[str, str]]:
    """Inputs or outputs of a job as product -> file -> path; those that are not of a product are left out."""
    found: dict[str, dict[str, str]] = {}
    for name, path in files.items():
        if BETWEEN in name:
            product, file = name.split(BETWEEN)
            found.setdefault(product, {})[file] = path
    return found


def chain_of(given: Mapping[str, Any], files: Mapping[str, str]) -> Chain:
    """The chain of a job. given: subject, settings and effects, as plain values; files: its inputs."""
    chain = Chain(Subject.of(given["subject"]), given["settings"], frozenset(given["effects"]), STAGES)
    return chain.kept(grouped(files))


def _named(products: Mapping[str, Mapping[str, str]]) -> dict[str, str]:
    return {
        f"{name}{BETWEEN}{file}": path for name, files in products.items() for file, path in files.items()
    }


def _files(name: str) -> Files:
    files = STAGES[name].files
    if files is None:
        raise KeyError(f"{name} is not kept in files")
    return files
