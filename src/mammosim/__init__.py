"""mammosim: from raw breast MR images to compression, X-ray images and dose.

    import mammosim as ms

The names below are the public interface; each is imported when it is first used. Units: mm, kPa,
mN, keV, mGy; frame: the patient's, LPS.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

# Public name -> the module that it lives in.
_HOMES = {
    "MammosimError": "core.errors",
    "Fiducials": "core.fiducials",
    "Label": "core.labels",
    "TetMesh": "core.mesh",
    "RigidTransform": "core.rigid",
    "Tissue": "core.tissues",
    "Grid": "core.volume",
    "Image": "core.volume",
    "LabelMap": "core.volume",
    "read_image": "io.images",
    "read_labels": "io.images",
    "read_mesh": "io.meshes",
    "write_mesh": "io.meshes",
    "register": "imaging.registration",
    "segment": "imaging.segmentation",
    "ElementSize": "meshing.body",
    "mesh_body": "meshing.body",
    "Body": "mechanics.body",
    "Skin": "mechanics.body",
    "compress": "mechanics.compression",
    "Force": "mechanics.stage",
    "Thickness": "mechanics.stage",
    "inverse": "mechanics.inverse",
    "Plates": "mechanics.paddles",
    "Subject": "chain.subject",
    "Chain": "chain.graph",
    "STAGES": "chain.stages",
    "QUANTITIES": "chain.quantities",
    "dose_in": "chain.mammogram",
    "mammography_geometry": "xray.views",
    "monoenergetic": "xray.spectrum",
    "tube_spectrum": "xray.tube",
}
__all__ = ["__version__", *_HOMES]

if TYPE_CHECKING:
    from mammosim.chain.graph import Chain
    from mammosim.chain.mammogram import dose_in
    from mammosim.chain.quantities import QUANTITIES
    from mammosim.chain.stages import STAGES
    from mammosim.chain.subject import Subject
    from mammosim.core.errors import MammosimError
    from mammosim.core.fiducials import Fiducials
    from mammosim.core.labels import Label
    from mammosim.core.mesh import TetMesh
    from mammosim.core.rigid import RigidTransform
    from mammosim.core.tissues import Tissue
    from mammosim.core.volume import Grid, Image, LabelMap
    from mammosim.imaging.registration import register
    from mammosim.imaging.segmentation import segment
    from mammosim.io.images import read_image, read_labels
    from mammosim.io.meshes import read_mesh, write_mesh
    from mammosim.mechanics.body import Body, Skin
    from mammosim.mechanics.compression import compress
    from mammosim.mechanics.inverse import inverse
    from mammosim.mechanics.paddles import Plates
    from mammosim.mechanics.stage import Force, Thickness
    from mammosim.meshing.body import ElementSize, mesh_body
    from mammosim.xray.spectrum import monoenergetic
    from mammosim.xray.tube import tube_spectrum
    from mammosim.xray.views import mammography_geometry


def __getattr__(name: str) -> Any:
    """A public name, imported when it is first used."""
    if name not in _HOMES:
        raise AttributeError(f"module 'mammosim' has no attribute {name!r}; it has: {', '.join(__all__)}")
    return getattr(import_module(f"mammosim.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
