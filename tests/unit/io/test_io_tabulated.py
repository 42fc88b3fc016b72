"""Borrowed numbers come with their source, and a misspelt table is answered with the known ones."""

from pathlib import Path

import pytest

from mammosim.core.errors import ConfigurationError
from mammosim.io.tabulated import FOLDER, sources, tabulated


def _write(folder: Path) -> None:
    text = "# Source: a book, 1999.\nname,density_g_cm3\n# a remark\nwater,1.0\nfat,\n"
    (folder / "densities.csv").write_text(text)


def test_comment_lines_are_no_records(tmp_path: Path) -> None:
    _write(tmp_path)
    table = tabulated("densities", folder=tmp_path)
    assert table["name"].tolist() == ["water", "fat"]
    assert table["density_g_cm3"].isna().tolist() == [False, True]


def test_the_source_of_a_table_can_be_read(tmp_path: Path) -> None:
    _write(tmp_path)
    assert sources("densities", folder=tmp_path) == ("Source: a book, 1999.", "a remark")


def test_an_unknown_table_is_answered_with_the_known_ones(tmp_path: Path) -> None:
    _write(tmp_path)
    with pytest.raises(ConfigurationError, match=r"'densitys'.*choose one of: densities"):
        tabulated("densitys", folder=tmp_path)


@pytest.mark.parametrize("name", sorted(path.stem for path in FOLDER.glob("*.csv")))
def test_every_borrowed_table_names_its_source(name: str) -> None:
    assert sources(name)
    assert len(tabulated(name))
