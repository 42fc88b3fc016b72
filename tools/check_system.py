"""Say which system package is missing, before and after the environment is built. Standard library only."""

import importlib.util
import sys

# Debian's package for each shared library that gmsh's wheel asks for, even without a screen.
DEBIAN_PACKAGE = {
    "libGLU.so.1": "libglu1-mesa",
    "libGL.so.1": "libgl1",
    "libXcursor.so.1": "libxcursor1",
    "libXft.so.2": "libxft2",
    "libXinerama.so.1": "libxinerama1",
    "libXfixes.so.3": "libxfixes3",
    "libXrender.so.1": "libxrender1",
    "libfontconfig.so.1": "libfontconfig1",
    "libgomp.so.1": "libgomp1",
}


def python_problem() -> str | None:
    """What keeps this Python from building the environment."""
    if sys.version_info < (3, 11):  # noqa: UP036, this very check is what rejects an older one
        found = ".".join(map(str, sys.version_info[:3]))
        return f"Python {found} is too old: 3.11 or newer is needed; say which with `make PYTHON=python3.12`"
    if importlib.util.find_spec("ensurepip") is None:
        return "Python has no venv module: apt-get install python3-venv"
    return None


def library_problem() -> str | None:
    """Which system libraries gmsh misses."""
    import ctypes

    missing = []
    for library, package in DEBIAN_PACKAGE.items():
        try:
            ctypes.CDLL(library)
        except OSError:
            missing.append(package)
    if missing:
        return f"gmsh needs system libraries that are missing: apt-get install {' '.join(missing)}"
    return None


if __name__ == "__main__":
    problem = python_problem() if sys.argv[1] == "before" else library_problem()
    if problem:
        sys.exit(f"mammosim cannot be installed yet. {problem}")
