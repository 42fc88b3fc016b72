"""Write the table of stages into docs/architecture.md and draw it, from STAGES itself.

`docs/pictures/stages.svg` has every stage, `chain.svg` those of MAIN, for README. Both leave out an arrow
where others lead the same way.
"""

import ast
import sys
from collections.abc import Mapping, Sequence
from functools import cache
from html import escape
from pathlib import Path

from mammosim.chain.graph import Need
from mammosim.chain.stages import LABELLED, MEASURED, MECHANICS, STAGES, XRAY

HOME = Path(__file__).resolve().parents[1]
PAGE = HOME / "docs/architecture.md"
PICTURES = HOME / "docs/pictures"
BEGIN, END = "<!-- drawn by tools/draw_stages.py -->\n", "<!-- end of what is drawn -->\n"
GROUPS = {"measured": MEASURED, "imaging": LABELLED, "mechanics": MECHANICS, "X-rays": XRAY}
COLOURS = {"measured": "#e4e8ec", "imaging": "#d3e9f6", "mechanics": "#fbe3c4", "X-rays": "#d2ece4"}
# Column by column, what README shows, in the words of a reader.
MAIN: Sequence[Mapping[str, str]] = (
    {"scan": "MR images"},
    {"transform": "common frame", "labels": "tissues"},
    {"mesh": "mesh"},
    {"stress_free": "stress-free shape"},
    {"pressed": "compression"},
    {"phantom": "voxels"},
    {"mammogram": "mammogram, d'", "dose": "glandular dose", "slices": "tomosynthesis"},
)
SWEEPS = 12  # of ordering the rows of a column by their neighbours
BOX = (118, 26)  # pixels
Point = tuple[float, float]
SVG = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {0:.0f} {1:.0f}" width="{0:.0f}" role="img">'
HEAD = (
    '<defs><marker id="tip" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="7" markerHeight="7"'
    ' orient="auto">'
    '<path d="M0 0 8 4 0 8z" fill="#66707a"/></marker></defs><rect width="100%" height="100%" fill="#fff"/>'
    '<g font-family="Helvetica, Arial, sans-serif" font-size="12" text-anchor="middle" fill="#22272e">'
)


def needs_of(name: str) -> dict[str, bool]:
    """The products that a stage reads: name -> whether with some settings only."""
    pairs = [(need.name, True) if isinstance(need, Need) else (need, False) for need in STAGES[name].needs]
    return dict(pairs)


@cache
def before(name: str) -> frozenset[str]:
    """All products that one is made of, directly or not."""
    direct = frozenset(needs_of(name))
    return direct.union(*(before(each) for each in direct))


def makes(name: str) -> str:
    """What a stage makes: the first sentence of its function, which is read and not imported."""
    if name in MEASURED:
        return "given"
    module, function = str(STAGES[name].function).split(".")
    tree = ast.parse((HOME / f"src/mammosim/chain/{module}.py").read_text(encoding="utf-8"))
    named = {each.name: each for each in ast.walk(tree) if isinstance(each, ast.FunctionDef)}
    text = ast.get_docstring(named[function]) or ""
    return " ".join(text.split("\n\n")[0].split()).split(". ")[0].rstrip(".")


def grouped(names: Sequence[str]) -> str:
    """Dotted names of settings by their group."""
    groups: dict[str, list[str]] = {}
    for name in names:
        group, _, rest = name.rpartition(".")
        groups.setdefault(group, []).append(rest)
    return "; ".join(
        f"{group}: {', '.join(each)}" if group else ", ".join(each) for group, each in groups.items()
    )


def table() -> str:
    """A row per stage: what it makes, of which products, and which settings and effects it reads."""
    lines = ["| stage | makes | of | settings | effects |", "|---|---|---|---|---|"]
    for name, stage in STAGES.items():
        of = ", ".join(f"({other})" if at_times else other for other, at_times in needs_of(name).items())
        columns = (f"`{name}`", makes(name), of, grouped(stage.reads), ", ".join(stage.effects))
        lines += [f"| {' | '.join(columns)} |"]
    return "\n".join(lines) + "\n"


def drawn(text: str) -> str:
    """The page with the table as it is now."""
    before_it, rest = text.split(BEGIN)
    return before_it + BEGIN + "\n" + table() + "\n" + END + rest.split(END)[1]


def arrows(shown: Sequence[str]) -> list[tuple[str, str]]:
    """From stage to stage, in the given order, where no other one lies between."""
    pairs = {(a, b): 0 for k, b in enumerate(shown) for a in shown[:k] if a in before(b)}
    return [(a, b) for a, b in pairs if not any((a, c) in pairs and (c, b) in pairs for c in shown)]


def rows() -> list[list[str]]:
    """Stages by the longest way to them, those of nothing right above their use; rows by their neighbours."""
    depth: dict[str, int] = {}
    order = sorted(STAGES, key=lambda name: len(before(name)))
    for name in order:
        depth[name] = 1 + max((depth[other] for other in needs_of(name)), default=-1)
    for name in [name for name in order if not needs_of(name)]:
        depth[name] = min((depth[b] for b in STAGES if name in needs_of(b)), default=1) - 1
    found = [[name for name in order if depth[name] == k] for k in range(max(depth.values()) + 1)]
    drawn_ones = arrows(order)
    linked = {name: [a if b == name else b for a, b in drawn_ones if name in (a, b)] for name in order}
    for _ in range(SWEEPS):
        at = {name: i - (len(row) - 1) / 2 for row in found for i, name in enumerate(row)}
        middle = {name: sum(at[b] for b in linked[name]) / max(len(linked[name]), 1) for name in order}
        found = [sorted(row, key=lambda name: (round(middle[name], 6), name)) for row in found]
    return found


def box(words: str, at: Point, name: str) -> str:
    """A stage at its middle; rounded where it is not kept in files."""
    group = next(group for group, stages in GROUPS.items() if name in stages)
    radius = 3 if STAGES[name].files else BOX[1] / 2
    return (
        f'<rect x="{at[0] - BOX[0] / 2:.0f}" y="{at[1] - BOX[1] / 2:.0f}" width="{BOX[0]}" height="{BOX[1]}"'
        f' rx="{radius:.0f}" fill="{COLOURS[group]}" stroke="#8a939e"/>'
        f'<text x="{at[0]:.0f}" y="{at[1] + 4:.0f}">{escape(words)}</text>'
    )


def arrow(start: Point, end: Point, *, dotted: bool, down: bool) -> str:
    """From the edge of one box to that of another, bent as the picture runs."""
    (x0, y0), (x1, y1) = start, end
    if down:
        y0, y1 = y0 + BOX[1] / 2, y1 - BOX[1] / 2
        (x2, y2), (x3, y3) = (x0, (y0 + y1) / 2), (x1, (y0 + y1) / 2)
    else:
        x0, x1 = x0 + BOX[0] / 2, x1 - BOX[0] / 2
        (x2, y2), (x3, y3) = ((x0 + x1) / 2, y0), ((x0 + x1) / 2, y1)
    way = f"M{x0:.0f} {y0:.0f}C{x2:.0f} {y2:.0f} {x3:.0f} {y3:.0f} {x1:.0f} {y1:.0f}"
    dashes = ' stroke-dasharray="3 3"' if dotted else ""
    return f'<path d="{way}" fill="none" stroke="#66707a"{dashes} marker-end="url(#tip)"/>'


def svg(layers: Sequence[Mapping[str, str]], title: str, gap: Point, *, down: bool) -> str:
    """Layers of boxes, name -> words, from left to right or down, with gaps in x and y, pixels."""
    step, most = (BOX[0] + gap[0], BOX[1] + gap[1]), max(map(len, layers))
    across, along = (most, len(layers)) if down else (len(layers), most)
    width, height = step[0] * across, step[1] * along
    place: dict[str, Point] = {}
    for k, layer in enumerate(layers):
        for i, name in enumerate(layer):
            beside = i - (len(layer) - 1) / 2
            column, row = (beside + across / 2, k + 0.5) if down else (k + 0.5, beside + along / 2)
            place[name] = (step[0] * column, step[1] * row)
    lines = [SVG.format(width, height), f"<title>{escape(title)}</title>", HEAD]
    for a, b in arrows(list(place)):
        lines += [arrow(place[a], place[b], dotted=needs_of(b).get(a, False), down=down)]
    lines += [box(words, place[name], name) for layer in layers for name, words in layer.items()]
    return "\n".join([*lines, "</g></svg>"]) + "\n"


def pictures() -> dict[Path, str]:
    """Path -> its content, of both drawings."""
    every = [{name: name.replace("_", " ") for name in row} for row in rows()]
    return {
        PICTURES / "chain.svg": svg(
            MAIN, "From MR images to mammogram, dose and slices", (16, 12), down=False
        ),
        PICTURES / "stages.svg": svg(
            every, "Every stage of the chain, and of what it is made", (14, 24), down=True
        ),
    }


if __name__ == "__main__":
    PAGE.write_text(drawn(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
    PICTURES.mkdir(exist_ok=True)
    for path, content in pictures().items():
        path.write_text(content, encoding="utf-8")
    sys.stdout.write(f"{PAGE.relative_to(HOME)} and its pictures: {len(STAGES)} stages\n")
