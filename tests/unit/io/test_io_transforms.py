"""A rigid motion reads back as the same motion, also when another program wrote it about a centre."""

from pathlib import Path

import numpy as np
import pytest
import SimpleITK as sitk

from mammosim.core.errors import ImageError
from mammosim.core.rigid import RigidTransform, rotation
from mammosim.core.volume import Grid, grid_around
from mammosim.io.images import itk_volume
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
    fixed_to_moving = [euler.TransformPoint(point) for point in POINTS.tolist()]
    moved = read_transform(tmp_path / "euler.tfm")(np.array(fixed_to_moving))
    np.testing.assert_allclose(moved, POINTS, atol=1e-9)


def test_another_program_brings_the_images_together_with_the_file(tmp_path: Path) -> None:
    grid = grid_around(np.full(3, -20.0), np.full(3, 20.0), 1.0)
    place = np.array([-3.0, 2.0, 6.0])
    moving, fixed = (_ball(grid, centre) for centre in (place, MOTION(place[None])[0]))
    write_transform(MOTION, tmp_path / "prone.tfm")
    found = sitk.Resample(moving, fixed, sitk.ReadTransform(str(tmp_path / "prone.tfm")))
    apart, together = (sitk.GetArrayFromImage(image) for image in (moving, found))
    there = sitk.GetArrayFromImage(fixed)
    assert np.corrcoef(apart.ravel(), there.ravel())[0, 1] < 0.6
    # Linear interpolation blurs the edge of a ball of 5 voxels by about one.
    assert np.corrcoef(together.ravel(), there.ravel())[0, 1] > 0.95


def _ball(grid: Grid, centre: np.ndarray) -> sitk.Image:
    inside = np.linalg.norm(grid.centres() - centre, axis=1) < 5
    return itk_volume(grid, inside.reshape(grid.shape).astype(np.float32))


def test_a_stretch_is_no_rigid_motion(tmp_path: Path) -> None:
    sitk.WriteTransform(sitk.ScaleTransform(3, (1.1, 1.0, 1.0)), str(tmp_path / "stretch.tfm"))
    with pytest.raises(ImageError, match=r"stretch\.tfm holds no rigid transform"):
        read_transform(tmp_path / "stretch.tfm")


def test_a_motion_that_bends_is_no_rigid_one(tmp_path: Path) -> None:
    """Where its control points are, it may look like the identity."""
    bent = sitk.BSplineTransform(3)
    bent.SetTransformDomainOrigin((-50.0, -50.0, -50.0))
    bent.SetTransformDomainPhysicalDimensions((10.0, 10.0, 10.0))
    bent.SetParameters([5.0] * len(bent.GetParameters()))
    sitk.WriteTransform(bent, str(tmp_path / "bent.tfm"))
    with pytest.raises(ImageError, match=r"bent\.tfm holds no rigid transform.*is not linear"):
        read_transform(tmp_path / "bent.tfm")


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


@pytest.mark.parametrize("name", ["Parameters:", "FixedParameters:"])
@pytest.mark.parametrize("left", [0, -1])
def test_a_transform_that_lacks_a_number_or_a_line_is_rejected_in_one_line(
    tmp_path: Path, name: str, left: int
) -> None:
    """Also where somebody has ended its last line; without a line ITK reads the identity."""
    write_transform(MOTION, tmp_path / "a.tfm")
    lines = (tmp_path / "a.tfm").read_text().splitlines()
    cut = [" ".join(line.split()[:left]) if line.startswith(name) else line for line in lines]
    (tmp_path / "a.tfm").write_text("\n".join(cut) + "\n")
    with pytest.raises(ImageError, match=r"a\.tfm holds no rigid transform") as raised:
        read_transform(tmp_path / "a.tfm")
    assert "\n" not in str(raised.value)
