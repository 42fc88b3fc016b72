"""Values rounded so that the last bits of a processor's arithmetic cannot choose another mesh.

Meshing takes discrete decisions, and each can change all that follow. Processors differ in the last bits of
sums, products of matrices and elementary functions. Rounding to a lattice far coarser than these bits, before
every decision, gives all of them the same bits: a value would have to lie within its last bits of a rounding
limit to be rounded differently. The steps are powers of two where coordinates are computed with further, so
that differences of lattice points, and the products of two of these, are exact.
"""

import numpy as np

from mammosim.io.compiled import njit

# Coordinates of surfaces, and edge lengths: 1/2000 of the smallest element, 1e10 times their last bits.
POINT_MM = 2.0**-10
# Nodes of the finished mesh, which decide the tissue and the boundaries.
NODE_MM = 2.0**-20
# Given lengths: voxel spacings and element sizes, most of which are decimal numbers with few digits.
LENGTH_MM = 1e-5
# Where between two lattice values the rounding changes. Means of two, three, four and eight lattice values
# stay clear of it, whereas halfway the last bit would decide about every mean of two.
LIMIT = (3 - np.sqrt(5)) / 2


def on_lattice(values: np.ndarray | float, step: float) -> np.ndarray:
    """Values of any shape as multiples of a step in the same unit, at most 0.62 of it away."""
    return np.floor(np.asarray(values) / step + (1 - LIMIT)) * step


@njit(cache=True)
def dot(u: np.ndarray, v: np.ndarray) -> float:
    """u . v of vectors (3,), summed in this order; np.dot calls BLAS, whose order is the processor's."""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]
