"""The picture of the stages in the documentation is that of the table."""

import importlib.util


def test_the_picture_is_that_of_the_table_and_every_decision_is_in_the_index(repository):
    place = repository / "tools/draw_stages.py"
    spec = importlib.util.spec_from_file_location("draw_stages", place)
    tool = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tool)
    page = (repository / "docs/architecture.md").read_text()
    assert tool.drawn(page) == page, "run: python tools/draw_stages.py"
    notes = {path.stem for path in (repository / "docs/decisions").glob("*.md")}
    assert {name for name in notes if f"(decisions/{name}.md)" not in page} == set()
