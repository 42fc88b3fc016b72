"""The documentation is built without a warning and without the network, and its links lead somewhere."""

import os
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

WORDS = 700  # of README
PICTURE_KB = 150


class Page(HTMLParser):
    """Links, loaded files, places that can be linked to, and formulas of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.loaded: list[str] = []
        self.places: set[str] = set()
        self.pictures: list[dict[str, str | None]] = []
        self.formulas = 0
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        of = dict(attrs)
        self.places |= {of[key] for key in ("id", "name") if of.get(key)}
        self.formulas += tag == "math"
        if tag == "a" and of.get("href"):
            self.links += [of["href"]]
        if tag == "img":
            self.pictures += [of]
        loaded = {"img": "src", "script": "src", "iframe": "src", "link": "href"}.get(tag)
        if loaded and of.get(loaded):
            self.loaded += [of[loaded]]


@pytest.fixture(scope="module")
def site(repository, tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "sphinx", "--quiet", "--fail-on-warning", "--keep-going"]
    command += ["--conf-dir", "docs", "--doctree-dir", str(folder / "trees"), ".", str(folder / "site")]
    ran = subprocess.run(command, cwd=repository, env=os.environ, capture_output=True, text=True, check=False)
    return ran, folder / "site"


@pytest.fixture(scope="module")
def read(site) -> dict[Path, Page]:
    folder = site[1]
    return {path: Page(path.read_text()) for path in folder.rglob("*.html")}


def test_the_site_is_built_without_a_warning(site):
    ran, folder = site
    assert ran.returncode == 0, ran.stderr
    assert (folder / "docs/index.html").exists()


def test_every_page_of_the_repository_is_in_it(site, repository):
    sources = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", "config/README.md"]
    sources += [str(path.relative_to(repository)) for path in repository.glob("docs/**/*.md")]
    assert [name for name in sources if not (site[1] / name).with_suffix(".html").exists()] == []


def test_nothing_is_loaded_from_the_network(read):
    assert len(read) > 30
    for path, page in read.items():
        assert [each for each in page.loaded if urlsplit(each).scheme or each.startswith("//")] == [], path


def test_every_link_leads_to_a_page_and_a_place_in_it(read, site):
    broken = []
    for path, page in read.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or not (parts.path or parts.fragment):
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            there = read.get(target)
            known = target.exists() and (not parts.fragment or not there or parts.fragment in there.places)
            broken += [] if known else [f"{path.relative_to(site[1])}: {link}"]
    assert broken == []


def test_formulas_are_drawn_and_every_picture_is_described(read, site):
    assert read[site[1] / "docs/theory.html"].formulas > 60
    for path, page in read.items():
        assert [each for each in page.pictures if not each.get("alt")] == [], path


def test_citations_and_public_names_are_written_in(site):
    theory = (site[1] / "docs/theory.html").read_text()
    assert "Carter 2009</span></a>" in theory
    assert 'references.html#carter2009"' in theory
    assert "@carter2009" not in theory
    interface = (site[1] / "docs/api.html").read_text()
    for name in ("ms.compress", "ms.register", "ms.TetMesh", "ms.dose_in"):
        assert name in interface


def test_readme_is_short_and_its_links_lead_to_files(repository):
    text = (repository / "README.md").read_text()
    assert len(text.split()) <= WORDS
    assert text.isascii() or "�" not in text
    for link in re.findall(r"\]\(([^)#]+)", text):
        assert link.startswith("http") or (repository / link).exists(), link


def test_the_picture_of_readme_is_small(repository):
    for path in (repository / "docs/pictures").iterdir():
        assert path.stat().st_size < 1000 * PICTURE_KB, path
