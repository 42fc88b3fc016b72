"""A rigid motion reads back as the same motion, also when another program wrote it about a centre."""

from pathlib import Path

import numpy as np
import pytest
import SimpleITK as sitk

from mammosim.core.errors import ImageError
from mammosim.core.rigid import RigidTransform, rotation
from mammosim.io.transforms import read_transform, write_transform

MOTION = RigidTransform(rotation(np.array([3.0, -2.0, 5.0])), np.array([4.0, -5.0, 6.0]))
POINTS = np.random.default_rng(1).normal(scale=100, size=(20, 3))


def test_a_transform_reads_back(tmp_path: Path) -> None:
    write_transform(MOTION, tmp_path / "supine.tfm")
    # Decimal text of 64-bit numbers: rounding only.
    np.testing.assert_allclose(read_transform(tmp_path / "supine.tfm")(POINTS), MOTION(POINTS), atol=1e-9)


def test_a_rotation_about_a_centre_is_the_same_motion(tmp_path: Path) -> None:
    euler = sitk.Euler3DTransform((10.0, 20.0, -30.0), 0.1, -0.2, 0.05, (1.0, 2.0, 3.0))
    sitk.WriteTransform(euler, str(tmp_path / "euler.tfm"))
    expected = [euler.TransformPoint(point) for point in POINTS.tolist()]
    np.testing.assert_allclose(read_transform(tmp_path / "euler.tfm")(POINTS), expected, atol=1e-9)


def test_a_stretch_is_no_rigid_motion(tmp_path: Path) -> None:
    sitk.WriteTransform(sitk.ScaleTransform(3, (1.1, 1.0, 1.0)), str(tmp_path / "stretch.tfm"))
    with pytest.raises(ImageError, match=r"stretch\.tfm holds no rigid transform"):
        read_transform(tmp_path / "stretch.tfm")


def test_an_absent_transform_is_named(tmp_path: Path) -> None:
    with pytest.raises(ImageError, match=r"no transform .*absent\.tfm; run the registration"):
        read_transform(tmp_path / "absent.tfm")


def test_a_transform_that_is_cut_short_is_rejected(tmp_path: Path) -> None:
    """ITK reads what is left of it as the identity, or with zeros."""
    write_transform(MOTION, tmp_path / "a.tfm")
    whole = (tmp_path / "a.tfm").read_bytes()
    for end in [*range(0, len(whole), 9), *range(len(whole) - 8, len(whole))]:
        (tmp_path / "a.tfm").write_bytes(whole[:end])
        with pytest.raises(ImageError, match=r"a\.tfm holds no rigid transform"):
            read_transform(tmp_path / "a.tfm")
