"""Write the picture of the stages into docs/architecture.md, from the table itself."""

import sys
from pathlib import Path

from mammosim.chain.graph import Need
from mammosim.chain.stages import LABELLED, MEASURED, MECHANICS, STAGES, XRAY

HOME = Path(__file__).resolve().parents[1]
PAGE = HOME / "docs/architecture.md"
BEGIN, END = "<!-- drawn by tools/draw_stages.py -->\n", "<!-- end of what is drawn -->\n"
GROUPS = {"measured": MEASURED, "imaging": LABELLED, "mechanics": MECHANICS, "X-rays": XRAY}


def picture() -> str:
    """A flow chart: boxes are kept in files, rounded ones made again; dotted arrows are needed at times."""
    lines = ["```mermaid", "flowchart LR"]
    for group, stages in GROUPS.items():
        lines += [f"  subgraph {group.replace('-', '')}[{group}]"]
        for name, stage in stages.items():
            shape = "[{}]" if stage.files else "({})"
            lines += [f"    {name}{shape.format(name.replace('_', ' '))}"]
        lines += ["  end"]
    for name, stage in STAGES.items():
        for need in stage.needs:
            arrow, other = ("-.->", need.name) if isinstance(need, Need) else ("-->", need)
            lines += [f"  {other} {arrow} {name}"]
    return "\n".join([*lines, "```"]) + "\n"


def drawn(text: str) -> str:
    """The page with the picture as the table has it now."""
    before, rest = text.split(BEGIN)
    return before + BEGIN + picture() + END + rest.split(END)[1]


if __name__ == "__main__":
    page = drawn(PAGE.read_text(encoding="utf-8"))
    PAGE.write_text(page, encoding="utf-8")
    sys.stdout.write(f"{PAGE.relative_to(HOME)}: {len(STAGES)} stages\n")
