"""Let the environment that runs this find the package in src, wherever that lies, and a system's gmsh."""

import sysconfig
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[1] / "src"


def line(source: Path) -> str:
    """A line of a .pth file in ASCII: Python reads such files in the encoding of the locale."""
    return f"import sys; sys.path.append({str(source)!a})\n"


def link(module: Path, packages: Path) -> None:
    """Put one module of the system into a folder of packages, and nothing else of the system."""
    place = packages / module.name
    place.unlink(missing_ok=True)
    place.symlink_to(module)


if __name__ == "__main__":
    from check_system import needs_gmsh, system_gmsh

    packages = Path(sysconfig.get_path("purelib"))
    (packages / "mammosim.pth").write_text(line(SOURCE), encoding="ascii")
    gmsh = system_gmsh() if needs_gmsh() else None
    if gmsh is not None:
        link(gmsh, packages)
