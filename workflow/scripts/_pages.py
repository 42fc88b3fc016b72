"""What every page shares: figures and tables beside it, what texts may cite, and what made it."""

from collections.abc import Iterable
from datetime import UTC, datetime
from os.path import relpath
from pathlib import Path

import _strict_yaml
import pandas as pd

from mammosim import __version__
from mammosim.core.settings import read
from mammosim.io.tables import read_json
from mammosim.study.report.layout import Layout, require_sources
from mammosim.study.report.pages import Picture
from mammosim.study.report.summary import author_year, entries, made_words
from mammosim.study.report.texts import Sources


def beside(files: Iterable[str], out: str) -> dict[str, Picture]:
    """Figures by name, as a page `out` shows their files; the vector file, where there is one."""
    return {Path(file).stem: picture(Path(file), Path(out).parent) for file in files}


def picture(file: Path, home: Path) -> Picture:
    vector = file.with_suffix(".pdf")
    return Picture(
        file.read_bytes(),
        "",
        path=path_from(home, file),
        vector=path_from(home, vector) if vector.exists() else "",
    )


def csv_beside(files: Iterable[str], out: str) -> dict[str, str]:
    """Paths of tables from a page `out`, by name."""
    return {Path(file).stem: path_from(Path(out).parent, Path(file)) for file in files}


def path_from(home: Path, file: Path) -> str:
    return Path(relpath(file, home)).as_posix()


def bibliography(file: str) -> tuple[pd.DataFrame, Sources]:
    """Entries of a bibliography, and how texts cite them."""
    listed = entries(Path(file).read_text(encoding="utf-8"))
    return pd.DataFrame(listed), {each["key"]: author_year(each) for each in listed}


def layout_of(file: str, sources: Sources) -> Layout:
    """The layout that a file of workflow/report describes, which cites nothing that is not there."""
    name = Path(file).name
    layout = read(Layout, _strict_yaml.read(file, name), name)
    require_sources(layout, sources, file=name)
    return layout


def made_by(command: str) -> dict[str, str]:
    """What made a page that is made by itself."""
    return {"Date": now(), "Command": command, "Versions": f"mammosim {__version__}"}


def now() -> str:
    return f"{datetime.now(UTC):%Y-%m-%d %H:%M} UTC"


def footer(provenance: str, jobs: pd.DataFrame | None = None) -> dict[str, str]:
    """What made a page, of the file results/study/provenance.json."""
    return made_words(read_json(provenance), date=now(), jobs=jobs)
