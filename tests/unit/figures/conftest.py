"""A made-up torso with two breasts as a small mesh and as images: plausible shapes for pictures."""

import re
from collections.abc import Iterator
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Text

from mammosim.core.fiducials import Fiducials
from mammosim.core.labels import Label
from mammosim.core.mesh import EDGES, FACES, TetMesh
from mammosim.core.volume import Image, LabelMap, grid_around
from mammosim.figures import render, style

CUBE = np.array([[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]])
NIPPLES = np.array([[75.0, 0, -4], [-75.0, 0, -4]])


@pytest.fixture(autouse=True)
def no_letter_is_too_small(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Of every figure that a test of this folder draws, at the width of a printed page."""
    monkeypatch.setitem(render.render.__kwdefaults__, "columns", 200)  # which takes a tenth of the time
    drawn: list[Figure] = []
    apart = style.keep_names_apart
    monkeypatch.setattr(style, "keep_names_apart", lambda figure: (drawn.append(figure), apart(figure)))
    yield
    small = [
        (text.get_text(), text.get_fontsize())
        for figure in drawn
        for text in figure.findobj(Text)
        if text.get_text().strip() and text.get_fontsize() < 8.0
    ]
    assert not small
    # 17 cm, which a page prints at full size; narrower ones are not enlarged.
    assert all(figure.get_figwidth() <= 17.1 / 2.54 for figure in drawn)


def title(ax: Axes) -> str:
    """The title of a panel without its letter."""
    return re.sub(r"^[a-z]{1,2}(  |$)", "", ax.get_title(loc="left"))


@pytest.fixture(scope="session")
def torso() -> SimpleNamespace:
    """mesh (prone), flat (supine), image, labels, fiducials."""
    return make_torso()


def make_torso(*, n: tuple[int, int, int] = (16, 4, 10), spacing: float = 6.0) -> SimpleNamespace:
    mesh, flat = make_mesh(n, height=52.0), make_mesh(n, height=24.0)
    labels = make_labels(spacing)
    nipples = NIPPLES.copy()
    nipples[:, 1] = front(nipples[:, 0], nipples[:, 2], 52.0)
    chest = np.array([[0, -55.0, 80], [60, -48, 85], [-60, -48, 85], [5, -55, -85]])
    fiducials = Fiducials(
        ("nipple_left", "nipple_right", "chest_1", "chest_2", "chest_3", "chest_4"),
        ("nipple",) * 2 + ("chest",) * 4,
        np.vstack([nipples, chest]),
    )
    signal = np.array([0.02, 1.0, 0.45, 0.3, 0.25, 0.12, 1.4, 0.5])[labels.values]
    noise = np.random.default_rng(1).normal(0, 0.02, signal.shape)
    image = Image(labels.grid, np.abs(signal + noise).astype(np.float32) * 900)
    return SimpleNamespace(mesh=mesh, flat=flat, image=image, labels=labels, fiducials=fiducials)


def wall(x: np.ndarray) -> np.ndarray:
    """y of the front of the rib cage."""
    return 60 - 100 * np.sqrt(np.clip(1 - (x / 180) ** 2, 0.05, 1))


def front(x: np.ndarray, z: np.ndarray, height: float) -> np.ndarray:
    """y of the skin."""
    r2 = np.minimum((x - 75) ** 2, (x + 75) ** 2) + (z + 4 * (height > 40)) ** 2
    return wall(x) - 16 - height * np.exp(-((r2 / 48**2) ** 1.6))


def make_mesh(n: tuple[int, int, int], *, height: float) -> TetMesh:
    nx, ny, nz = n
    u, v, w = (np.linspace(0, 1, k + 1) for k in n)
    W, V, U = np.meshgrid(w, v, u, indexing="ij")
    corners = np.stack([U.ravel(), V.ravel(), W.ravel()], axis=1)
    row, layer = nx + 1, (nx + 1) * (ny + 1)
    offsets = np.array([(c & 1) + ((c >> 1) & 1) * row + (c >> 2) * layer for c in range(8)])
    k, j, i = np.indices((nz, ny, nx)).reshape(3, -1)
    tets = ((k * layer + j * row + i)[:, None, None] + offsets[CUBE][None]).reshape(-1, 4)
    ends = np.sort(tets[:, np.array(EDGES)], axis=2).reshape(-1, 2)
    edges, number = np.unique(ends, axis=0, return_inverse=True)
    unit = np.vstack([corners, corners[edges].mean(axis=1)])
    cells = np.hstack([tets, len(corners) + number.reshape(-1, 6)])
    x, z = (unit[:, 0] - 0.5) * 300, (unit[:, 2] - 0.5) * 190
    y = front(x, z, height) + unit[:, 1] * (wall(x) - front(x, z, height))
    points = np.stack([x, y, z], axis=1)
    faces = cells[:, np.array(FACES)].reshape(-1, 6)
    _, index, count = np.unique(np.sort(faces[:, :3], axis=1), axis=0, return_index=True, return_counts=True)
    outer = faces[index[count == 1]]
    skin = np.all(unit[outer][..., 1] < 1e-9, axis=1)
    centre = points[cells[:, :4]].mean(axis=1)
    return TetMesh(points, cells, tissue_at(centre, height), {"skin": outer[skin], "posterior": outer[~skin]})


def tissue_at(p: np.ndarray, height: float) -> np.ndarray:
    x, y, z = p.T
    depth = y - front(x, z, height)
    radius = np.sqrt(np.minimum((x - 75) ** 2, (x + 75) ** 2) + z**2)
    gland = (radius < 34) & (depth > 8) & (y < wall(x) - 18)
    tissue = np.where(gland, Label.GLANDULAR, Label.ADIPOSE)
    return np.where(y > wall(x) - 8, Label.MUSCLE, tissue).astype(np.uint8)


def make_labels(spacing: float) -> LabelMap:
    grid = grid_around(np.array([-180.0, -150, -108]), np.array([180.0, 66, 108]), spacing)
    p = grid.centres()
    depth = p[:, 1] - front(p[:, 0], p[:, 2], 52.0)
    values = tissue_at(p, 52.0)
    values[(depth < spacing / 2) & (depth >= -spacing / 2)] = Label.SKIN
    values[p[:, 1] > wall(p[:, 0])] = Label.THORAX
    values[depth < -spacing / 2] = Label.AIR
    return LabelMap(grid, values.reshape(grid.shape))
