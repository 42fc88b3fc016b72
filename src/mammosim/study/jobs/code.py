"""Which files of the package a file depends on: what is edited there reruns what depends on it."""

import re
from collections.abc import Iterable, Iterator
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
BESIDE = re.compile(r"^import[ \t]+(_\w+)$", re.MULTILINE)
NAME = re.compile(r"\w+(?:[ \t]+as[ \t]+\w+)?")


@dataclass(frozen=True)
class Sources:
    """The files below a folder `src`, each read once.

    left_out: files that nothing is said to depend on.
    """

    src: Path
    left_out: frozenset[Path] = frozenset()
    _read: dict[Path, tuple[tuple[Path, ...], bytes]] = field(default_factory=dict)

    @property
    def package(self) -> Path:
        """The folder of the package."""
        return self.src / "mammosim"

    def digest(self, files: Iterable[Path]) -> str:
        """16 hex digits of the content of these files and of all that they depend on, wherever they lie."""
        files, found = set(files), sha256()
        for path in sorted(files | set(self.dependencies(files))):
            found.update(path.name.encode() + self.read(path)[1])
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

    def read(self, file: Path) -> tuple[tuple[Path, ...], bytes]:
        """The files that one file names, of the package or beside it, and the digest of its content."""
        if file not in self._read:
            content = file.read_bytes()
            named = self._named(content.decode(), file.parent) if file.suffix == ".py" else ()
            self._read[file] = (named, sha256(content).digest())
        return self._read[file]

    def _named(self, text: str, folder: Path) -> tuple[Path, ...]:
        modules = [self.src / Path(*name.split(".")) for name in dict.fromkeys(imported(text))]
        found = [path for module in modules for path in (module.with_suffix(".py"), module / "__init__.py")]
        found += [folder / f"{name}.py" for name in BESIDE.findall(text)]  # what scripts share
        found += [self.package / "io" / "data" / f"{name}.csv" for name in tables(text)]
        found += [self.package / "study" / "report" / "templates" / name for name in templates(text)]
        return tuple(path for path in found if path.exists())


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
