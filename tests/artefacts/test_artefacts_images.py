"""The images and figures of the small run make sense: nothing blank or infinite, a breast darker than air."""

import json

import matplotlib.image
import numpy as np
import pytest
import SimpleITK as sitk

pytestmark = pytest.mark.workflow


def read(file) -> np.ndarray:
    return sitk.GetArrayFromImage(sitk.ReadImage(str(file)))


def test_every_figure_shows_something(results):
    figures = sorted((results / "study/figures").glob("*.png"))
    assert len(figures) > 40
    for figure in figures:
        pixels = matplotlib.image.imread(figure)
        ink = (pixels[..., :3] < 0.9).any(axis=-1).mean()
        assert 0.001 < ink < 0.95, figure.name
        assert figure.with_suffix(".pdf").read_bytes().endswith(b"%%EOF\n"), figure.name


def test_no_image_holds_anything_but_numbers(results):
    images = sorted(results.glob("**/*.nii.gz"))
    assert len(images) > 20
    for image in images:
        values = read(image)
        assert np.isfinite(values).all(), image.name
        assert values.min() < values.max(), image.name


def test_fewer_photons_arrive_behind_the_breast(results):
    mammograms = sorted(results.glob("xray/*/*/*_mammogram.nii.gz"))
    assert mammograms
    for mammogram in mammograms:
        energy, lesion, ring = read(mammogram)
        air, behind = np.percentile(energy, 99), energy[(lesion + ring) > 0].mean()
        assert energy.min() > 0
        assert 0.02 < behind / air < 0.3  # exp(-mu t) of 45 to 60 mm, mu = 0.06 to 0.08 / mm, and scatter
        assert not ((lesion > 0) & (ring > 0)).any()


def test_a_phantom_holds_skin_fat_gland_and_air_alone(results):
    phantoms = sorted(results.glob("phantom/*/*/*.nii.gz"))
    assert phantoms
    for phantom in phantoms:
        values, counts = np.unique(read(phantom), return_counts=True)
        assert 3 <= len(values) <= 12, phantom.name
        assert counts.min() > 0


def test_segmentation_and_its_image_lie_on_one_grid(results):
    segmented = sorted(results.glob("segmentation/*/*.nii.gz"))
    assert segmented
    for labels in segmented:
        position = labels.name.partition("_glandular")[0].removesuffix(".nii.gz")
        image = sitk.ReadImage(str(results / "images" / labels.parent.name / f"{position}.nii.gz"))
        found = sitk.ReadImage(str(labels))
        assert found.GetSize() == image.GetSize()
        np.testing.assert_allclose(found.GetOrigin(), image.GetOrigin())
        np.testing.assert_allclose(found.GetDirection(), image.GetDirection(), atol=1e-12)


def test_the_numbers_of_the_report_are_numbers(results):
    numbers = json.loads((results / "study/numbers.json").read_text())
    floats = [value for value in numbers.values() if isinstance(value, float)]
    assert floats
    assert np.isfinite(floats).all()
