"""What a file imports is found without parsing it: in the whole package the same as by the parser."""

import ast

from mammosim.study.jobs.code import imported, tables, templates


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


def test_several_lines_names_and_comments():
    text = "from mammosim.io import (\n    images,  # of voxels\n    tables as t,\n)\nimport mammosim.core\n"
    assert set(imported(text)) == {
        *("mammosim.io", "mammosim.io.images", "mammosim.io.tables", "mammosim.core")
    }


def test_tables_and_templates_are_found_by_the_names_that_are_read():
    assert tables("tabulated(\n    'dance_c')") == ["dance_c"]
    assert templates('template("page.html.j2")') == ["page.html.j2"]
