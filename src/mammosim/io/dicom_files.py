"""The files of a folder, of a zip and of zips within, to be opened one after the other."""

import os
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

from mammosim.core.errors import ImageError
from mammosim.io.hidden import is_hidden


@dataclass(frozen=True)
class File:
    """name: its path within what was given; open: its bytes from the beginning."""

    name: str
    open: Callable[[], BinaryIO]


@contextmanager
def dicom_files(path: str | Path) -> Iterator[list[File]]:
    """All files of a folder, of a zip and of zips within, or the one file; those of io.hidden are left out.

    Raises ImageError: not there; a zip that is damaged or encrypted; a link to nothing.
    """
    path = Path(path)
    if not path.exists():
        raise ImageError(f"no folder {path}; give the folder or zip that holds the DICOM files of one series")
    with ExitStack() as stack:
        yield list(_files(path, stack))


def _files(path: Path, stack: ExitStack) -> Iterator[File]:
    for file in sorted(path.rglob("*")) if path.is_dir() else [path]:
        name = _printable(file.relative_to(path) if file != path else file.name)
        if is_hidden(name) or file.is_dir():
            continue
        if not file.is_file():
            raise ImageError(f"{path}: {name} is a link to nothing; copy the files that are linked, too")
        if file.suffix.lower() == ".zip":
            yield from _zipped(file, "" if file == path else f"{name}/", str(file), stack)
        else:
            yield File(name, _opening(file))


def _printable(name: str | Path) -> str:
    """A name as it can be written into any message or table, also where a disk has it in another encoding."""
    return os.fsencode(name).decode("utf-8", "replace")


def _opening(file: Path) -> Callable[[], BinaryIO]:
    def opened() -> BinaryIO:
        try:
            return file.open("rb")
        except OSError as error:
            raise ImageError(f"{file} cannot be read: {error.strerror}; allow it, or copy it") from None

    return opened


def _zipped(source: Path | BytesIO, prefix: str, where: str, stack: ExitStack) -> Iterator[File]:
    try:
        archive = stack.enter_context(zipfile.ZipFile(source))
    except zipfile.BadZipFile:
        raise ImageError(f"{where} is no whole zip archive; copy it again, or give what is in it") from None
    for member in sorted(archive.infolist(), key=lambda member: member.filename):
        name = prefix + member.filename
        if member.is_dir() or is_hidden(member.filename):
            continue
        unpacked = _unpacking(archive, member, where)
        if member.filename.lower().endswith(".zip"):
            yield from _zipped(unpacked(), f"{name}/", f"{where}: {member.filename}", stack)
        else:
            yield File(name, unpacked)


def _unpacking(archive: zipfile.ZipFile, member: zipfile.ZipInfo, where: str) -> Callable[[], BytesIO]:
    def unpacked() -> BytesIO:
        try:
            return BytesIO(archive.read(member))
        except RuntimeError:  # of the encrypted and of kinds of compression that zipfile lacks
            wrong = "is encrypted, or packed in a way that is not read; unpack it, and give the folder"
        except (zipfile.BadZipFile, zlib.error, EOFError):
            wrong = "does not unpack: it is damaged; copy the archive again"
        raise ImageError(f"{where}: {member.filename} {wrong}")

    return unpacked
