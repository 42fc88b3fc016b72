"""A cluster of microcalcifications, finer than any voxel: exact balls behind one place in the breast.

    S(x) = S0(x) sum_E w_E exp(-(mu_c - mu_t) t(x)) / sum_E w_E,   w_E = N R exp(-sum_m mu_m L_m)

S0 is the image without them, t the chord of a ray through the balls, mu_c of them and mu_t of the tissue
in their place, N R exp(-...) the spectrum that reaches the detector behind that place.
"""

from dataclasses import dataclass, replace

import numpy as np

from mammosim.chain.mammogram import View, tissue_materials, xray_phantom
from mammosim.chain.phantom import healthy
from mammosim.core.errors import XrayError
from mammosim.core.labels import Label
from mammosim.core.settings import require_positive
from mammosim.core.volume import LabelMap
from mammosim.xray.attenuation import Material, linear_attenuation, material
from mammosim.xray.detector import expose, template_sum
from mammosim.xray.geometry import Detector, Geometry
from mammosim.xray.observer import Detectability, detectability, expected_d
from mammosim.xray.phantom import Phantom
from mammosim.xray.projector import Primary, path_lengths, primary
from mammosim.xray.response import Response
from mammosim.xray.spectrum import Spectrum

SAMPLES = 4  # rays per pixel and axis through the balls


@dataclass(frozen=True)
class Cluster:
    """Balls of one diameter; centres (n, 2) mm in a plane parallel to the detector, around their middle.

    Raises XrayError for no ball, or a diameter that is none of a microcalcification.
    """

    centres: np.ndarray
    diameter_mm: float

    def __post_init__(self) -> None:
        if len(self.centres) < 1 or not 0 < self.diameter_mm <= 1:
            raise XrayError(
                f"{len(self.centres)} balls of {self.diameter_mm:g} mm: a cluster has some, of 0.1 to 1 mm"
            )

    @classmethod
    def sampled(
        cls, count: int, *, width_mm: float, diameter_mm: float, rng: np.random.Generator
    ) -> "Cluster":
        """Centres evenly in a square of this width."""
        return cls(width_mm * (rng.random((count, 2)) - 0.5), diameter_mm)

    def chords(self, places: np.ndarray) -> np.ndarray:
        """t (...,) mm of all balls together, along rays across the plane at places (..., 2) mm."""
        rho2 = np.sum((places[..., None, :] - self.centres) ** 2, axis=-1)
        found: np.ndarray = 2 * np.sqrt(np.maximum((self.diameter_mm / 2) ** 2 - rho2, 0.0)).sum(axis=-1)
        return found


@dataclass(frozen=True)
class Place:
    """Where a cluster lies: a point (3,) mm in a breast, the tissue there, and what balls consist of."""

    point: np.ndarray
    tissue: Material
    balls: Material


def patch_behind(place: Place, geometry: Geometry, *, pixels: int, pixel_mm: float) -> Geometry:
    """The same source over a small detector around the shadow of the place, in the plane of the other."""
    d = geometry.detector
    ((s, t),) = geometry.project(place.point[None])
    corner = d.corner + (s - pixels * pixel_mm / 2) * d.u + (t - pixels * pixel_mm / 2) * d.v
    origin = corner + pixel_mm / 2 * (d.u + d.v)
    return replace(geometry, detector=Detector(origin, d.u, d.v, (pixels, pixels), pixel_mm))


def with_cluster(
    without: Primary,
    cluster: Cluster,
    place: Place,
    *,
    patch: Geometry,
    beam: tuple[np.ndarray, np.ndarray, np.ndarray],
) -> Primary:
    """The image `without` of a patch with the cluster in its place.

    beam: energies (n,) keV, and of each what its photons and their squares add to the signal there.
    """
    E, first, second = beam
    places = _in_plane(place, patch)
    d_mu = linear_attenuation(place.balls, E) - linear_attenuation(place.tissue, E)
    passed = np.exp(-cluster.chords(places)[..., None] * d_mu)
    signal, squared = ((passed @ weights / weights.sum()).mean(axis=(1, 3)) for weights in (first, second))
    return replace(without, signal=without.signal * signal, signal_squared=without.signal_squared * squared)


def beam_behind(
    phantom: Phantom, place: Place, geometry: Geometry, spectrum: Spectrum, response: Response | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The beam of with_cluster behind the place in a phantom."""
    ray = patch_behind(place, geometry, pixels=1, pixel_mm=geometry.detector.pixel_mm)
    E = spectrum.energies_kev
    mu = np.array([linear_attenuation(m, E) for m in phantom.materials])
    passed = spectrum.fluence * np.exp(-path_lengths(phantom, ray)[0, 0] @ mu)
    first, second = (E, E**2) if response is None else response.moments(E)
    return E, passed * first, passed * second


def cluster_detectability(
    images: tuple[Primary, Primary], patch: View, *, mas: float, count: int, rng: np.random.Generator
) -> tuple[float, Detectability, float]:
    """d' of a non-prewhitening observer, as `count` exposures each tell it, and CNR of the strongest pixel.

    images: with and without the cluster. Raises XrayError when no effect makes noise.
    """
    pixel_mm, effects = patch.geometry.detector.pixel_mm, patch.chain.steps
    shots = [
        [
            expose(image, patch.scatter_seen, mas=mas, pixel_mm=pixel_mm, rng=rng, steps=effects)
            for _ in range(count)
        ]
        for image in images
    ]
    present, absent = (row[0] for row in shots)
    difference = present.mean - absent.mean
    if not np.all(absent.noise > 0):
        raise XrayError("without noise everything is seen; add quantum_noise to the effects")
    with_it, without = (np.array([shot.image for shot in row]) for row in shots)
    seen = detectability(with_it, without, difference[None])
    sums = [
        template_sum(difference, image, patch.scatter_seen, mas=mas, pixel_mm=pixel_mm, steps=effects)
        for image in images
    ]
    return expected_d(*sums), seen, float(np.max(np.abs(difference) / absent.noise))


def _in_plane(place: Place, patch: Geometry) -> np.ndarray:
    """Where rays to the sampled pixels cross the plane of the place: (nv, S, nu, S, 2) mm from it."""
    d, nodes = patch.detector, (np.arange(SAMPLES) + 0.5) / SAMPLES
    rows, columns = (d.pixel_mm * (np.arange(n)[:, None] + nodes) for n in d.shape)
    ((s, t),) = patch.project(place.point[None])
    height = float((place.point - d.origin) @ d.normal)
    nearer = (patch.source_height_mm - height) / patch.source_height_mm
    v, u = np.broadcast_arrays(rows[:, :, None, None] - t, columns[None, None] - s)
    return nearer * np.stack([u, v], axis=-1)


@dataclass(frozen=True)
class SearchSettings:
    """`xray.calcifications`: balls in a square, the pixels, and how many images with and without them."""

    count: int
    diameter_mm: float
    width_mm: float
    pixel_mm: float
    images: int

    def __post_init__(self) -> None:
        require_positive(self, "count", "diameter_mm", "width_mm", "pixel_mm", "images")


@dataclass(frozen=True)
class Search:
    """A cluster, and the patch where it is looked for: pixels of pixel_mm, `images` with and without it."""

    cluster: Cluster
    pixels: int
    pixel_mm: float
    images: int

    @classmethod
    def sampled(cls, settings: SearchSettings, *, rng: np.random.Generator) -> "Search":
        """For a cluster of `count` balls in a square of width_mm, on a patch of twice that width."""
        width, pixel = settings.width_mm, settings.pixel_mm
        cluster = Cluster.sampled(settings.count, width_mm=width, diameter_mm=settings.diameter_mm, rng=rng)
        return cls(cluster, round(2 * width / pixel), pixel, settings.images)


def cluster_row(
    labels: LabelMap, view: View, search: Search, *, mas: float, rng: np.random.Generator
) -> dict[str, float]:
    """How a cluster shows in place of the lesion.

    calcification_cnr; calcification_d_expected, d'; calcification_d, as so many images tell it, with 95 %.

    Raises XrayError as cluster_detectability, and when there is no lesion.
    """
    # ASSUME: the cluster lies in gland, in the middle of where the lesion is, all balls at one height.
    inside = np.argwhere(labels.values == Label.LESION).astype(float)
    if len(inside) == 0:
        raise XrayError("no voxel is lesion, so that the cluster has no place; insert a lesion first")
    gland = tissue_materials()[Label.GLANDULAR]
    place = Place(labels.grid.points(inside).mean(axis=0), gland, material("calcium_oxalate"))
    phantom = xray_phantom(healthy(labels))
    patch = view.on(patch_behind(place, view.geometry, pixels=search.pixels, pixel_mm=search.pixel_mm))
    response = patch.chain.response
    without = primary(phantom, patch.geometry, view.spectrum, response=response, supersampling=view.rays)
    beam = beam_behind(phantom, place, view.geometry, view.spectrum, response)
    with_it = with_cluster(without, search.cluster, place, patch=patch.geometry, beam=beam)
    expected, seen, cnr = cluster_detectability(
        (with_it, without), patch, mas=mas, count=search.images, rng=rng
    )
    return {
        "calcification_cnr": cnr,
        "calcification_d_expected": expected,
        "calcification_d": seen.d,
        "calcification_d_low": seen.low,
        "calcification_d_high": seen.high,
    }
