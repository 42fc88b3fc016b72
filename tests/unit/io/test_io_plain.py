"""Plain tables and nested values, as a start of the workflow reads them."""

from mammosim.io.plain import not_finite, read_plain, repeated


def test_rows_are_text_and_comments_are_left_out(tmp_path):
    (tmp_path / "a.tsv").write_text(
        "\ufeffname\tmm\n# from somewhere\n007\t# not measured\n", encoding="utf-8"
    )
    (tmp_path / "b.csv").write_text('name, mm\n"a, b", 1.5\n')
    assert read_plain(tmp_path / "a.tsv") == [{"name": "007", "mm": ""}]
    assert read_plain(tmp_path / "b.csv") == [{"name": "a, b", "mm": "1.5"}]


def test_numbers_that_are_not_finite_are_named_by_where_they_are():
    values = {"mesh": {"mm": float("nan"), "n": 3}, "list": [1.0, float("inf")], "word": "nan"}
    assert not_finite(values) == ["mesh.mm", "list[1]"]


def test_what_stands_twice_is_named_once():
    assert repeated(["a", "b", "a", "a"]) == ["a"]
