"""Every command of README and of the documentation is run by a test, or its page says that none runs it."""

import ast
import subprocess
import tomllib

import pytest
from commands import MADE, PLANNED, RUN, SNAKEMAKE, UNTESTED, WHOLE_BLOCKS, commands, pages


def how(line: str) -> str:
    """The test of a command, '' where there is none."""
    if line.startswith("make ") and line.removeprefix("make ") in MADE:
        return "make -n"
    if line.startswith(SNAKEMAKE) and line.removeprefix(SNAKEMAKE) in PLANNED:
        return "dry run"
    return RUN.get(line, "")


def untested(home):
    """Page and command of all that no test runs."""
    for page in pages(home):
        name = str(page.relative_to(home))
        if name != WHOLE_BLOCKS and name not in UNTESTED:
            yield from (f"{name}: {line}" for line in commands(page) if not how(line))


def test_every_command_is_run_by_a_test(repository):
    assert list(untested(repository)) == [], "add it to tests/commands.py, and run it"


def test_what_no_test_runs_is_said_on_its_page(repository):
    for name, words in UNTESTED.items():
        page = repository / name
        assert commands(page)
        assert words in page.read_text()


def test_no_command_is_listed_that_no_page_has(repository):
    typed = {line for page in pages(repository) for line in commands(page)}
    listed = {*RUN, *(f"make {target}" for target in MADE), *(f"{SNAKEMAKE}{rest}" for rest in PLANNED)}
    assert listed - typed == set()


def test_the_tests_that_are_named_are_there(repository):
    for named in {*RUN.values(), *MADE.values()} - {""}:
        path, _, test = named.partition("::")
        tree = ast.parse((repository / path).read_text())
        found = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
        assert test in found or (not test and any(name.startswith("test_") for name in found)), named


def test_make_knows_every_target(repository, tmp_path):
    """From an environment that is there already, so that nothing of it would be built."""
    (tmp_path / "there").touch()
    for target in MADE:
        asked = ["make", "--dry-run", "--directory", str(repository), f"VENV={tmp_path}", target]
        ran = subprocess.run(asked, capture_output=True, text=True, check=False)
        assert ran.returncode == 0, ran.stderr
        assert ran.stdout


def test_packages_are_those_of_the_extras(repository):
    project = tomllib.loads((repository / "pyproject.toml").read_text())["project"]
    pinned = next(line for line in RUN if "pip install" in line).split()[-1]
    assert pinned in project["optional-dependencies"]["peers"]


@pytest.mark.parametrize("name", ["README.md", "docs/start.md"])
def test_every_command_says_how_long_it_takes(repository, name):
    """In the line, in a comment above it, or in that of a line above."""
    page = (repository / name).read_text()
    for line in commands(repository / name):
        before, _, after = page.partition(line)
        comment = after.splitlines()[0] + before[-250:]
        assert any(word in comment for word in ("min", "second", "hour")), line
