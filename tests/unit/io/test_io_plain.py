"""Plain tables and nested values, as a start of the workflow reads them."""

import pytest

from mammosim.core.errors import ConfigurationError
from mammosim.io.plain import read_plain, repeated


def test_rows_are_text_and_comments_are_left_out(tmp_path):
    (tmp_path / "a.tsv").write_text(
        "\ufeffname\tmm\n# from somewhere\n007\t# not measured\n", encoding="utf-8"
    )
    (tmp_path / "b.csv").write_text('name, mm\n"a, b", 1.5\n')
    assert read_plain(tmp_path / "a.tsv") == [{"name": "007", "mm": ""}]
    assert read_plain(tmp_path / "b.csv") == [{"name": "a, b", "mm": "1.5"}]


def test_a_table_that_is_not_there_or_is_no_text_is_named(tmp_path):
    with pytest.raises(ConfigurationError, match=r"none\.tsv cannot be read: No such file"):
        read_plain(tmp_path / "none.tsv")
    (tmp_path / "latin.tsv").write_bytes(b"name\nJos\xe9\n")
    with pytest.raises(ConfigurationError, match=r"latin\.tsv: byte 0xe9 is no UTF-8"):
        read_plain(tmp_path / "latin.tsv")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", r"my\.tsv is empty, 0 bytes; its first line names the columns"),
        ("a\tb\tc\nada\tprone\n", r"my\.tsv: row 1 \(ada prone\) has 2 of 3 cells; separate them by tabs"),
        ("a\tb\n1\t2\n1\t2\t3\n", r"row 2 \(1 2\) has 3 of 2 cells"),
        ('a\tb\n1\t"2\n3\t4\n', r"my\.tsv: unexpected end of data; close what a quotation mark opens"),
        ("a\tb\ta\n1\t2\t3\n", r"my\.tsv: column 'a' stands twice; name each column once"),
    ],
)
def test_a_table_that_is_not_well_formed_is_named(tmp_path, text, words):
    (tmp_path / "my.tsv").write_text(text)
    with pytest.raises(ConfigurationError, match=words):
        read_plain(tmp_path / "my.tsv")


def test_blanks_around_cells_and_signs_within_words_change_nothing(tmp_path):
    (tmp_path / "a.tsv").write_text("name \tpath\nada \t scans/#1 # not measured\n")
    assert read_plain(tmp_path / "a.tsv") == [{"name": "ada", "path": "scans/#1"}]
    (tmp_path / "blank.tsv").write_text("\n")
    assert read_plain(tmp_path / "blank.tsv") == []


def test_what_stands_twice_is_named_once():
    assert repeated(["a", "b", "a", "a"]) == ["a"]
