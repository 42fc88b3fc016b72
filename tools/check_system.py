"""Install what the environment needs of the system where that can be, else say the one line to type.

`check_system.py before` looks before the environment is built, `check_system.py after` with its own Python.
Standard library only, and readable to Pythons that are too old.
"""

from __future__ import annotations

import ctypes
import importlib.util
import os
import platform
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

# What gmsh asks for, even without a screen, as Debian and Arch Linux call it; for RPM the library is a name.
PACKAGES = {
    "libGLU.so.1": ("libglu1-mesa", "glu"),
    "libGL.so.1": ("libgl1", "libglvnd"),
    "libXcursor.so.1": ("libxcursor1", "libxcursor"),
    "libXft.so.2": ("libxft2", "libxft"),
    "libXinerama.so.1": ("libxinerama1", "libxinerama"),
    "libXfixes.so.3": ("libxfixes3", "libxfixes"),
    "libXrender.so.1": ("libxrender1", "libxrender"),
    "libfontconfig.so.1": ("libfontconfig1", "fontconfig"),
    "libgomp.so.1": ("libgomp1", "gcc-libs"),
    "ensurepip": (f"python3.{sys.version_info[1]}-venv", "python"),
    "gmsh": ("python3-gmsh", "gmsh"),
}
OLDEST_GMSH = (4, 13)
DEBIAN_MODULES = Path("/usr/lib/python3/dist-packages")
APT_GET = ["apt-get", "--quiet", "--quiet", "--yes", "--no-install-recommends", "install"]


def python_problem() -> str | None:
    """What keeps this Python from building the environment."""
    if sys.version_info < (3, 11):  # noqa: UP036, this very check is what rejects an older one
        found = ".".join(map(str, sys.version_info[:3]))
        return f"Python {found} is too old: 3.11 or newer is needed; say which with `make PYTHON=python3.12`"
    return None


def needs_gmsh() -> bool:
    """Whether gmsh comes from the system: it has no wheel for Linux on other processors than x86-64."""
    return sys.platform == "linux" and platform.machine() != "x86_64"


def system_gmsh() -> Path | None:
    """The module of the system's gmsh, Debian's or beside the Python that environments are made with."""
    beside = Path(sys.base_prefix, "lib", f"python3.{sys.version_info[1]}", "site-packages")
    found = [folder / "gmsh.py" for folder in (DEBIAN_MODULES, beside) if (folder / "gmsh.py").exists()]
    return found[0] if found else None


def missing() -> list[str]:
    """What of PACKAGES is not there."""
    found = [library for library in PACKAGES if ".so" in library and not _loads(library)]
    if importlib.util.find_spec("ensurepip") is None:
        found.append("ensurepip")
    if needs_gmsh() and system_gmsh() is None:
        found.append("gmsh")
    return found


def _loads(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


def gmsh_problem() -> str | None:
    """Whether the system's gmsh is used, and is too old."""
    module = system_gmsh() if needs_gmsh() else None
    if module is None:
        return None
    version = re.search(r'GMSH_API_VERSION = "(\d+)\.(\d+)', module.read_text(encoding="utf-8"))
    if version and tuple(map(int, version.groups())) < OLDEST_GMSH:
        found = ".".join(version.groups())
        return f"gmsh {found} ({module}) is too old: 4.13 or newer is needed, as in Debian 13"
    return None


def to_type(names: list[str]) -> str:
    """The one line that installs what is missing, by what installs packages here."""
    debian, arch = ([PACKAGES[name][i] for name in names] for i in (0, 1))
    rpm = [
        f"{name}()(64bit)" if ".so" in name else {"ensurepip": "python3"}.get(name, name) for name in names
    ]
    lines = {
        "apt-get": ["apt-get", "install", *debian],
        "dnf": ["dnf", "install", *rpm],
        "zypper": ["zypper", "install", *rpm],
        "pacman": ["pacman", "-S", *arch],
    }
    for program, line in lines.items():
        if shutil.which(program):
            return shlex.join(line if os.geteuid() == 0 else ["sudo", *line])
    return "install them with what installs packages here"


def install(names: list[str]) -> None:
    """Install what is missing, as root on Debian; elsewhere do nothing."""
    if os.geteuid() != 0 or shutil.which("apt-get") is None:
        return
    packages = [PACKAGES[name][0] for name in names]
    print(f"installing with apt-get: {' '.join(packages)}", flush=True)  # noqa: T201
    quiet = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
    for command in (["apt-get", "--quiet", "--quiet", "update"], [*APT_GET, *packages]):
        subprocess.run(command, env=quiet, check=False, stdin=subprocess.DEVNULL)


def system_problem() -> str | None:
    """What is missing of the system, after an attempt to install it, and the line to type."""
    names = missing()
    if names:
        install(names)
        names = missing()
    if names:
        return f"The system lacks {', '.join(names)}: {to_type(names)}"
    return gmsh_problem()


if __name__ == "__main__":
    problem = (python_problem() if sys.argv[1] == "before" else None) or system_problem()
    if problem:
        sys.exit(f"mammosim cannot be installed yet. {problem}")
