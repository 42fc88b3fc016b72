"""Pages in a headless Chromium, as a reader sees them: opened from a file, with WebGL by software."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome")
WEBGL = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
# What swiftshader and plotly.js say of speed.
HARMLESS = ("GPU stall", "willReadFrequently", "software WebGL")


@dataclass
class Opened:
    """A page of the browser, what it asked for, and what went wrong on it."""

    page: Any
    asked: list[str] = field(default_factory=list)
    wrong: list[str] = field(default_factory=list)

    def open(self, file: Path, *, width: int = 1200, height: int = 800) -> Any:
        """Open a file; the page of playwright."""
        self.page.set_viewport_size({"width": width, "height": height})
        self.page.goto(file.resolve().as_uri())
        return self.page

    def violations(self) -> list[str]:
        """Serious and critical faults that axe finds, with where they are."""
        from axe_playwright_python.sync_playwright import Axe

        found = Axe().run(self.page, options={"preload": False}).response["violations"]
        return [
            f"{each['id']} {node['html'][:200]} {node.get('failureSummary', '')[:300]}"
            for each in found
            for node in each["nodes"]
            if each["impact"] in ("serious", "critical")
        ]


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """One headless Chromium of the system."""
    found = next((path for name in NAMES if (path := shutil.which(name))), None)
    if found is None:
        pytest.skip(f"no {', '.join(NAMES)} here: apt-get install chromium")
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed: `make` installs it")
    with api.sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=found, args=["--no-sandbox", *WEBGL])
        yield opened
        opened.close()


@pytest.fixture
def page(browser) -> Iterator[Opened]:
    """A new page: see new_page."""
    with new_page(browser) as opened:
        yield opened


@contextmanager
def new_page(browser: Any) -> Iterator[Opened]:
    """A new page, which must ask for files only and say nothing of errors."""
    context = browser.new_context(accept_downloads=True, reduced_motion="reduce")
    opened = Opened(context.new_page())
    opened.page.on("request", lambda request: opened.asked.append(request.url))
    opened.page.on("pageerror", lambda error: opened.wrong.append(str(error)))
    opened.page.on("console", lambda said: _note(opened, said))
    yield opened
    context.close()
    beyond = [url for url in opened.asked if not url.startswith(("file:", "data:", "blob:"))]
    assert not beyond, beyond
    assert not opened.wrong, opened.wrong


def _note(opened: Opened, said: Any) -> None:
    if said.type in ("error", "warning") and not any(words in said.text for words in HARMLESS):
        opened.wrong.append(said.text)
