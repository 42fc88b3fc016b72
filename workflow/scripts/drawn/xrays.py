"""X-rays of one compressed breast: its voxels, its mammogram, slices of tomosynthesis."""

import numpy as np
from matplotlib.figure import Figure

from mammosim.core.labels import Label
from mammosim.figures import radiograph
from mammosim.io.tables import read_table
from mammosim.io.written import read_image, read_labels


def phantom(files: dict, told: dict, job: dict) -> Figure:
    """Slices through the voxels."""
    return radiograph.phantom_slices(read_labels(files["labels"]))


def mammogram(files: dict, told: dict, job: dict) -> Figure:
    """The mammogram as it is read."""
    layers = read_image(files["image"])
    image, lesion, _ = layers.values
    row = read_table(files["row"]).iloc[0].to_dict()
    pixel = float(layers.grid.spacing[0])
    return radiograph.mammogram(image, pixel_mm=pixel, lesion=lesion > 0.5, row=row, side=job["side"])


def tomosynthesis(files: dict, told: dict, job: dict) -> Figure:
    """Slices, and how far the lesion is seen above and below its own slice."""
    labels = read_labels(files["phantom"])
    lesion = labels.grid.points(np.argwhere(labels.values == Label.LESION).astype(float)).mean(axis=0)
    slices = {name: read_image(files[name]) for name in ("filtered_backprojection", "sart")}
    return radiograph.tomosynthesis(slices, read_table(files["profiles"]), lesion, side=job["side"])
