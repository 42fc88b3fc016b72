"""Frictionless contact of the skin with a plate, by an augmented Lagrangian of mean distances.

    g_i = integral of H_i d / integral of H_i,  p_i = <lambda_i k / eps - k g_i>_+,  p = sum of p_i H_i
    E = 1/2 sum of A_i (p_i^2 / k - lambda_i^2 / eps),  A_i = integral of H_i

H_i are the six hats of a face (FaceRule.hats), A_i over its reference area, d the signed distance from the
plate. lambda is what the pressures p were before: with lambda = p the mean distances vanish where p > 0,
however small the penalty eps is (Alart & Curnier 1991). Six means in place of 24 distances leave the pressure
determined: otherwise it jumps from point to point (Laursen 2002; decisions/mechanics_contact.md).

A cushion on the plate, of thickness h and modulus M, yields by c p:

    1 / k = 1 / eps + c,  c = h / M,  M = E (1 - nu) / ((1 + nu) (1 - 2 nu))
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np

from mammosim.core.errors import MechanicsError
from mammosim.mechanics.effects.contact import ContactState, RigidContact
from mammosim.mechanics.effects.plate import PlateFace
from mammosim.mechanics.effects.pointwise import gathered_forces, gathered_stiffness
from mammosim.mechanics.pattern import Tangent, add_to_nodes


# ASSUME: a cushion is an elastic foundation: each place of it yields under the pressure there alone, and is
# confined by its neighbours (Winkler; Johnson 1985, section 4.3, of a layer thin beside the contact).
# ASSUME: it is linear up to its whole thickness, and has no weight.
@dataclass(frozen=True)
class Cushion:
    """A soft layer on a plate, whose surface is the plate's face while nothing presses on it.

    Raises MechanicsError for values out of range.
    """

    thickness_mm: float
    youngs_modulus_kpa: float
    poisson_ratio: float = 0.3

    def __post_init__(self) -> None:
        good = self.thickness_mm > 0 and self.youngs_modulus_kpa > 0 and 0 <= self.poisson_ratio < 0.5
        if not good:
            raise MechanicsError(
                f"a cushion of {self.thickness_mm:g} mm, {self.youngs_modulus_kpa:g} kPa, nu "
                f"{self.poisson_ratio:g}: the first two above 0, nu in [0, 0.5)"
            )

    @property
    def mm_per_kpa(self) -> float:
        """c = h / M."""
        E, nu = self.youngs_modulus_kpa, self.poisson_ratio
        return self.thickness_mm * (1 + nu) * (1 - 2 * nu) / (E * (1 - nu))


class _Means(NamedTuple):
    """A (n_face, 6) mm2, and the weights w (n_face, n_q, 6) of the distances in each mean, of sum 1."""

    A: np.ndarray
    w: np.ndarray


@dataclass(frozen=True)
class RigidPlate(RigidContact):
    """Contact of the skin's faces with a plate, such as a RoundedBox; see the module, and RigidContact.

    cushion: what lies on the plate; multiplier: lambda (n_face, 6) kPa, or 0 everywhere.
    """

    obstacle: PlateFace
    cushion: Cushion | None = None
    multiplier: np.ndarray | float = 0.0

    @property
    def yielding(self) -> float:
        """c of the cushion, mm/kPa."""
        return 0.0 if self.cushion is None else self.cushion.mm_per_kpa

    @property
    def stiffness(self) -> float:
        """k, kPa/mm."""
        return 1 / (1 / self.penalty + self.yielding)

    @cached_property
    def _means(self) -> _Means:
        A = self.areas @ self.rule.hats
        return _Means(A, self.areas[:, :, None] * self.rule.hats / A[:, None, :])

    def mean_pressures(self, x: np.ndarray) -> np.ndarray:
        """p_i (n_face, 6) kPa per reference area."""
        return self._pressed(self.at_points(x)[1])

    def _pressed(self, d: np.ndarray) -> np.ndarray:
        """p_i (n_face, 6) for distances d (n_face, n_q)."""
        k, g = self.stiffness, np.einsum("eqi,eq->ei", self._means.w, d)
        p: np.ndarray = np.maximum(self.multiplier * (k / self.penalty) - k * g, 0.0)
        return p

    def pressures(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """y (n_face, n_q, 3) mm of the quadrature points, and p (n_face, n_q) kPa per reference area."""
        y, d = self.at_points(x)
        return y, self._pressed(d) @ self.rule.hats.T

    def augmented(self, x: np.ndarray) -> Self:
        """The same contact with the pressures in a shape x (n_node, 3) as its multipliers."""
        return replace(self, multiplier=self.mean_pressures(x))

    def gap_error(self, x: np.ndarray) -> float:
        """How far skin that is pressed is from the plate at most, on either side and in the mean, mm."""
        return float(np.abs(self.mean_pressures(x) - self.multiplier).max(initial=0.0)) / self.penalty

    def energy(self, x: np.ndarray) -> float:
        """E of the module."""
        p, lambda_ = self.mean_pressures(x), self.multiplier
        return float(np.sum(self._means.A * (p**2 / self.stiffness - lambda_**2 / self.penalty))) / 2

    def add_gradient(self, x: np.ndarray, g: np.ndarray) -> None:
        """g_a += - integral of p n N_a."""
        y, p = self.pressures(x)
        pressed = p > 0
        t = np.zeros_like(y)
        t[pressed] = -(self.areas * p)[pressed][:, None] * self.obstacle.normal(y[pressed])
        add_to_nodes(self.faces, gathered_forces(t, self.rule.shapes), g)

    def add_tangent(self, x: np.ndarray, K: Tangent, *, projected: bool = False) -> None:
        """K_ab += sum of k A_i v_ia (x) v_ib over p_i > 0 - integral of p H N_a N_b, v_ia = dg_i/dx_a.

        The last term not when projected.
        """
        y, d = self.at_points(x)
        p_i = self._pressed(d)
        touched = np.flatnonzero((p_i > 0).any(axis=1))
        if len(touched) == 0:
            return
        y, p_i = y[touched], p_i[touched]
        n = self.obstacle.normal(y.reshape(-1, 3)).reshape(y.shape)
        v = np.einsum("eqi,qa,eqk->eiak", self._means.w[touched], self.rule.shapes, n, optimize=True)
        v *= np.sqrt(self.stiffness * self._means.A[touched] * (p_i > 0))[..., None, None]
        blocks = np.zeros((len(self.faces), 6, 6, 3, 3))
        blocks[touched] = np.einsum("eiak,eibl->eabkl", v, v)
        if not projected:
            H = self.obstacle.hessian(y.reshape(-1, 3)).reshape(*y.shape, 3)
            load = self.areas[touched] * (p_i @ self.rule.hats.T)
            blocks[touched] -= gathered_stiffness(load[..., None, None] * H, self.rule.shapes)
        K.add(self.faces, blocks)

    def state(self, x: np.ndarray) -> ContactState:
        """As of any contact; the pressure is that along the normal, the penetration that of the skin."""
        y, d = self.at_points(x)
        p = self._pressed(d) @ self.rule.hats.T
        n = self.obstacle.normal(y.reshape(-1, 3)).reshape(y.shape)
        steepness = self.obstacle.steepness(y.reshape(-1, 3)).reshape(d.shape)
        deformed = self.rule.areas(x, self.faces)
        return ContactState(
            force=-np.einsum("eq,eqi->i", p * self.areas, n),
            areas=np.where(p > 0, deformed, 0.0),
            pressure=p * self.areas / deformed * steepness,
            penetration=float(np.max(-d - self.yielding * p, initial=0.0)),
        )

    def indentation(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Places (n, 3) of the skin in contact, in the loaded shape x, and how far the cushion yields, mm."""
        y, p = self.pressures(x)
        return y[p > 0], self.yielding * p[p > 0]

    def require_cushion(self, x: np.ndarray) -> None:
        """Raise MechanicsError where the cushion would yield by more than its thickness."""
        if self.cushion is None:
            return
        deepest = float(self.indentation(x)[1].max(initial=0.0))
        if deepest >= self.cushion.thickness_mm:
            raise MechanicsError(
                f"a cushion of {self.cushion.thickness_mm:g} mm is pressed by {deepest:.1f} mm, through to "
                "its plate: press less, or describe a thicker or a stiffer one"
            )
