"""Rigid transforms as ITK `.tfm` files.

In memory y = R x + t moves points of the moving position into the reference frame, LPS, mm. The file holds
the inverse, x = R^T (y - t), from fixed to moving, as ITK, 3D Slicer and ANTs read one: whoever resamples the
moving image with it sees the two images together.
"""

from pathlib import Path

import numpy as np
import SimpleITK as sitk

from mammosim.core.errors import ImageError
from mammosim.core.rigid import RigidTransform
from mammosim.io.atomic import replacing
from mammosim.io.missing import require_there


def read_transform(path: str | Path) -> RigidTransform:
    """y = R x + t, from moving to fixed, of any ITK file that holds one rigid or affine transform.

    Raises ImageError when the file is absent, unreadable, not linear, or its matrix no rotation.
    """
    if not Path(path).is_file():
        raise ImageError(f"no transform {path}; run the registration, or correct the path")
    require_there(path)
    try:
        return rigid_of(sitk.ReadTransform(str(path))).inverse()
    except (RuntimeError, ValueError) as error:
        raise ImageError(f"{path} holds no rigid transform; give one rotation and shift ({error})") from error


def write_transform(transform: RigidTransform, path: str | Path) -> None:
    """Write the inverse of y = R x + t as `.tfm`, complete or not at all."""
    with replacing(path) as temporary:
        sitk.WriteTransform(itk_transform(transform.inverse()), str(temporary))


def itk_transform(transform: RigidTransform) -> sitk.AffineTransform:
    """The SimpleITK transform with the same R (3, 3) and t (3,) mm, centre at the origin."""
    return sitk.AffineTransform(transform.R.ravel().tolist(), transform.t.tolist())


def rigid_of(transform: sitk.Transform) -> RigidTransform:
    """y = R x + t of a linear ITK transform T: t = T(0), R = (T(e1) - t, T(e2) - t, T(e3) - t).

    Raises ValueError when T is not linear or R no rotation.
    """
    if not transform.IsLinear():
        raise ValueError(f"{transform.GetName()} is not linear")
    t, *columns = (
        np.array(transform.TransformPoint(point)) for point in [(0.0, 0.0, 0.0), *np.eye(3).tolist()]
    )
    return RigidTransform(np.column_stack(columns) - t[:, None], t)
