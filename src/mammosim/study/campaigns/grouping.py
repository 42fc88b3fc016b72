"""The points of a campaign by the job that computes them: those that share most, one after another."""

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import Any

from mammosim.chain.stages import STAGES
from mammosim.study.campaigns.points import Planned, short

BATCH = 25  # points, where a campaign has not many
BATCHES = 128  # at most, about: Snakemake plans each of them
# The kept products that points may share, each after those that it is made of.
SHARED = tuple(name for name, stage in STAGES.items() if stage.files is not None)


def stored(points: Iterable[Planned]) -> set[tuple[str, str]]:
    """(product, digest) of what more than one point is made of, and which is kept for them."""
    counted = Counter(
        (name, digest)
        for point in {point.name: point for point in points}.values()
        for name, digest in point.own.items()
        if STAGES[name].files is not None
    )
    return {each for each, number in counted.items() if number > 1}


def batches(points: Sequence[Planned]) -> dict[str, list[Planned]]:
    """The points by the job that computes them: those that share most are together, and one after another.

    A point stays in its batch when others are added, until a group has doubled.
    """
    size = max(BATCH, -(-len(points) // BATCHES))
    found: dict[str, list[Planned]] = {}
    whose: dict[tuple[str, str], list[Planned]] = {}
    for point in points:
        whose.setdefault((point.volunteer, point.side), []).append(point)
    for (volunteer, side), group in whose.items():
        for path, batch in _split(group, [], size):
            found[f"{volunteer}_{side}_{short(*path)[:8]}"] = sorted(batch, key=_path)
    return found


def _path(point: Planned) -> tuple[str, ...]:
    """What points share comes first, so that neighbours share most."""
    return (*(point.own.get(name, "") for name in SHARED), point.name)


def _split(points: list[Planned], path: list[Any], size: int) -> Iterator[tuple[list[Any], list[Planned]]]:
    """Groups of about `size`: by what they share, by hash into a number of buckets that is a power of two."""
    level = len(_common(points))
    if len(points) <= size or level == len(SHARED) + 1:
        yield path, points
        return
    groups: dict[str, list[Planned]] = {}
    for point in points:
        groups.setdefault(_path(point)[level], []).append(point)
    buckets = 1 << (-(-len(points) // size) - 1).bit_length()
    whole: dict[int, list[Planned]] = {}
    for digest, group in groups.items():
        if len(group) > size:
            yield from _split(group, [*path, digest], size)
        else:
            whole.setdefault(int(short(digest), 16) % buckets, []).extend(group)
    for number, bucket in whole.items():
        yield [*path, buckets, number], bucket


def _common(points: Sequence[Planned]) -> tuple[str, ...]:
    """The beginning of their paths that all have in common."""
    first, last = min(map(_path, points)), max(map(_path, points))
    same = next((n for n, (a, b) in enumerate(zip(first, last)) if a != b), len(first))
    return first[:same]


def parameters(batch: Sequence[Planned], shared: Collection[tuple[str, str]]) -> dict[str, Any]:
    """A batch as the plain parameters of its job: whose breast, the points, and what they read."""
    kept: list[Mapping[str, Mapping[str, str]]] = []
    points = []
    for point in batch:
        if point.kept not in kept:
            kept.append(point.kept)
        stored_here = {name: digest for name, digest in point.own.items() if (name, digest) in shared}
        values = {
            key: getattr(point, key) for key in ("name", "shown", "changes", "effects", "own", "rejected")
        }
        points.append(values | {"kept": kept.index(point.kept), "stored": stored_here})
    return {"volunteer": batch[0].volunteer, "side": batch[0].side, "points": points, "kept": kept}


def inputs(batch: Iterable[Planned]) -> list[str]:
    """The files of the study that a batch reads."""
    paths = (path for point in batch for files in point.kept.values() for path in files.values())
    return list(dict.fromkeys(paths))
