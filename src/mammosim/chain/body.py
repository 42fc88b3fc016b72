"""A labelled breast as a mesh, and what its tissues, skin and fibres resist with.

Effects: gland and muscle (stiffer than fat), skin, fascia, ligaments.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from mammosim.chain.breast import Breast, scanned_mesh
from mammosim.chain.graph import Inputs
from mammosim.core.errors import ConfigurationError
from mammosim.core.mesh import TetMesh
from mammosim.core.tissues import tissues_by_label
from mammosim.io import meshes
from mammosim.io.tables import write_table
from mammosim.mechanics.body import Body, Fascia, Ligaments, Part, Skin
from mammosim.meshing.quality import quality


def mesh(inputs: Inputs) -> TetMesh:
    """The body, common frame."""
    breast: Breast = inputs["breast"]
    scanned = scanned_mesh(breast.labels, breast.fiducials.of_kind("chest"), inputs.setting("mesh"))
    return scanned.moved_to(np.ascontiguousarray(breast.to_reference(scanned.points)))


def save_mesh(mesh: TetMesh, files: Mapping[str, str], job: Mapping[str, str]) -> None:
    """The mesh, and the quality of its cells."""
    table = quality(mesh)
    write_table(table.assign(**job)[[*job, *table.columns]], files["quality"])
    meshes.write_mesh(mesh, files["mesh"])


def load_mesh(files: Mapping[str, str]) -> TetMesh:
    """What save_mesh wrote."""
    return meshes.read_mesh(files["mesh"])


def reference_mesh(inputs: Inputs) -> TetMesh:
    """Raises ConfigurationError: it is the mesh of another position, and made by the chain of that one."""
    raise ConfigurationError("the mesh of the reference position was not given to the chain")


load_reference_mesh = load_mesh


def body(inputs: Inputs) -> Body:
    """What it is made of."""
    return _body(inputs, inputs.setting("tissues"))


def pressed_body(inputs: Inputs) -> Body:
    """What it is made of between the plates."""
    # ASSUME: the stress-free shape is that of the study's own moduli, whatever a breast is pressed with.
    return _body(inputs, inputs.setting("load.tissues"))


def _body(inputs: Inputs, given: Mapping[str, Any]) -> Body:
    """Of a file of config/tissues. A stiffer tissue whose effect is absent is as stiff as fat."""
    tissues = {name: {**values} for name, values in given["tissues"].items()}
    for effect, tissue in (("gland", "glandular"), ("muscle", "muscle")):
        if not inputs.has(effect):
            tissues[tissue]["youngs_modulus_kpa"] = tissues["adipose"]["youngs_modulus_kpa"]
    parts: Mapping[str, Callable[[], Part]] = {
        "skin": lambda: Skin(**given["skin"]),
        # ASSUME: superficial fascia lies right under the skin.
        "fascia": lambda: Fascia(**inputs.setting("effects.fascia"), boundary="skin"),
        "ligaments": lambda: Ligaments(**inputs.setting("effects.ligaments")),
    }
    return Body(tissues_by_label(tissues), tuple(part() for name, part in parts.items() if inputs.has(name)))
