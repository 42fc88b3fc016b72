"""Volunteers: their images in every position, their registration, their tissues, their meshes."""

import numpy as np
from matplotlib.figure import Figure

from mammosim.core.positions import gravity_vector
from mammosim.core.rigid import IDENTITY
from mammosim.figures import volunteers
from mammosim.figures.surfaces import left_breast, mesh_with_tissues
from mammosim.imaging.registration import resample
from mammosim.io.meshes import read_mesh
from mammosim.io.tables import read_table
from mammosim.io.written import read_fiducials, read_image, read_labels


def positions(files: dict, told: dict, job: dict) -> Figure:
    """told: gravity by position, in the order of the images."""
    return volunteers.positions(
        dict(zip(told["gravity"], map(read_image, files["images"]))),
        dict(zip(told["gravity"], map(read_fiducials, files["fiducials"]))),
        {position: gravity_vector(text) for position, text in told["gravity"].items()},
    )


def registration(files: dict, told: dict, job: dict) -> Figure:
    """The moving image is resampled as it was scanned, beside how it was registered."""
    fixed, after = read_image(files["fixed"]), read_image(files["after"])
    before = resample(read_image(files["moving"]), IDENTITY, fixed.grid)
    z = volunteers.left_nipple(read_fiducials(files["fiducials"]), fixed)[2]
    return volunteers.registration(fixed, before, after, read_table(files["steps"]), at_mm=z)


def segmentation(files: dict, told: dict, job: dict) -> Figure:
    """With the overlap with the truth where that is known; told: behind_mm, the slices behind the nipple."""
    image, points = read_image(files["image"]), read_fiducials(files["fiducials"])
    point = volunteers.left_nipple(points, image) + np.array([0.0, told["behind_mm"], 0.0])
    overlap = read_table(files["dice"][0]) if files["dice"] else None
    return volunteers.segmentation(image, read_labels(files["labels"]), overlap, point=point)


def mesh(files: dict, told: dict, job: dict) -> Figure:
    """Cut through the left nipple."""
    mesh, points = read_mesh(files["mesh"]), read_fiducials(files["fiducials"])
    x = left_breast(points, mesh)[0]
    marked = [points.point(name) for name in ("nipple_left", "nipple_right") if name in points.names]
    return mesh_with_tissues(mesh, cut_x_mm=x, nipples=np.array(marked).reshape(-1, 3))
