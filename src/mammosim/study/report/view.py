"""Bodies that a page turns and cuts: tetrahedra, points and fields as compact text that its script reads.

A body is drawn by the corners of its quadratic tetrahedra. Points become 16 bits per coordinate between the
least and the greatest one, fields 8 bits per value, arrays base64; shared tetrahedra are kept once.
"""

import base64
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from jinja2 import Environment, StrictUndefined
from markupsafe import Markup

from mammosim.core.labels import DEFORMABLE, Label
from mammosim.core.mesh import FACES, TetMesh
from mammosim.study.report.pages import template

# Fields: name -> in words, and unit.
FIELDS: Mapping[str, tuple[str, str]] = {
    "logarithmic": ("largest logarithmic strain", ""),
    "von_mises_kpa": ("von Mises stress", "kPa"),
    "energy_kpa": ("elastic energy per volume", "kPa"),
    "pressure_kpa": ("contact pressure on the skin", "kPa"),
}
NO_DOSE = (
    "Dose is not among the fields: the photon transport tallies its mean over the glandular tissue of the "
    "voxels, and not in every cell. The report has it in tables and figures."
)
COARSE, FINE = 255, 65535
# ASSUME: half a percent of the cells have more, and the last colour; the greatest value is told.
CLIPPED_PERCENTILE = 99.5


@dataclass(frozen=True)
class Body:
    """A body: group and name in words, its mesh (points in mm, LPS), and fields on its cells and its skin.

    cells: field -> (n_cell,); skin: field -> (n_face,), in the order of the mesh's boundary `skin`.
    """

    group: str
    name: str
    mesh: TetMesh
    cells: Mapping[str, np.ndarray] = field(default_factory=dict)
    skin: Mapping[str, np.ndarray] = field(default_factory=dict)


def script(volunteer: str, bodies: Sequence[Body], absent: Sequence[str]) -> str:
    """The script that gives a woman's bodies to the page.

    absent: a sentence for everything that is not there, what and how to get it.
    """
    topologies: dict[bytes, int] = {}
    packed = [_body(body, topologies) for body in bodies]
    tetrahedra = [_tetrahedra(key, bodies, packed, number) for key, number in topologies.items()]
    data = {"topologies": tetrahedra, "bodies": packed, "absent": list(absent)}
    return f"mammosim.show({json.dumps(volunteer)}, {json.dumps(data, ensure_ascii=True)});\n"


def _body(body: Body, topologies: dict[bytes, int]) -> dict[str, object]:
    """One body; its tetrahedra are a number in `topologies`, which grows with those that are new."""
    corners = body.mesh.cells[:, :4]
    nodes = np.unique(corners)
    points = body.mesh.points[nodes]
    low, high = points.min(axis=0), points.max(axis=0)
    steps = np.rint((points - low) / (high - low) * FINE).astype("<u2")
    fields = {name: _values(name, values) for name, values in body.cells.items()}
    fields |= {
        name: _values(name, values) | {"faces": text_of(skin_faces(body.mesh).astype("<u4"))}
        for name, values in body.skin.items()
    }
    return {
        **{"group": body.group, "name": body.name},
        "topology": topologies.setdefault(np.ascontiguousarray(corners).tobytes(), len(topologies)),
        **{"low": low.round(4).tolist(), "high": high.round(4).tolist(), "points": text_of(steps)},
        "fields": fields,
    }


def _tetrahedra(
    key: bytes, bodies: Sequence[Body], packed: Sequence[dict[str, object]], number: int
) -> dict[str, object]:
    """Corners of the tetrahedra of a topology, counted in the points that are kept, and their tissues."""
    mesh = next(body.mesh for body, each in zip(bodies, packed) if each["topology"] == number)
    _, corners = np.unique(mesh.cells[:, :4], return_inverse=True)
    bits = 16 if corners.max() <= FINE else 32
    tissue = text_of(mesh.tissue.astype(np.uint8))
    return {"bits": bits, "corners": text_of(corners.astype(f"<u{bits // 8}")), "tissue": tissue}


def _values(name: str, values: np.ndarray) -> dict[str, object]:
    """A field without negative values in 8 bits."""
    words, unit = FIELDS[name]
    most = float(values.max(initial=0.0))
    high = float(np.percentile(values, CLIPPED_PERCENTILE)) if name != "pressure_kpa" else most
    high = high or most or 1.0
    steps = np.rint(np.clip(values / high, 0, 1) * COARSE).astype(np.uint8)
    return {
        "label": words,
        "unit": unit,
        "high": float(f"{high:.4g}"),
        "most": float(f"{most:.4g}"),
        "values": text_of(steps),
    }


def skin_faces(mesh: TetMesh) -> np.ndarray:
    """The number (n_face,) 4 cell + face of each face of the boundary `skin`."""
    corners = np.array([face[:3] for face in FACES])
    owned = np.sort(mesh.cells[:, corners].reshape(-1, 3), axis=1)
    asked = np.sort(mesh.boundaries["skin"][:, :3], axis=1)
    _, number = np.unique(np.vstack([owned, asked]), axis=0, return_inverse=True)
    number = number.ravel()
    order = np.argsort(number[: len(owned)], kind="stable")
    return order[np.searchsorted(number[: len(owned)], number[len(owned) :], sorter=order)]


def text_of(values: np.ndarray) -> str:
    """The bytes of an array as base64."""
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode()


def page(
    title: str, volunteers: Sequence[str], *, colours: Mapping[Label, str], footer: Mapping[str, str]
) -> str:
    """The page that shows them: it reads view/VOLUNTEER.js and scripts/plotly.js beside it.

    colours: of the tissues; footer: what made it, name -> words.
    """
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    tissues = [(int(label), label.tissue, colours[label]) for label in DEFORMABLE]
    return environment.from_string(template("view.html.j2")).render(
        title=title,
        volunteers=volunteers,
        footer=footer.items(),
        dose=NO_DOSE,
        style=Markup(template("page.css") + template("view.css")),
        script=Markup(template("view.js")),
        tissues=Markup(json.dumps(tissues)),
    )
