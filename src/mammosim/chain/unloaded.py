"""What a breast consists of, its shape unloaded by one method, and the stress-free one loaded elsewhere.

Its effects are gland and muscle (stiffer than fat), skin, fascia and ligaments.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import pandas as pd

from mammosim.chain.conditions import begins_with_mean, is_under_gravity
from mammosim.chain.fields import Fields, fields_of
from mammosim.chain.graph import Inputs
from mammosim.chain.morph import Morph, MorphSettings, morphed, sound_mean
from mammosim.core.errors import ConfigurationError
from mammosim.core.mesh import TetMesh
from mammosim.core.positions import gravity_direction
from mammosim.core.settings import looked_up, read, require_positive
from mammosim.core.tissues import Membrane, TissueTable
from mammosim.io.meshes import read_mesh, write_mesh
from mammosim.io.tables import write_table
from mammosim.mechanics.body import Body, Fascia, Ligaments, Part, Skin
from mammosim.mechanics.equilibrium import Settings
from mammosim.mechanics.newton import NewtonSettings
from mammosim.mechanics.unloaded import UnloadingSettings
from mammosim.mechanics.unloading import METHODS
from mammosim.meshing.distance import surface_distance


def body(inputs: Inputs) -> Body:
    """The body that is measured."""
    return _body(inputs, "tissues")


def loaded_body(inputs: Inputs) -> Body:
    """The body that is measured, with the moduli that carry its weight."""
    factor: float = inputs["stress_free"].moduli_factor
    return _body(inputs, "tissues").stiffened(factor)


def pressed_body(inputs: Inputs) -> Body:
    """The body between the plates."""
    # ASSUME: the stress-free shape is that of the study's own moduli, whatever a breast is pressed with.
    return _body(inputs, "load.tissues").stiffened(pressed_factor(inputs))


def pressed_factor(inputs: Inputs) -> float:
    """Of the moduli between the plates: those under gravity carry the weight, another set is as it is.

    By the name of the set, not by its values: a campaign may change one of them, and what is next to her own
    moduli is as stiff as they are.
    """
    return float(inputs["stress_free"].moduli_factor) if is_under_gravity(inputs) else 1.0


def _body(inputs: Inputs, name: str) -> Body:
    """Of a table of tissues. A stiffer tissue whose effect is absent is as stiff as fat."""
    table = read(TissueTable, inputs.setting(name), name)
    tissues = {**table.tissues}
    for effect, tissue in (("gland", "glandular"), ("muscle", "muscle")):
        if not inputs.has(effect):
            fat = tissues["adipose"].youngs_modulus_kpa
            tissues[tissue] = replace(tissues[tissue], youngs_modulus_kpa=fat)
    parts: Mapping[str, Callable[[], Part]] = {
        "skin": lambda: Skin(**vars(_skin(table, name))),
        # ASSUME: superficial fascia lies right under the skin.
        "fascia": lambda: replace(_fascia(inputs), boundary="skin"),
        "ligaments": lambda: read(Ligaments, inputs.setting("effects.ligaments"), "effects.ligaments"),
    }
    present = tuple(part() for effect, part in parts.items() if inputs.has(effect))
    return Body(replace(table, tissues=tissues).by_label, present)


def _fascia(inputs: Inputs) -> Fascia:
    return read(Fascia, inputs.setting("effects.fascia"), "effects.fascia")


def _skin(table: TissueTable, name: str) -> Membrane:
    if table.skin is None:
        raise ConfigurationError(f"{name} has no skin; add it, or leave `skin` out of mechanics.effects")
    return table.skin


HISTORY = ["iteration", "mean_mm", "max_mm", "damping", "factorisations", "seconds"]


@dataclass(frozen=True)
class StressFreeSettings:
    """`mechanics.stress_free`: a method of METHODS; when it ends, see UnloadingSettings."""

    default: str
    iterations: int
    tolerance_mm: float

    def __post_init__(self) -> None:
        require_positive(self, "iterations", "tolerance_mm")
        if self.default not in METHODS:
            raise ConfigurationError(f"no method {self.default!r}; choose one of: {', '.join(METHODS)}")


@dataclass(frozen=True)
class UnloadedShape:
    """The body without gravity by one method; history: HISTORY, a row per iteration, empty where read."""

    mesh: TetMesh
    history: pd.DataFrame


@dataclass(frozen=True)
class MeanShape:
    """The mean of the measured body and of itself in the shape of the reference position.

    morph: see chain.morph, None where it was read from a file; share: of the morphed shape in the mean;
    distance_mm (n_node,): what is left to the reference's skin, 0 off the skin.
    """

    mesh: TetMesh
    morph: Morph | None = None
    share: float = np.nan
    distance_mm: np.ndarray | None = None


def mean_shape(inputs: Inputs) -> MeanShape:
    """By surfaces alone; nearer to the measured body where the mean would fold.

    Raises ConfigurationError where the measured position is the reference itself.
    """
    if not inputs.subject.moves:
        raise ConfigurationError("a mean needs two positions: begin with the measured shape")
    mesh, reference = inputs["mesh"], inputs["reference_mesh"]
    settings = read(MorphSettings, inputs.setting("morph"), "morph")
    found = morphed(mesh, reference, settings=settings)
    mean = sound_mean(mesh, found.points)
    body = mesh.moved_to(found.points)
    distance = np.zeros(len(body.points))
    distance[body.boundary_nodes("skin")] = surface_distance(body, reference)
    return MeanShape(mesh.moved_to(mean.points), found, mean.share, distance)


def save_mean_shape(found: MeanShape, files: Mapping[str, str], job: Mapping[str, str]) -> None:
    """The mean, the morphed body with what is left to the reference, and the levels of the morph."""
    write_mesh(found.mesh, files["mesh"])
    if found.morph is not None and found.distance_mm is not None:
        body = found.mesh.moved_to(found.morph.points)
        write_mesh(body, files["morphed"], point_data={"distance_mm": found.distance_mm})
        table = pd.DataFrame(found.morph.history).assign(mean_share=found.share)
        write_table(table.assign(**job)[[*job, *table.columns]], files["history"])


def load_mean_shape(files: Mapping[str, str]) -> MeanShape:
    """The mean."""
    return MeanShape(read_mesh(files["mesh"]))


def unloaded(inputs: Inputs) -> UnloadedShape:
    """By the method of the settings, with the moduli as they are."""
    mesh = inputs["mesh"]
    given = looked_up(StressFreeSettings, inputs.setting, "mechanics.stress_free")
    start = inputs["mean_shape"].mesh.points if begins_with_mean(inputs) else None
    found = METHODS[given.default](
        mesh,
        inputs["body"],
        gravity=inputs["breast"].gravity,
        start=start,
        settings=UnloadingSettings(given.tolerance_mm, given.iterations),
    )
    columns = {name: [getattr(step, name) for step in found.history] for name in HISTORY}
    return UnloadedShape(mesh.moved_to(found.points), pd.DataFrame(columns))


def save_unloaded(found: UnloadedShape, files: Mapping[str, str], job: Mapping[str, str]) -> None:
    """The shape, and what every iteration left."""
    write_table(found.history.assign(**job)[[*job, *HISTORY]], files["history"])
    write_mesh(found.mesh, files["shape"])


def load_unloaded(files: Mapping[str, str]) -> UnloadedShape:
    """What save_unloaded wrote, without its history."""
    return UnloadedShape(read_mesh(files["shape"]), pd.DataFrame(columns=HISTORY))


@dataclass(frozen=True)
class LoadedShape:
    """The body in equilibrium; fields: chain.fields, to look at, none where it was read from a file."""

    mesh: TetMesh
    fields: Fields = field(default_factory=Fields)


def loaded(inputs: Inputs) -> LoadedShape:
    """The body in the position of the load."""
    newton = NewtonSettings(tolerance=inputs.setting("mechanics.newton_tolerance"))
    gravity = gravity_direction(inputs.setting("load.position"))
    rest: TetMesh = inputs["stress_free"].mesh
    body: Body = inputs["loaded_body"]
    points: np.ndarray = body.load(rest, gravity, settings=Settings(newton=newton)).points
    return LoadedShape(rest.moved_to(points), fields_of(rest, body.effects(rest), points))


def save_loaded(found: LoadedShape, files: Mapping[str, str], job: Mapping[str, str]) -> None:
    """The shape, with displacement, strain and stress."""
    write_mesh(found.mesh, files["shape"], point_data=found.fields.nodes, cell_data=found.fields.cells)


def load_loaded(files: Mapping[str, str]) -> LoadedShape:
    """The shape that save_loaded wrote."""
    return LoadedShape(read_mesh(files["shape"]))
