"""The verdict is a line for each volunteer, with her own page, and one whose data stop is enough to fail."""

import pytest

from mammosim.core.errors import ConfigurationError
from mammosim.io.tables import read_table, write_json


@pytest.fixture
def check(script, tmp_path, capsys):
    """Lines that are said, of volunteers with these reasons to stop."""

    def checked(**stops: list[str]) -> list[str]:
        for name, why in stops.items():
            write_json({"volunteer": name, "stops": why, "waits": False}, tmp_path / f"{name}.json")
        verdicts, pages = ([str(tmp_path / f"{name}.{end}") for name in stops] for end in ("json", "html"))
        try:
            script("check").main(verdicts, pages, str(tmp_path / "verdicts.csv"))
        finally:
            checked.said = capsys.readouterr().out.splitlines()
        return read_table(tmp_path / "verdicts.csv")["verdict"].tolist()

    return checked


def test_each_volunteer_has_a_line_with_her_page(check):
    assert check(ada=[], eva=[]) == check.said
    for name, line in zip(("ada", "eva"), check.said, strict=True):
        assert name in line
        assert f"{name}.html" in line


@pytest.mark.parametrize("stopped", ["ada", "eva"])
def test_one_whose_data_stop_fails_after_all_lines_are_said(check, stopped, tmp_path):
    why = {"ada": [], "eva": []} | {stopped: ["prone: the breast is cut off"]}
    with pytest.raises(
        ConfigurationError, match=rf"the data of {stopped} cannot be used \(1 of 2 volunteers\)"
    ):
        check(**why)
    assert len(check.said) == 2
    assert not (tmp_path / "verdicts.csv").exists()
