"""What a file depends on, here and beyond: an edit, or another version, reruns what depends on it."""

import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path

IMPORT = re.compile(
    r"^[ \t]*(?:from[ \t]+(?P<module>mammosim[\w.]*)[ \t]+import[ \t]+(?P<names>\([^)]*\)|[^\n#]+)"
    r"|import[ \t]+(?P<whole>mammosim[\w.]+))",
    re.MULTILINE,
)
TABLE = re.compile(r"\btabulated(?:_plain)?\(\s*[\"'](\w+)[\"']")
TEMPLATE = re.compile(r"\btemplate\(\s*[\"']([\w.]+)[\"']")
BESIDE = re.compile(r"^(?:import|from)[ \t]+(\w+)", re.MULTILINE)
ANY_IMPORT = re.compile(r"^[ \t]*(?:from|import)[ \t]+([A-Za-z]\w*)(?=[. \t\n])[^\n]*", re.MULTILINE)
LOCKED = re.compile(r"^([\w.-]+)==([^\s;\\]+)", re.MULTILINE)
# What is imported by another name than it is installed by, and what computes behind it.
INSTALLED_AS = {
    "PIL": ("pillow",),
    "SimpleITK": ("simpleitk",),
    "arro3": ("arro3-core", "arro3-io"),
    "matplotlib": ("matplotlib", "pillow"),
    "numba": ("numba", "llvmlite"),
    "pypardiso": ("pypardiso", "mkl"),
    "skfem": ("scikit-fem",),
    "skimage": ("scikit-image",),
    "sklearn": ("scikit-learn",),
    "yaml": ("pyyaml",),
}
NAME = re.compile(r"\w+(?:[ \t]+as[ \t]+\w+)?")


@dataclass(frozen=True)
class Sources:
    """The files below a folder `src`, each read once.

    left_out: files that nothing is said to depend on; versions: of installed packages by name.
    """

    src: Path
    left_out: frozenset[Path] = frozenset()
    versions: Mapping[str, str] = field(default_factory=dict)
    _read: dict[Path, tuple[tuple[Path, ...], bytes, frozenset[str]]] = field(default_factory=dict)

    @property
    def package(self) -> Path:
        """The folder of the package."""
        return self.src / "mammosim"

    def digest(self, files: Iterable[Path]) -> str:
        """16 hex digits of these files and all that they depend on, wherever they lie."""
        files, found = set(files), sha256()
        every = sorted(files | set(self.dependencies(files)))
        for path in every:
            found.update(path.name.encode() + self.read(path)[1])
        for name in sorted(frozenset().union(*(self.read(path)[2] for path in every))):
            if name in self.versions:
                found.update(f"{name}=={self.versions[name]}".encode())
        return found.hexdigest()[:16]

    def dependencies(self, files: Iterable[Path]) -> list[Path]:
        """Every file that these depend on, directly or not; those of the package themselves included."""
        open_files = list(files)
        found = {path for path in open_files if self.package in path.parents}
        while open_files:
            for path in self.read(open_files.pop())[0]:
                if path not in found and path not in self.left_out:
                    found.add(path)
                    open_files.append(path)
        return sorted(found)

    def read(self, file: Path) -> tuple[tuple[Path, ...], bytes, frozenset[str]]:
        """Files that one file names, a digest of its content, and other packages that it imports."""
        if file not in self._read:
            content = file.read_bytes()
            text = content.decode() if file.suffix == ".py" else ""
            self._read[file] = (self._named(text, file.parent), sha256(content).digest(), installed(text))
        return self._read[file]

    def _named(self, text: str, folder: Path) -> tuple[Path, ...]:
        modules = [self.src / Path(*name.split(".")) for name in dict.fromkeys(imported(text))]
        found = [path for module in modules for path in (module.with_suffix(".py"), module / "__init__.py")]
        if self.package not in (folder, *folder.parents):
            found += [folder / f"{name}.py" for name in BESIDE.findall(text)]  # what scripts share
        found += [self.package / "io" / "data" / f"{name}.csv" for name in tables(text)]
        found += [self.package / "study" / "report" / "templates" / name for name in templates(text)]
        return tuple(path for path in found if path.exists())


def installed(text: str) -> frozenset[str]:
    """Names of the packages, of others, that it imports and that compute behind those."""
    names = {name for name in ANY_IMPORT.findall(text) if name not in sys.stdlib_module_names}
    return frozenset(each for name in names for each in INSTALLED_AS.get(name, (name.lower(),)))


def locked(text: str) -> dict[str, str]:
    """Versions by name of the text of a lock; of a package with several, by platform, all of them."""
    found: dict[str, list[str]] = {}
    for name, version in LOCKED.findall(text):
        found.setdefault(name, []).append(version)
    return {name: " ".join(versions) for name, versions in found.items()}


def imported(text: str) -> Iterator[str]:
    """Dotted names that may be modules: of every import of the package, `from a import b` as a and a.b."""
    for found in IMPORT.finditer(text):
        if found["whole"]:
            yield found["whole"]
            continue
        yield found["module"]
        names = re.sub(r"#[^\n]*", "", found["names"])
        yield from (f"{found['module']}.{name.group().split()[0]}" for name in NAME.finditer(names))


def tables(text: str) -> list[str]:
    """Names of the tables of io/data that it reads with tabulated('name') or tabulated_plain('name')."""
    return TABLE.findall(text)


def templates(text: str) -> list[str]:
    """Names of the templates that it reads with template('name')."""
    return TEMPLATE.findall(text)
