"""One family of exceptions. Each message names the value, its limits and the next step."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np


class MammosimError(Exception):
    """An input that is rejected, or a solution that was not found; the message says what to do instead."""


class ConfigurationError(MammosimError):
    """A setting is misspelt, out of range, in another unit, or contradicts another one."""


class ImageError(MammosimError):
    """An image is incomplete, mixed, cut off, or not in the position it claims."""


class TableError(MammosimError):
    """A table or a file of values is cut short, damaged, or has no rows where some are needed."""


class FiducialError(MammosimError):
    """Markers are too few, collinear, or cannot be matched."""


class SegmentationError(MammosimError):
    """Training strokes or labels cannot describe the image."""


class MeshError(MammosimError):
    """A surface is open, or elements are inverted, flat or not attached."""


class MechanicsError(MammosimError):
    """A mechanical problem is ill posed: tissue without parameters, nothing fixed, nu >= 0.5."""


class EquilibriumError(MechanicsError):
    """No verified equilibrium was reached; `history` says how far the solver came.

    history: one row per Newton iteration, the columns of `mechanics.equilibrium.Iteration`.
    load_factor: the largest load factor with a stable equilibrium, in [0, 1].
    mode: (n_node, 3) how the tissue moves where stability is lost, the largest displacement 1; or None.
    """

    def __init__(
        self,
        message: str,
        *,
        history: tuple[Any, ...] = (),
        load_factor: float = 0.0,
        mode: np.ndarray | None = None,
    ) -> None:
        super().__init__(message)
        self.history = history
        self.load_factor = load_factor
        self.mode = mode


class OutOfBudget(EquilibriumError):
    """A solve spent its budget before it came to an equilibrium.

    best (n_node, 3): the last shape that it tried; the message tells the last equilibrium on the way. Other
    arguments are those of EquilibriumError.
    """

    def __init__(self, message: str, *, best: np.ndarray | None = None, **told: Any) -> None:
        super().__init__(message, **told)
        self.best = best


class UnloadingError(EquilibriumError):
    """No stress-free shape was found under the whole weight.

    load_factor: the largest part of the weight under which one was found.
    """


class IdentificationError(MammosimError):
    """Two measured positions do not belong together, or no modulus explains them."""


class XrayError(MammosimError):
    """Spectrum, geometry, materials or tallies are impossible."""


class DamagedFile(MammosimError):
    """A file of the study cannot be read any more: no outcome, but to be made or copied again."""


class DamagedTable(DamagedFile, TableError):
    """A table of the study, or its JSON, is cut short or damaged."""


class DamagedMesh(DamagedFile, MeshError):
    """A mesh of the study is cut short or damaged."""


class DamagedTransform(DamagedFile, ImageError):
    """A transform of the study is cut short or damaged."""


class MissingResult(MammosimError):
    """A result that an earlier stage could not give; the message is what that stage said."""


@contextmanager
def written() -> Iterator[None]:
    """Within it files are read that rules of the study wrote.

    Raises MissingResult as they say, and DamagedFile for one that cannot be read.
    """
    try:
        yield
    except (ConfigurationError, DamagedFile, MissingResult):
        raise
    except MammosimError as error:
        raise DamagedFile(str(error)) from error
