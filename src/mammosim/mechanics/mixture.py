"""What cells are made of that hold several tissues t, each with a share f_t of the volume.

E_V = sum f_t E_t,  1 / E_R = sum f_t / E_t,  E_b = sqrt(E_V E_R)   of all but muscle, sum f_t = 1
1 / E = (1 - m) / E_b + m / E_m                                      with a share m of muscle
nu = sum f_t nu_t,  rho = sum f_t rho_t                              of all
"""

import numpy as np

from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.core.tissues import CellTissues, Tissues, tissue_of

# ASSUME: fat, gland and lesion share a cell without order: E is the geometric mean of Voigt and Reuss (Hill).
# ASSUME: muscle shares a cell as a layer under the rest, which gravity shears in series.
# ASSUME: nu of a mixed cell is the mean by volume; in this study all its tissues have the same.


def cell_tissues(mesh: TetMesh, tissues: Tissues) -> CellTissues:
    """E, nu and density of every cell of a mesh. Raises MechanicsError for a tissue without parameters."""
    if isinstance(tissues, CellTissues):
        return tissues
    shares = mesh.composition
    present = np.flatnonzero(shares.any(axis=0))
    each = [tissue_of(int(label), tissues) for label in present]
    f, E = shares[:, present], np.array([tissue.youngs_modulus_kpa for tissue in each])
    nu, rho = (f @ [getattr(tissue, name) for tissue in each] for name in ("poisson_ratio", "density_g_cm3"))
    return CellTissues(mixed_modulus(f, E, present == Label.MUSCLE), nu, rho)


def mixed_modulus(f: np.ndarray, E: np.ndarray, muscle: np.ndarray) -> np.ndarray:
    """E (n_cell,) kPa of cells with shares f (n_cell, n) of tissues with E (n,) kPa; muscle (n,) bool."""
    soft = f[:, ~muscle]
    b = soft.sum(axis=1)
    E_V, C_R = soft @ E[~muscle], soft @ (1 / E[~muscle])
    # In shares of the cell E_V and 1 / E_R carry one factor b each, so that b / E_b = b sqrt(C_R / E_V).
    compliance = b * np.sqrt(np.divide(C_R, E_V, out=np.zeros_like(b), where=b > 0))
    mixed: np.ndarray = 1 / (compliance + f[:, muscle] @ (1 / E[muscle]))
    return mixed
