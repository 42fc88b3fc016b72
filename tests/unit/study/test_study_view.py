"""Bodies for the page that turns them: what its script reads is what the meshes are."""

import base64
import json
import re
from dataclasses import replace

import numpy as np
import pytest

from mammosim.core.labels import Label
from mammosim.core.mesh import FACES, TetMesh
from mammosim.study.report.view import Body, page, script, skin_faces


def read(text: str) -> tuple[str, dict]:
    """What the script hands to the page."""
    name, data = re.fullmatch(r"mammosim\.show\((\".*?\"), (.*)\);\n", text, re.S).groups()
    return json.loads(name), json.loads(data)


def numbers(text: str, kind: str) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), dtype=kind)


@pytest.fixture(scope="module")
def mesh(block):
    return block(2)


def test_points_and_tetrahedra_come_back(mesh):
    _, data = read(script("ada", [Body("measured", "prone", mesh)], []))
    (body,), (topology,) = data["bodies"], data["topologies"]
    low, high = np.array(body["low"]), np.array(body["high"])
    points = low + (high - low) * numbers(body["points"], "<u2").reshape(-1, 3) / 65535
    corners = numbers(topology["corners"], f"<u{topology['bits'] // 8}").reshape(-1, 4)
    found, exact = points[corners], mesh.points[mesh.cells[:, :4]]
    assert np.abs(found - exact).max() <= 0.5 * (high - low).max() / 65535 + 1e-9
    assert (numbers(topology["tissue"], "u1") == Label.ADIPOSE).all()


def test_bodies_of_the_same_tetrahedra_share_them(mesh):
    moved = mesh.moved_to(mesh.points + [1.0, 0, 0])
    other = replace(mesh, cells=mesh.cells[::-1], tissue=mesh.tissue[::-1])
    bodies = [Body("a", name, each) for name, each in (("1", mesh), ("2", moved), ("3", other))]
    _, data = read(script("ada", bodies, []))
    assert [each["topology"] for each in data["bodies"]] == [0, 0, 1]
    assert len(data["topologies"]) == 2


def test_every_face_of_the_skin_is_a_face_of_its_cell(mesh):
    cells, local = np.divmod(skin_faces(mesh), 4)
    corners = mesh.cells[cells[:, None], np.array(FACES)[local][:, :3]]
    assert (np.sort(corners) == np.sort(mesh.boundaries["skin"][:, :3])).all()


def test_fields_are_known_to_a_step_and_their_greatest_value_is_told(mesh):
    values = np.linspace(0, 2, len(mesh.cells))
    pressure = np.zeros(len(mesh.boundaries["skin"]))
    pressure[3] = 5.0
    _, data = read(
        script("ada", [Body("p", "s", mesh, {"von_mises_kpa": values}, {"pressure_kpa": pressure})], [])
    )
    fields = data["bodies"][0]["fields"]
    stress = fields["von_mises_kpa"]
    found = numbers(stress["values"], "u1") * stress["high"] / 255
    np.testing.assert_allclose(found, np.minimum(values, stress["high"]), atol=0.51 * stress["high"] / 255)
    assert (stress["most"], stress["unit"]) == (2.0, "kPa")
    on_skin = fields["pressure_kpa"]
    assert numbers(on_skin["values"], "u1").nonzero()[0].tolist() == [3]
    assert (numbers(on_skin["faces"], "<u4") == skin_faces(mesh)).all()


def test_what_is_absent_is_told_and_a_name_cannot_leave_the_script():
    name, data = read(script("</script><b>", [], ["prone is missing: <b>"]))
    assert (name, data["bodies"], data["absent"]) == ("</script><b>", [], ["prone is missing: <b>"])


def test_the_page_escapes_names_and_reads_nothing_from_elsewhere():
    colours = dict.fromkeys(Label, "#123456")
    text = page("T", ["<img src=x onerror=alert(1)>"], colours=colours, footer={"Date": "today"})
    assert "<img" not in text
    assert set(re.findall(r'(?:src|href)="([^"#]+)"', text)) == {"data:,", "report.html", "scripts/plotly.js"}


@pytest.mark.parametrize(("count", "bits"), [(16384, 16), (16385, 32)])
def test_of_any_number_of_points_each_tetrahedron_has_its_own(count, bits):
    """Tetrahedra that share no point, whose corners stand among the middles of their edges."""
    cells = np.arange(10 * count).reshape(count, 10)[:, ::-1]
    points = np.random.default_rng(1).uniform(0.0, 100.0, (10 * count, 3))
    mesh = TetMesh(points, cells, np.full(count, Label.ADIPOSE), {})
    _, data = read(script("ada", [Body("measured", "prone", mesh)], []))
    (body,), (topology,) = data["bodies"], data["topologies"]
    assert topology["bits"] == bits
    corners = numbers(topology["corners"], f"<u{bits // 8}").reshape(-1, 4)
    found = numbers(body["points"], "<u2").reshape(-1, 3)[corners] / 65535
    low, high = np.array(body["low"]), np.array(body["high"])
    np.testing.assert_allclose(low + (high - low) * found, points[cells[:, :4]], atol=1e-3)


def test_a_few_cells_above_all_others_do_not_take_the_colours_and_are_told(block):
    mesh = block(4)
    stress, pressure = np.full(len(mesh.cells), 2.0), np.full(len(mesh.boundaries["skin"]), 2.0)
    stress[0] = pressure[0] = 50.0
    few = np.zeros(len(mesh.cells))
    few[0] = 3.0
    shown = {"von_mises_kpa": stress, "energy_kpa": few, "logarithmic": 0 * few}
    _, data = read(script("ada", [Body("p", "s", mesh, shown, {"pressure_kpa": pressure})], []))
    scale = {name: (each["high"], each["most"]) for name, each in data["bodies"][0]["fields"].items()}
    # Pressure has its greatest value on few faces always.
    assert scale["pressure_kpa"] == (50.0, 50.0)
    assert scale["von_mises_kpa"] == (2.0, 50.0)
    assert scale["energy_kpa"] == (3.0, 3.0), "of a field that is nothing almost everywhere"
    assert scale["logarithmic"] == (1.0, 0.0)
