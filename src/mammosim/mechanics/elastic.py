"""A displacement of some nodes carried smoothly to all others, by linear elasticity."""

import numpy as np

from mammosim.core.errors import MechanicsError
from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.core.tissues import Tissue
from mammosim.mechanics.analysis import system_of
from mammosim.mechanics.effects import NeoHookean
from mammosim.mechanics.potential import Potential

# ASSUME: in the fixed point, interior nodes follow the skin as in a homogeneous elastic body, nu = 0.3.
_CARRIER = Tissue(youngs_modulus_kpa=1.0, poisson_ratio=0.3, density_g_cm3=0.0)
_ACCURACY = 1e-10


def carried(mesh: TetMesh, displacement: np.ndarray, prescribed: np.ndarray) -> np.ndarray:
    """The displacement (n_node, 3) mm of least energy with the given one at `prescribed` (n_node,) nodes.

    Raises MechanicsError when nothing is prescribed.
    """
    if not prescribed.any():
        raise MechanicsError("no node has a prescribed displacement; give the skin's or the posterior nodes")
    bulk = NeoHookean.of(mesh, dict.fromkeys(Label, _CARRIER))
    held = np.repeat(prescribed[:, None], 3, axis=1)
    u = np.where(held, displacement, 0.0)
    with system_of(Potential((bulk,)), held) as system:
        K = system.potential.tangent(mesh.points, system.pattern)
        force = -(K.to_csr() @ u.ravel())[system.rows.free]
        least: np.ndarray = u + system.spread(system.solver.solve(K, force, _ACCURACY))
        return least
