"""Let the environment that runs this find the package in src, wherever the checkout lies."""

import sysconfig
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[1] / "src"


def line(source: Path) -> str:
    """A line of a .pth file in ASCII: Python reads such files in the encoding of the locale."""
    return f"import sys; sys.path.append({str(source)!a})\n"


if __name__ == "__main__":
    target = Path(sysconfig.get_path("purelib")) / "mammosim.pth"
    target.write_text(line(SOURCE), encoding="ascii")
