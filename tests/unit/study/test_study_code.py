"""What a file imports is found without parsing it: in the whole package the same as by the parser."""

import ast
import shutil

import pytest

from mammosim.study.jobs.code import Sources, imported, installed, locked, tables, templates


def parsed(text):
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "mammosim":
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name.split(".")[0] == "mammosim")


def test_every_import_of_the_package_is_found_as_the_parser_finds_it(repository):
    files = [*(repository / "src").rglob("*.py"), *(repository / "workflow/scripts").rglob("*.py")]
    assert len(files) > 300
    for file in files:
        text = file.read_text()
        assert set(imported(text)) == set(parsed(text)), file


PEERS = {"dolfinx", "felupe", "gecatsim", "itk", "mpi4py", "netgen", "ngsolve", "petsc4py", "ufl", "basix"}


def test_every_package_that_is_imported_is_in_the_lock(repository):
    """But for those of other programs, which are in a lock of their own; words of a text are no imports."""
    versions = locked((repository / "environment.lock").read_text())
    files = [*(repository / "src").rglob("*.py"), *(repository / "workflow/scripts").rglob("*.py")]
    for file in files:
        tree = ast.walk(ast.parse(file.read_text()))
        named = {
            name.split(".")[0]
            for node in tree
            for name in (
                [node.module or ""] if isinstance(node, ast.ImportFrom)
                else [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            )
        }  # fmt: skip
        others = {name for name in named if name.isidentifier() and name[0] != "_"} - PEERS - {"mammosim"}
        others = {name for name in others if not (file.parent / f"{name}.py").exists()}
        text = "".join(f"import {name}\n" for name in others)
        assert installed(text) <= set(versions), file
        assert installed(text) <= installed(file.read_text()), file


def test_another_version_of_a_package_counts_for_what_imports_it_and_for_nothing_else(sources):
    package = sources.package
    (package / "b.py").write_text("def solve():\n    import skfem.helpers\n")

    def digests(text):
        known = Sources(sources.src, sources.left_out, locked(text))
        return [known.digest([package / name]) for name in ("a.py", "c.py")]

    text = "numpy==2.4 ; python_version < '3.12' \\\n    --hash=sha256:1\nscikit-fem==12.0 \\\n"
    before = digests(text)
    assert digests(text.replace("2.4", "2.5")) == before
    renewed = digests(text.replace("12.0", "12.1"))
    assert renewed[0] != before[0]
    assert renewed[1] == before[1]


def test_a_job_that_makes_no_picture_does_not_depend_on_what_draws_them(repository):
    """It may have to write a notice in the place of one."""
    sources, scripts = Sources(repository / "src"), repository / "workflow/scripts"

    def packages(name):
        script = scripts / name
        return {each for path in (script, *sources.dependencies([script])) for each in sources.read(path)[2]}

    assert "numpy" in packages("stage.py")
    assert {"matplotlib", "pillow"}.isdisjoint(packages("stage.py"))
    assert "pillow" in packages("figure.py")


def test_several_lines_names_and_comments():
    text = "from mammosim.io import (\n    images,  # of voxels\n    tables as t,\n)\nimport mammosim.core\n"
    assert set(imported(text)) == {
        *("mammosim.io", "mammosim.io.images", "mammosim.io.tables", "mammosim.core")
    }


def test_tables_and_templates_are_found_by_the_names_that_are_read():
    assert tables("tabulated(\n    'dance_c')") == ["dance_c"]
    assert templates('template("page.html.j2")') == ["page.html.j2"]


@pytest.fixture
def sources(tmp_path):
    """A package of four files: a imports b, b reads a table; nobody needs c, and the index is left out."""
    package = tmp_path / "here/src/mammosim"
    (package / "io/data").mkdir(parents=True)
    (package / "a.py").write_text("from mammosim import b, index\n")
    (package / "b.py").write_text("VALUES = tabulated('values')\n")
    (package / "c.py").write_text("")
    (package / "index.py").write_text("")
    (package / "io/data/values.csv").write_text("1\n")
    return Sources(package.parent, frozenset({package / "index.py"}))


def test_the_digest_changes_with_every_file_that_is_needed_and_with_no_other(sources):
    package = sources.package

    def digest():
        return Sources(sources.src, sources.left_out).digest([package / "a.py"])

    before = digest()
    for name, needed in {"a.py": 1, "b.py": 1, "io/data/values.csv": 1, "c.py": 0, "index.py": 0}.items():
        text = (package / name).read_text()
        (package / name).write_text(text + "# edited\n")
        assert (digest() != before) == bool(needed), name
        (package / name).write_text(text)
    assert digest() == before


def test_the_digest_does_not_depend_on_the_order_of_the_files(sources):
    """Sets of files have another order in every process."""
    files = [sources.package / name for name in ("a.py", "c.py", "b.py")]
    assert sources.digest(files) == sources.digest(reversed(files))


def test_the_digest_is_the_same_wherever_the_package_lies(sources, tmp_path):
    before = sources.digest([sources.package / "a.py"])
    moved = shutil.move(tmp_path / "here", tmp_path / "there")
    there = Sources(moved / "src", frozenset({moved / "src/mammosim/index.py"}))
    assert there.digest([there.package / "a.py"]) == before


def test_all_that_is_depended_on_is_named_with_the_file_itself_and_no_file_twice(sources):
    package = sources.package
    (package / "b.py").write_text("from mammosim import a\nVALUES = tabulated('values')\n")  # a circle
    needed = [package / name for name in ("a.py", "b.py", "io/data/values.csv")]
    assert sources.dependencies([package / "a.py"]) == needed
    assert sources.dependencies([package / "c.py"]) == [package / "c.py"]


def test_a_script_outside_the_package_counts_with_what_it_imports(sources):
    script = sources.src / "script.py"
    digests = set()
    for text in ("from mammosim import a\n", "from mammosim import a\n# edited\n", "import mammosim.c\n"):
        script.write_text(text)
        digests.add(Sources(sources.src, sources.left_out).digest([script]))
    (sources.package / "c.py").write_text("# edited\n")
    digests.add(Sources(sources.src, sources.left_out).digest([script]))
    assert len(digests) == 4


def test_a_script_counts_with_those_beside_it_that_it_imports(sources, repository):
    """They name the columns of its tables, and what stands in the place of an output that is missing."""
    script = sources.src / "script.py"
    script.write_text("import _stage\nfrom check import Asked\nimport numpy as np\n")
    (sources.src / "_stage.py").write_text("import _log\n")
    digests = set()
    for text in ("", "# edited\n"):
        for name in ("_log.py", "check.py"):
            (sources.src / name).write_text(text)
            digests.add(Sources(sources.src).digest([script]))
    assert len(digests) == 4
    folder = repository / "workflow/scripts"
    found = Sources(repository / "src").read(folder / "table.py")[0]
    assert folder / "_stage.py" in found


def test_a_package_that_is_a_folder_is_what_its_own_file_says(sources):
    folder = sources.package / "parts"
    folder.mkdir()
    (folder / "__init__.py").write_text("from mammosim import c\n")
    (sources.package / "c.py").write_text("from mammosim import parts\n")
    assert sources.dependencies([sources.package / "c.py"]) == [
        sources.package / "c.py",
        folder / "__init__.py",
    ]


def test_every_table_and_template_of_the_package_is_known_to_be_read(repository):
    """Some tables are the references of tests alone."""
    sources = Sources(repository / "src")
    files = (file for folder in ("src", "workflow", "tests") for file in (repository / folder).rglob("*.py"))
    found = {path for file in files for path in sources.read(file)[0]}
    kept = [
        *(sources.package / "io/data").glob("*.csv"),
        *(sources.package / "study/report/templates").iterdir(),
    ]
    assert len(kept) > 15
    assert set(kept) - found == set()
