"""Scripts of the workflow as modules, to call what they call."""

import importlib.util
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest


@pytest.fixture
def script(repository: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], ModuleType]:
    """script(name): a script, newly loaded; `drawn.fits` is one of a folder."""
    folder = repository / "workflow/scripts"
    monkeypatch.syspath_prepend(str(folder))

    def loaded(name: str) -> ModuleType:
        place = folder.joinpath(*name.split(".")).with_suffix(".py")
        spec = importlib.util.spec_from_file_location(f"script_{name.replace('.', '_')}", place)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module

    return loaded
