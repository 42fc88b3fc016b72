"""Random streams named by the job, so that results do not depend on the order or number of jobs."""

import hashlib

import numpy as np


def generator(*names: str | int) -> np.random.Generator:
    """The stream of a job, e.g. generator(seed, "small", "noise"); the same names give the same numbers."""
    digest = hashlib.sha256("\x1f".join(map(str, names)).encode()).digest()
    return np.random.Generator(np.random.PCG64(int.from_bytes(digest, "little")))


def seed_of(*names: str | int) -> int:
    """A 32-bit seed of the same stream, for libraries that take an integer."""
    return int(generator(*names).integers(2**32))
