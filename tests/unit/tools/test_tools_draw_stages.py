"""Table and pictures of the stages in the documentation are those of the code."""

import importlib.util


def test_table_and_pictures_are_those_of_the_stages_and_every_decision_is_in_the_index(repository):
    place = repository / "tools/draw_stages.py"
    spec = importlib.util.spec_from_file_location("draw_stages", place)
    tool = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tool)
    page = (repository / "docs/architecture.md").read_text()
    assert tool.drawn(page) == page, "run: python tools/draw_stages.py"
    for path, content in tool.pictures().items():
        assert path.read_text() == content, f"{path.name}: run: python tools/draw_stages.py"
    index = (repository / "docs/decisions/index.md").read_text()
    notes = {path.stem for path in (repository / "docs/decisions").glob("*.md")} - {"index"}
    assert {name for name in notes if f"({name}.md)" not in index} == set()
