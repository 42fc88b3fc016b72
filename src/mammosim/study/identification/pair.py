"""One body measured in two positions: what a fit explains, and how far a prediction is from it.

The prone mesh is the body; unloaded and loaded supine, its skin should lie on the supine skin and its markers
on the supine markers. Rows of the residual, each divided by its standard error:

    d_a = n . (x_a - q_a),   q_a: the nearest point of the supine skin to node x_a, n its normal
    m_k = y_k - z_k (3),     y_k: marker k carried along, z_k: where it was measured
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from mammosim.chain.points import MaterialPoints
from mammosim.core.errors import FiducialError, MeshError
from mammosim.core.fiducials import Fiducials
from mammosim.core.mesh import TetMesh
from mammosim.core.positions import gravity_vector
from mammosim.imaging.certainty import deviation
from mammosim.io.meshes import read_mesh
from mammosim.io.tables import read_table
from mammosim.io.transforms import read_transform
from mammosim.io.written import read_fiducials
from mammosim.meshing.distance import NearestOnTriangles, distance_to_rim, flat_pieces, rim
from mammosim.study.identification.settings import Errors

# Skin this near to where a body was cut out is held there, or follows what is: it says nothing about moduli.
CUT_MM = 20.0
# Skin with less tissue than this between it and what is held hardly moves either; after a fit it leaves two
# to three times what the breasts leave, whose elements are smaller (decisions/identification.md).
DEPTH_MM = 30.0
# ASSUME: errors of a measured skin are alike within this distance, so that nearer nodes are no news.
CORRELATED_MM = 15.0


@dataclass(frozen=True)
class Position:
    """A measured position: its mesh, its fiducials, gravity (3,); all in the common frame."""

    mesh: TetMesh
    fiducials: Fiducials
    gravity: np.ndarray


@dataclass(frozen=True)
class Pair:
    """start: the position whose mesh is the body (prone); goal: the one to be predicted (supine).

    Without breast markers in one of them the skin alone is explained. Raises FiducialError when both have
    breast markers and share none, MeshError when all skin is near a cut.
    """

    start: Position
    goal: Position

    def __post_init__(self) -> None:
        marked = [len(each.fiducials.of_kind("breast")) for each in (self.start, self.goal)]
        if all(marked) and not self.shared:
            raise FiducialError("the positions share no breast marker; give them the same names")
        if not self.counted.any():
            raise MeshError(
                f"no breast is seen: all skin lies within {DEPTH_MM:g} mm of what is held, or "
                f"{CUT_MM:g} mm of a cut; is it the right mesh?"
            )

    @cached_property
    def shared(self) -> tuple[str, ...]:
        """Names of the breast markers that both positions have."""
        kinds = dict(zip(self.start.fiducials.names, self.start.fiducials.kinds))
        names = self.goal.fiducials.names
        return tuple(name for name, kind in kinds.items() if kind == "breast" and name in names)

    @cached_property
    def skin(self) -> np.ndarray:
        """Numbers (n_skin,) of the skin's nodes."""
        return self.start.mesh.boundary_nodes("skin")

    @cached_property
    def counted(self) -> np.ndarray:
        """(n_skin,) bool: nodes of the breasts, away from the cuts and from what is held."""
        mesh = self.start.mesh
        held = cKDTree(mesh.points[mesh.boundary_nodes("posterior")])
        depth, _ = held.query(mesh.points[self.skin])
        return (distance_to_rim(mesh) >= CUT_MM) & (depth >= DEPTH_MM)

    @cached_property
    def news(self) -> np.ndarray:
        """(n_skin,) of how much of an independent distance each node tells: its area over that of errors."""
        faces = self.start.mesh.boundaries["skin"]
        a, b, c = (self.start.mesh.points[faces[:, i]] for i in range(3))
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
        share = np.bincount(faces.ravel(), np.repeat(area / 6, 6), minlength=len(self.start.mesh.points))
        return np.minimum(1.0, share[self.skin] / CORRELATED_MM**2)

    @cached_property
    def markers(self) -> MaterialPoints:
        """The shared markers on the start's skin."""
        return MaterialPoints.on(self.start.mesh, self._given)

    @cached_property
    def _given(self) -> np.ndarray:
        return np.array([self.start.fiducials.point(name) for name in self.shared]).reshape(-1, 3)

    @cached_property
    def goals(self) -> np.ndarray:
        """Where the shared markers were measured in the goal (n, 3)."""
        return np.array([self.goal.fiducials.point(name) for name in self.shared]).reshape(-1, 3)

    @cached_property
    def _goal_skin(self) -> tuple[NearestOnTriangles, np.ndarray, NearestOnTriangles]:
        """The goal's skin, the normals of its pieces, and its rim."""
        points, faces = self.goal.mesh.points, self.goal.mesh.boundaries["skin"]
        pieces = flat_pieces(points[faces])
        normal = np.cross(pieces[:, 1] - pieces[:, 0], pieces[:, 2] - pieces[:, 0])
        edges = points[rim(faces)][:, [0, 1, 2]]
        return NearestOnTriangles(pieces), _unit(normal), NearestOnTriangles(edges)

    def marker_places(self, x: np.ndarray) -> np.ndarray:
        """The shared markers (n, 3) mm when the nodes are at x (n_node, 3)."""
        if not self.shared:
            return self._given
        return self.markers.carry_above(self._given, self.start.mesh.points, x)

    def contacts(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Numbers (n,) of the nodes that count at x (n_node, 3), nearest points and normals (n, 3)."""
        surface, normals, edge = self._goal_skin
        nodes = self.skin[self.counted]
        q, piece = surface(x[nodes])
        on_rim, _ = edge(q)
        inside = np.linalg.norm(on_rim - q, axis=1) >= CUT_MM / 2
        return nodes[inside], q[inside], normals[piece[inside]]

    def weights(self, nodes: np.ndarray, errors: Errors) -> tuple[np.ndarray, float]:
        """1/mm: (n,) of the distances of skin nodes, and of a marker's coordinate."""
        news = self.news[np.searchsorted(self.skin, nodes)]
        return np.sqrt(news) / errors.skin_mm, 1 / errors.marker_mm


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), np.finfo(float).tiny)


def left_by_registration(steps: str | Path) -> dict[str, float]:
    """shift_mm and turn_deg, standard deviations of what a registration left, by the table of its steps.

    NaN where it states none, as markers do not. The limit at the worst place of the chest wall counts as a
    shift, which is at least what the breasts are off.
    """
    used = read_table(steps, may_be_empty=True)
    if "error_95_mm" not in used or not len(used := used[used.used]):
        return {"shift_mm": float("nan"), "turn_deg": float("nan")}
    last = used.iloc[-1]
    return {"shift_mm": deviation(last.error_95_mm), "turn_deg": deviation(last.error_95_deg)}


def read_pair(files: Mapping[str, str], gravity: Sequence[str]) -> Pair:
    """The pair in files start, start_fiducials, start_transform, goal, goal_fiducials; the goal is the frame.

    gravity: of both in their scanner frames, 'x y z'; the transform turns the start's into the common frame.
    """
    turn = read_transform(files["start_transform"]).R
    down = turn @ gravity_vector(gravity[0]), gravity_vector(gravity[1])
    start, goal = (
        Position(read_mesh(files[name]), read_fiducials(files[f"{name}_fiducials"]), g)
        for name, g in zip(("start", "goal"), down)
    )
    return Pair(start, goal)
