"""Quantities of the solution of a test problem that are compared with a reference."""

from collections.abc import Callable, Mapping
from typing import Literal

import numpy as np

from mammosim.core.errors import ConfigurationError
from mammosim.mechanics.reference import FACE_SHAPES, face_quadrature
from mammosim.study.hard_cases.problems import Solution, TestProblem


def apex_mm(solution: Solution) -> float:
    """Displacement of the outermost point along z, outward."""
    return float(_of_apex(solution)[2])


def drop_mm(solution: Solution) -> float:
    """Displacement of the outermost point along gravity."""
    return float(_of_apex(solution) @ _gravity(solution.problem))


def tip_ratio(solution: Solution) -> float:
    """Mean displacement along z of the face opposite z = 0, over the height."""
    X = solution.problem.mesh.points
    L = X[:, 2].max()
    return float(solution.displacements[np.isclose(X[:, 2], L), 2].mean() / L)


def slip_mm(solution: Solution) -> float:
    """Mean displacement of `posterior` along the part of gravity in its plane z = 0."""
    mesh = solution.problem.mesh
    faces = mesh.boundaries["posterior"]
    areas = face_quadrature(mesh.points, faces).areas
    u = np.einsum("qa,fai->fqi", FACE_SHAPES, solution.displacements[faces])
    along = _gravity(solution.problem) * [1.0, 1.0, 0.0]
    return float(np.einsum("fq,fqi,i->", areas, u, along / np.linalg.norm(along)) / areas.sum())


def height_mm(solution: Solution) -> float:
    """How much further along z the body reaches than at rest."""
    return _further(solution, 2)


def width_mm(solution: Solution) -> float:
    """How much further along x the body reaches than at rest."""
    return _further(solution, 0)


def force_n(solution: Solution) -> float:
    """Of the skin on the paddle, across it."""
    return _at_the_end(solution, "force_n")


def contact_area_mm2(solution: Solution) -> float:
    """Of the skin in contact with the paddle."""
    return _at_the_end(solution, "contact_area_mm2")


def pressure_kpa(solution: Solution) -> float:
    """Force over contact area."""
    return _at_the_end(solution, "mean_pressure_kpa")


def _of_apex(solution: Solution) -> np.ndarray:
    apex: np.ndarray = solution.displacements[np.argmax(solution.problem.mesh.points[:, 2])]
    return apex


def _further(solution: Solution, axis: int) -> float:
    return float(solution.x[:, axis].max() - solution.problem.mesh.points[:, axis].max())


def _at_the_end(solution: Solution, name: str) -> float:
    if solution.pressed is None:
        raise ConfigurationError("the quantity compared needs plates; add press to the problem")
    return float(solution.pressed.path[name].iloc[-1])


def _gravity(problem: TestProblem) -> np.ndarray:
    if problem.gravity is None:
        raise ConfigurationError("the quantity compared needs a gravity; add one to the problem")
    return problem.gravity


QuantityNames = Literal[
    "apex_mm",
    "drop_mm",
    "tip_ratio",
    "slip_mm",
    "height_mm",
    "width_mm",
    "force_n",
    "contact_area_mm2",
    "pressure_kpa",
]
QUANTITIES: Mapping[str, Callable[[Solution], float]] = {
    "apex_mm": apex_mm,
    "drop_mm": drop_mm,
    "tip_ratio": tip_ratio,
    "slip_mm": slip_mm,
    "height_mm": height_mm,
    "width_mm": width_mm,
    "force_n": force_n,
    "contact_area_mm2": contact_area_mm2,
    "pressure_kpa": pressure_kpa,
}
