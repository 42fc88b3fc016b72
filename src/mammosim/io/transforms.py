"""Rigid transforms as ITK `.tfm` files.

In memory y = R x + t moves points of the moving position into the reference frame, LPS, mm. The file holds
the inverse, x = R^T (y - t), from fixed to moving, as ITK, 3D Slicer and ANTs read one: whoever resamples the
moving image with it sees the two images together.
"""

import errno
from pathlib import Path

import numpy as np
import SimpleITK as sitk

from mammosim.core.errors import DamagedTransform, ImageError
from mammosim.core.rigid import RigidTransform
from mammosim.io.atomic import replacing
from mammosim.io.missing import require_there

TEXT = "#Insight Transform File"


def read_transform(path: str | Path) -> RigidTransform:
    """y = R x + t, from moving to fixed, of any ITK file that holds one rigid or affine transform.

    Raises ImageError when the file is absent, DamagedTransform when it is unreadable, cut short, not linear,
    or its matrix no rotation.
    """
    if not Path(path).is_file():
        raise ImageError(f"no transform {path}; run the registration, or correct the path")
    require_there(path)
    try:
        return rigid_of(_whole(sitk.ReadTransform(str(path)), Path(path))).inverse()
    except (RuntimeError, ValueError) as error:
        why = " ".join(str(error).split())
        raise DamagedTransform(
            f"{path} holds no rigid transform; give one rotation and shift ({why})"
        ) from error


def write_transform(transform: RigidTransform, path: str | Path) -> None:
    """Write the inverse of y = R x + t as `.tfm`, complete or not at all."""
    with replacing(path) as temporary:
        try:
            sitk.WriteTransform(itk_transform(transform.inverse()), str(temporary))
        except RuntimeError as error:
            raise OSError(
                errno.EIO, f"cannot be written ({' '.join(str(error).split())})", str(path)
            ) from None
        try:
            _whole(sitk.ReadTransform(str(temporary)), temporary)  # ITK says nothing where it finds no room
        except (RuntimeError, ValueError):
            raise OSError(errno.ENOSPC, "no room: it was cut short; free some", str(path)) from None


def itk_transform(transform: RigidTransform) -> sitk.AffineTransform:
    """The SimpleITK transform with the same R (3, 3) and t (3,) mm, centre at the origin."""
    return sitk.AffineTransform(transform.R.ravel().tolist(), transform.t.tolist())


def _whole(transform: sitk.Transform, path: Path) -> sitk.Transform:
    """The same. Raises ValueError where ITK has filled in numbers that its text file lacks."""
    lines = path.read_bytes().decode("utf-8", "replace").splitlines(keepends=True)
    if not (lines and lines[0].startswith(TEXT)):
        return transform  # a binary file, which ITK does not fill in
    words = [line.split() for line in lines if line.startswith(("Parameters:", "FixedParameters:"))]
    stated = [float(word) for line in words for word in line[1:]]
    read = [*transform.GetParameters(), *transform.GetFixedParameters()]
    one = transform.GetTransformEnum() != sitk.sitkComposite
    if not lines[-1].endswith("\n") or (one and (len(stated) != len(read) or not np.allclose(stated, read))):
        raise ValueError("it is cut short; copy it again, or delete it and run the stage that makes it")
    return transform


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
