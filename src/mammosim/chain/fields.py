"""What is drawn of a body in equilibrium: fields on the nodes and cells of its mesh, units in their names."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from mammosim.core.mesh import TetMesh
from mammosim.mechanics.effects import Effect
from mammosim.mechanics.reference import cell_strain
from mammosim.mechanics.stress import bulk_of, cauchy_stress, von_mises

# Components of a symmetric tensor in the order of VTK: xx, yy, zz, xy, yz, xz.
ROWS, COLUMNS = (0, 1, 2, 0, 1, 0), (0, 1, 2, 1, 2, 2)


@dataclass(frozen=True)
class Fields:
    """nodes: name -> (n_node, ..); cells: name -> (n_cell, ..); float32, which is enough to look at."""

    nodes: Mapping[str, np.ndarray] = field(default_factory=dict)
    cells: Mapping[str, np.ndarray] = field(default_factory=dict)


def fields_of(mesh: TetMesh, effects: Iterable[Effect], x: np.ndarray) -> Fields:
    """Of a body, whose mesh.points are stress-free, in the loaded shape x (n_node, 3).

    displacement_mm from the stress-free shape; J; green_lagrange_strain and cauchy_stress_kpa (n_cell, 6), of
    the bulk tissue alone, and its von_mises_kpa. Raises MechanicsError when the effects have no bulk tissue.
    """
    strain = cell_strain(mesh, x)
    sigma = cauchy_stress(bulk_of(effects), x, strain.J * strain.volume)
    cells = {
        "J": strain.J,
        "green_lagrange_strain": strain.green_lagrange[:, ROWS, COLUMNS],
        "cauchy_stress_kpa": sigma[:, ROWS, COLUMNS],
        "von_mises_kpa": von_mises(sigma),
    }
    nodes = {"displacement_mm": x - mesh.points}
    return Fields(*({name: v.astype(np.float32) for name, v in each.items()} for each in (nodes, cells)))
