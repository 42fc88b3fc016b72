"""Shapes in the planes of the left nipple: upright, morphed, free of stress."""

from contextlib import suppress

from matplotlib.figure import Figure

from mammosim.core.errors import MissingResult
from mammosim.core.mesh import TetMesh
from mammosim.figures import deformation
from mammosim.io.meshes import read_mesh, read_point_data
from mammosim.io.tables import read_table
from mammosim.io.transforms import read_transform
from mammosim.io.written import read_fiducials


def upright(files: dict, told: dict, job: dict) -> Figure:
    """told: skin_kpa, the moduli of the skin in the order of the shapes."""
    shapes = {"measured, prone": (measured := read_mesh(files["measured"]))}
    for E, path in sorted(zip(told["skin_kpa"], files["shapes"])):
        name = "without skin" if E == 0 else f"skin {E:g} kPa"
        shapes[name] = measured.moved_to(read_point_data(path, "predicted"))
    table = read_table(files["table"])
    x = read_fiducials(files["fiducials"]).point("nipple_left")[0]
    return deformation.upright(shapes, table[table.volunteer == job["v"]], x_mm=x)


def morph(files: dict, told: dict, job: dict) -> Figure:
    """Prone, supine, prone morphed onto supine, and the mean that unloading starts from."""
    shapes = {name: read_mesh(files[name]) for name in ("prone", "supine", "morphed", "mean")}
    x, _, z = read_fiducials(files["fiducials"]).point("nipple_left")
    distance = read_point_data(files["morphed"], "distance_mm")
    return deformation.morph(
        shapes, distance, read_table(files["history"], may_be_empty=True), x_mm=x, z_mm=z
    )


def stress_free(files: dict, told: dict, job: dict) -> Figure:
    """With the shape that is pressed, and the truth, where given; told: the methods of the shapes."""
    shapes = {"measured": read_mesh(files["measured"])}
    for method, path in zip(told["methods"], files["shapes"]):
        with suppress(MissingResult):  # the table of methods says why
            shapes[method.replace("_", " ")] = read_mesh(path)
    if "used" in files:
        shapes |= used_beside(files["used"], files["attempts"])
    if "truth" in files:
        shapes["truth"] = true_shape(files["truth"], files["motion"])
    x, _, z = read_fiducials(files["fiducials"]).point("nipple_left")
    return deformation.stress_free(shapes, x_mm=x, z_mm=z)


def used_beside(shape: str, attempts: str) -> dict[str, TetMesh]:
    """The shape that is pressed, named by what it took, where it is not the default method's."""
    *before, used = read_table(attempts).itertuples()
    return {f"{used.method}, all moduli times {used.moduli_factor:g}": read_mesh(shape)} if before else {}


def true_shape(mesh: str, motion: str) -> TetMesh:
    """The true stress-free shape in the reference frame."""
    truth = read_mesh(mesh)
    return truth.moved_to(read_transform(motion)(truth.points))
