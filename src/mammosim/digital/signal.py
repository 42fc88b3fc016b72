"""The T2-weighted image of a body: spin-echo signal, partial volume, markers, bias field and Rician noise."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mammosim.core.errors import ConfigurationError
from mammosim.core.labels import Label
from mammosim.core.progress import progress
from mammosim.core.rng import generator
from mammosim.core.volume import Grid, Image, LabelMap, grid_around
from mammosim.digital.body import Body
from mammosim.digital.shape import random_waves, waves
from mammosim.digital.thorax import ORGANS
from mammosim.io.tabulated import tabulated

# ASSUME: the coil's sensitivity varies as random waves of 300-800 mm, the same in all of an image's tissues.
BIAS_WAVES, BIAS_MM = 8, (300.0, 800.0)
SAMPLES_AT_ONCE = 2_000_000  # sub-samples held in memory while one slab of slices is drawn
CODES = {**{label.tissue: int(label) for label in Label if label is not Label.THORAX}, **ORGANS}


@dataclass(frozen=True)
class Scan:
    """How the image is taken.

    adipose: intensity of fat without noise; bias: standard deviation of the logarithm of the coil's
    sensitivity; noise: standard deviation of each quadrature channel per adipose intensity; subsamples:
    points per voxel edge that are averaged (partial volume); marker_mm: diameter of the marker balls.
    """

    echo_time_ms: float
    repetition_time_ms: float
    adipose: float
    bias: float
    noise: float
    subsamples: int
    marker_mm: float

    def __post_init__(self) -> None:
        for name in ("echo_time_ms", "repetition_time_ms", "adipose", "marker_mm"):
            if getattr(self, name) <= 0:
                raise ConfigurationError(f"{name} = {getattr(self, name):g} must be positive")
        if not 0 <= self.bias < 1 or not 0 <= self.noise < 1:
            raise ConfigurationError(f"bias {self.bias:g} and noise {self.noise:g} are shares; give 0 to 1")
        if not 1 <= self.subsamples <= 8:
            raise ConfigurationError(
                f"subsamples = {self.subsamples} per voxel edge; choose 1 to 8, usually 2"
            )


@dataclass(frozen=True)
class FieldOfView:
    """From the lowest to the highest coordinate along each axis, scanner frame, mm."""

    x: tuple[float, float]
    y: tuple[float, float]
    z: tuple[float, float]

    def __post_init__(self) -> None:
        for axis, (low, high) in vars(self).items():
            if not low < high:
                raise ConfigurationError(f"{axis} from {low:g} to {high:g} mm: give the lowest first")


@dataclass(frozen=True)
class ScanSettings:
    """A scan as it is configured: `digital.scan`; fat_intensity is that of Scan.adipose."""

    spacing_mm: tuple[float, float, float]
    field_of_view_mm: FieldOfView
    echo_time_ms: float
    repetition_time_ms: float
    fat_intensity: float
    bias_percent: float
    noise_percent: float
    subvoxels: int
    marker_mm: float

    def __post_init__(self) -> None:
        if not min(self.spacing_mm) > 0:
            raise ConfigurationError(f"spacing_mm = {list(self.spacing_mm)} must be above 0 along each axis")

    @property
    def scan(self) -> Scan:
        """How the image is taken. Raises ConfigurationError as Scan does."""
        return Scan(
            echo_time_ms=self.echo_time_ms,
            repetition_time_ms=self.repetition_time_ms,
            adipose=self.fat_intensity,
            bias=self.bias_percent / 100,
            noise=self.noise_percent / 100,
            subsamples=self.subvoxels,
            marker_mm=self.marker_mm,
        )

    @property
    def grid(self) -> Grid:
        """The voxels, scanner frame."""
        view = self.field_of_view_mm
        low, high = np.array([view.x, view.y, view.z], float).T
        return grid_around(low, high, np.array(self.spacing_mm, float))


def signals(scan: Scan) -> np.ndarray:
    """Intensity (256,) of each material code: S = rho (1 - exp(-TR / T1)) exp(-TE / T2), fat as scan.adipose.

    Relaxation times T1, T2 and proton densities rho from io/data/t2_signal.csv.
    """
    # ASSUME: the turbo spin echo is a spin echo at its effective echo time; fat's T2 is the multi-echo value.
    table = tabulated("t2_signal").set_index("material")
    TE, TR = scan.echo_time_ms, scan.repetition_time_ms
    S = table.proton_density * (1 - np.exp(-TR / table.t1_ms)) * np.exp(-TE / table.t2_ms)
    intensity = np.zeros(256)
    for material, code in CODES.items():
        intensity[code] = scan.adipose * S[material] / S["adipose"]
    return intensity


def render(body: Body, grid: Grid, *, scan: Scan, stream: tuple[str | int, ...]) -> Image:
    """The magnitude image of a body on a scanner grid; `stream` names its bias field and noise.

    The bytes do not depend on how many slices are drawn at once: noise has one stream per slice.
    """
    values = np.empty(grid.shape, np.float32)
    intensity = signals(scan)
    balls = marker_centres(body, scan)
    bias = random_waves(generator(*stream, "bias"), BIAS_WAVES, *BIAS_MM)
    for start, slab in _slabs(grid, scan.subsamples):
        fine = finer(slab, scan.subsamples)
        S = _mean(intensity[_with_markers(body, fine, balls, scan.marker_mm)], scan.subsamples)
        S *= np.exp(scan.bias * waves(slab.centres(), *bias)).reshape(slab.shape)
        for k, slice_ in enumerate(S, start=start):
            values[k] = rician(slice_, scan.noise * scan.adipose, generator(*stream, "noise", k))
    return Image(grid, values)


def truth_labels(body: Body, grid: Grid, *, scan: Scan) -> LabelMap:
    """The label at each voxel's centre, so that volumes of thin tissues are right on average."""
    values = np.empty(grid.shape, np.uint8)
    balls = marker_centres(body, scan)
    for start, slab in _slabs(grid, 1):
        materials = _with_markers(body, slab, balls, scan.marker_mm)
        materials[materials >= min(ORGANS.values())] = Label.THORAX
        values[start : start + slab.shape[0]] = materials
    return LabelMap(grid, values)


def rician(S: np.ndarray, sigma: float, rng: np.random.Generator) -> np.ndarray:
    """|S + n1 + i n2| with n1, n2 normal of standard deviation sigma: noise of a magnitude image."""
    n1, n2 = rng.normal(scale=sigma, size=(2, *S.shape))
    return np.hypot(S + n1, n2)


def marker_centres(body: Body, scan: Scan) -> np.ndarray:
    """Centres (10, 3) of the marker balls, which touch the skin from outside, scanner frame, mm."""
    # ASSUME: markers are bright balls of water gel glued on the skin, touching it in one point.
    listed = body.fiducials()
    worn = [kind != "nipple" for kind in listed.kinds]
    return (listed.points + scan.marker_mm / 2 * body.normals())[worn]


def finer(grid: Grid, n: int) -> Grid:
    """The grid with every voxel cut into n x n x n."""
    spacing = grid.spacing / n
    origin = grid.origin + grid.direction @ ((spacing - grid.spacing) / 2)
    nz, ny, nx = grid.shape
    return Grid((nz * n, ny * n, nx * n), spacing, origin, grid.direction)


def _mean(values: np.ndarray, n: int) -> np.ndarray:
    nz, ny, nx = (size // n for size in values.shape)
    return values.reshape(nz, n, ny, n, nx, n).mean(axis=(1, 3, 5))


def _slabs(grid: Grid, subsamples: int) -> Iterator[tuple[int, Grid]]:
    nz, ny, nx = grid.shape
    thick = max(1, SAMPLES_AT_ONCE // (ny * nx * subsamples**3))
    starts = range(0, nz, thick)
    for start in progress(starts, label="slabs", total=len(starts)):
        origin = grid.points(np.array([[start, 0, 0]]))[0]
        yield start, Grid((min(thick, nz - start), ny, nx), grid.spacing, origin, grid.direction)


def _with_markers(body: Body, grid: Grid, balls: np.ndarray, diameter_mm: float) -> np.ndarray:
    materials = body.materials(grid)
    for ball in balls:
        _glue(materials, grid, ball, diameter_mm / 2)
    return materials


def _glue(materials: np.ndarray, grid: Grid, ball: np.ndarray, radius: float) -> None:
    """Mark the air within a radius of a ball's centre (3,)."""
    centre, reach = grid.indices(ball[None])[0], radius / grid.spacing[::-1]
    low = np.maximum(np.ceil(centre - reach), 0).astype(int)
    high = np.minimum(np.floor(centre + reach) + 1, grid.shape).astype(int)
    voxels = np.stack(np.meshgrid(*map(np.arange, low, high), indexing="ij"), axis=-1).reshape(-1, 3)
    voxels = voxels[np.linalg.norm(grid.points(voxels.astype(float)) - ball, axis=1) < radius]
    voxels = voxels[materials[tuple(voxels.T)] == Label.AIR]
    materials[tuple(voxels.T)] = Label.MARKER
