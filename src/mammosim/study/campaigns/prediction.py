"""What a campaign will take: what its points are made of, at what each product took."""

from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from typing import Any

from mammosim.chain.conditions import YIELDING, is_standard
from mammosim.study.campaigns.points import Planned

PRESSED = "pressed"
START_S = 2.5  # seconds of a processor that a batch takes before its first point, and after its last
POINT_S = 0.3  # and each point beside its products: keys, digests, files
# The rule that makes a product, where it has another name; of several products the first stands for its time.
RULES: Mapping[str, str] = {
    "labels": "segment", "transform": "register", "mean_shape": "morph", "unloaded": "unload",
    "pressed": "compress", "slices": "tomosynthesis",
}  # fmt: skip
BY = ":"  # between the product `pressed` and what it is pressed with; no product has it in its name
RULE_START_S = 1.4  # of the seconds of a rule, what a script takes to begin


def counts(points: Iterable[Planned], strategy: Mapping[str, Any], done: Collection[str]) -> dict[str, int]:
    """How often each product is to be made, each for all points that share it.

    strategy: of the load where a point does not change it; done: names of points that are finished. A press
    is called after its paddle, `pressed:flexible`; the standard's is read off its path, `pressed:standard`.
    """
    found: dict[tuple[str, str], str] = {}
    for point in points:
        if point.rejected or point.name in done:
            continue
        kind = paddle(point.changes.get("load.strategy", strategy))
        for name, digest in point.own.items():
            found[name, digest] = f"{name}{BY}{kind}" if name == PRESSED else name
    return dict(Counter(found.values()))


def paddle(strategy: Mapping[str, Any]) -> str:
    """What a strategy presses with: 'flexible', 'tilting' or 'rigid'; 'standard' where it is that one."""
    kind = next((name for name in YIELDING if name in (strategy.get("paddle") or ())), "rigid")
    return "standard" if is_standard(strategy) else kind


def expected(
    made: Mapping[str, int],
    costs: Mapping[str, float],
    *,
    pace: float,
    points: int,
    batches: int,
    took: Mapping[str, float] | None = None,
) -> float:
    """Processor seconds of all batches.

    costs: seconds by product, `point_{product}` or `point_pressed_{paddle}`, and by rule; pace: what they are
    multiplied by for settings other than the study's; took: seconds by product, of points of this campaign
    that are finished.
    """
    seconds = START_S * batches + POINT_S * points
    for name, number in made.items():
        product, line = name.split(BY)[0], f"point_{name.replace(BY, '_')}"
        if took and name in took:
            seconds += number * took[name]
        elif line in costs:
            seconds += number * pace * costs[line]
        else:
            seconds += number * pace * max(0.0, costs.get(RULES.get(product, product), 0.0) - RULE_START_S)
    return seconds


def measured(rows: Iterable[Mapping[str, Any]], kinds: Mapping[str, str]) -> dict[str, float]:
    """Mean seconds by product of finished points; kinds: point -> what it presses with."""
    found: dict[str, list[float]] = {}
    for row in rows:
        for name, seconds in row["took"].items():
            called = f"{name}{BY}{kinds.get(row['point'], '')}" if name == PRESSED else name
            found.setdefault(called, []).append(seconds)
    return {name: sum(each) / len(each) for name, each in found.items()}
