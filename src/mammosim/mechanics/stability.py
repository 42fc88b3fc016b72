"""How a body loses its stability: the lowest mode of its tangent, and what would help."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse.linalg import LinearOperator, aslinearoperator

from mammosim.core.rng import generator
from mammosim.mechanics.effects import RigidContact, SkinMembrane
from mammosim.mechanics.newton import System
from mammosim.mechanics.potential import Potential

_MAX_STEPS = 60
_ACCURACY = 1e-3
# A mode in which fewer than this part of the nodes takes part is a local fold.
LOCAL = 0.15


@dataclass(frozen=True)
class Mode:
    """The lowest mode of a tangent: eigenvalue w [mN/mm] and v (n_node, 3) of K v = w v, largest |v_a| 1."""

    eigenvalue: float
    shape: np.ndarray

    @property
    def participation(self) -> float:
        """The part of the nodes that moves: (sum |v|^2)^2 / sum |v|^4 / n_node."""
        square = np.sum(self.shape**2, axis=1)
        return float(square.sum() ** 2 / np.sum(square**2) / len(square))

    def words(self, points: np.ndarray) -> str:
        """Where the tissue moves most, by its reference points (n_node, 3), and in which direction."""
        most = int(np.argmax(np.linalg.norm(self.shape, axis=1)))
        doing = "folds locally" if self.participation < LOCAL else "gives way as a whole"
        where, along = _listed(points[most], 0), _listed(self.shape[most], 2)
        return f"the tissue {doing}, most at {where} mm of the reference, along {along}"


def lowest_mode(system: System, x: np.ndarray, stable: np.ndarray) -> Mode:
    """The lowest mode at a shape x (n_node, 3), found from the tangent at a stable one.

    Locally optimal conjugate gradients (Knyazev 2001): the Rayleigh quotient is minimised over the last
    vector, its preconditioned residual and the last change.
    """
    free, solver = system.rows.free, system.solver
    A = _free_operator(system, x)
    solver.is_definite(system.potential.tangent(stable, system.pattern))
    v = solver.preconditioned(generator("lowest mode").standard_normal(len(free)))
    directions, last = [v], np.inf
    for _ in range(_MAX_STEPS):
        Q, _ = np.linalg.qr(np.column_stack(directions))
        values, vectors = np.linalg.eigh(Q.T @ (A @ Q))
        following, w = Q @ vectors[:, 0], float(values[0])
        if abs(w - last) <= _ACCURACY * abs(w):
            break
        change = following - v * (v @ following) / (v @ v)
        v, last = following, w
        directions = [v, solver.preconditioned(A @ v - w * v), change]
    shape = system.spread(following)
    most = shape[np.argmax(np.linalg.norm(shape, axis=1))]
    return Mode(w, shape / np.linalg.norm(most))


def _free_operator(system: System, x: np.ndarray) -> LinearOperator:
    """K + B^T M^-1 B on the free degrees of freedom, its parts kept apart."""
    free, tangent = system.rows.free, system.potential.tangent(x, system.pattern)
    K = replace(tangent, constraint=None).to_csr()[free][:, free]
    if tangent.constraint is None:
        return aslinearoperator(K)
    B, factors = tangent.constraint.B.tocsc()[:, free].tocsr(), tangent.constraint.factors
    return LinearOperator(K.shape, matvec=lambda v: K @ v + B.T @ factors.solve(B @ v), dtype=float)


def advice(system: System, points: np.ndarray, load_factor: float) -> str:
    """What would keep the body, with reference points (n_node, 3), stable beyond this part of its loads."""
    effects, helps = system.potential.effects, []
    if any(isinstance(effect, SkinMembrane) for effect in effects):
        helps.append("make the skin stiffer or thicker")
    else:
        helps.append("add skin, which holds soft tissue")
    in_contact = any(isinstance(effect, RigidContact) for effect in effects)
    if not in_contact and not _hangs(system, points):
        helps.append("let the chest wall carry what is pressed towards it (chest_wall_contact)")
    if load_factor > 0:
        helps.append(f"make all stiffnesses {1.05 / load_factor:.2g} times larger, which is certain to help")
    return "; or ".join(helps)


def _hangs(system: System, points: np.ndarray) -> bool:
    """Whether the loads pull away from the held nodes, within 45 degrees."""
    held = system.held.any(axis=1)
    away = points[~held].mean(axis=0) - points[held].mean(axis=0)
    pull = -Potential(system.potential.loads).gradient(points).sum(axis=0)
    return bool(pull @ away > np.sqrt(0.5) * np.linalg.norm(pull) * np.linalg.norm(away))


def _listed(vector: np.ndarray, digits: int) -> str:
    return "(" + ", ".join(f"{value + 0.0:.{digits}f}" for value in vector) + ")"
