"""Superficial fascia is a second membrane: the law of skin, on faces of its own."""

from dataclasses import replace

import numpy as np
import pytest
from mechanics_bodies import box

from mammosim.core.errors import MechanicsError
from mammosim.core.labels import Label
from mammosim.core.mesh import FACES
from mammosim.core.tissues import Tissue
from mammosim.mechanics.body import Fascia, Skin, body_effects
from mammosim.mechanics.effects import Weight
from mammosim.mechanics.equilibrium import equilibrium

TISSUES = {Label.ADIPOSE: Tissue(0.5, 0.45, 0.95)}
FASCIA = Fascia(120.0, 0.45, 0.1)


@pytest.fixture(scope="module")
def mesh():
    """A block of 10 x 12 x 9 mm with the boundary `fascia` halfway up, inside."""
    block = box((2, 2, 2), (10.0, 12.0, 9.0))
    faces = block.cells[:, FACES].reshape(-1, 6)
    faces = faces[np.all(block.points[faces][:, :, 2] == 4.5, axis=1)]
    _, first = np.unique(np.sort(faces[:, :3], axis=1), axis=0, return_index=True)
    return replace(block, boundaries={**block.boundaries, "fascia": faces[first]})


def test_fascia_inside_stores_the_energy_of_its_own_area(mesh):
    """W_m = h mu / 2 (c1 + c2 + 1 / (c1 c2) - 3) on 120 mm2, whichever side its faces look to."""
    x, c1, c2 = mesh.points * [1.2, 1.1, 1.0], 1.2**2, 1.1**2
    W = 0.1 * 120.0 / (2 * 1.45) / 2 * (c1 + c2 + 1 / (c1 * c2) - 3)
    assert FASCIA.on(mesh).energy(x) == pytest.approx(120.0 * W, rel=1e-12)
    other_side = mesh.boundaries["fascia"][:, [0, 2, 1, 5, 4, 3]]
    flipped = replace(mesh, boundaries={"fascia": other_side})
    assert FASCIA.on(flipped).energy(x) == pytest.approx(120.0 * W, rel=1e-12)


def test_fascia_right_under_the_skin_adds_to_it(mesh):
    """Two layers on the same faces are one of the sum of their h mu."""
    x = mesh.points * [1.2, 1.1, 1.0]
    layers = body_effects(mesh, TISSUES, skin=Skin(10.0, 0.45, 1.5), fascia=replace(FASCIA, boundary="skin"))
    one = Skin(10.0 + 120.0 * 0.1 / 1.5, 0.45, 1.5).on(mesh)
    assert sum(layer.energy(x) for layer in layers[1:]) == pytest.approx(one.energy(x), rel=1e-12)


def test_fascia_holds_the_body_back(mesh):
    """The least energy of a stiffer body is higher, for E1 <= E2 at every shape; without load it is zero."""
    weight = Weight.of(mesh, TISSUES, np.array([0.0, 1.0, 0.0]))
    least = {
        fascia: equilibrium(mesh, body_effects(mesh, TISSUES, fascia=fascia), loads=(weight,)).energy
        for fascia in (None, FASCIA)
    }
    assert least[None] < least[FASCIA] < 0


def test_fascia_needs_its_faces(mesh):
    with pytest.raises(MechanicsError, match="no boundary 'fascia'; it has: posterior, skin"):
        body_effects(box((1, 1, 1), (1.0, 1.0, 1.0)), TISSUES, fascia=FASCIA)
