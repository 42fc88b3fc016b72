"""How a computation ended, in tables."""

from mammosim.core.errors import DamagedFile, EquilibriumError, MammosimError

CONVERGED = "converged"  # and the residual of the equilibrium was checked


def unsolved(error: MammosimError, doing: str = "") -> str:
    """The outcome of what an error ended: `unstable: why` where stability was lost, else `failed: why`.

    doing: at what, in front of the reason. Raises DamagedFile itself: what cannot be read is no outcome.
    """
    if isinstance(error, DamagedFile):
        raise error
    # An equilibrium error has the mode by which the body gives way, where it lost its stability.
    lost = isinstance(error, EquilibriumError) and error.mode is not None
    return f"{'unstable' if lost else 'failed'}: {f'{doing}: ' if doing else ''}{error}"
