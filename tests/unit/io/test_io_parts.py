"""What a path of the table stands for: an image overwritten in place is another image."""

import os

import pytest

from mammosim.io.parts import heads, parts, recorded


@pytest.fixture
def series(tmp_path):
    folder = tmp_path / "prone"
    (folder / "deeper").mkdir(parents=True)
    for name in ("2.dcm", "1.dcm", "deeper/3.dcm"):
        (folder / name).write_bytes(b"DICM" + name.encode())
    return folder


def test_a_folder_stands_for_all_files_below_it(series):
    assert parts(str(series)) == [str(series / name) for name in ("1.dcm", "2.dcm", "deeper/3.dcm")]


LEFT_BEHIND = (".DS_Store", "._1.dcm", "deeper/Thumbs.db", "__MACOSX/._1.dcm", ".git/HEAD", "desktop.ini")


@pytest.mark.parametrize("name", LEFT_BEHIND)
def test_what_a_system_leaves_beside_the_files_is_no_part(series, name):
    before = parts(str(series)), heads(parts(str(series)))
    (series / name).parent.mkdir(exist_ok=True)
    (series / name).write_bytes(b"Bud1")
    assert (parts(str(series)), heads(parts(str(series)))) == before
    assert parts(str(series.rename(series.with_name(".hidden"))))[0].endswith("1.dcm"), "a person named it so"


@pytest.mark.parametrize(
    ("name", "header"),
    [
        ("body.mhd", "ObjectType = Image\nElementDataFile = body.raw\n"),
        ("body.mhd", "ElementDataFile = LIST\nbody.raw\n"),
        ("body.nhdr", "NRRD0004\nencoding: raw\ndata file: body.raw\n"),
        ("body.nhdr", "NRRD0004\ndatafile: LIST 2\nbody.raw\n"),
    ],
)
def test_a_header_stands_for_its_data_too(tmp_path, name, header):
    (tmp_path / "body.raw").write_bytes(b"12")
    (tmp_path / name).write_text(header)
    assert parts(str(tmp_path / name)) == [str(tmp_path / name), str(tmp_path / "body.raw")]


def test_a_file_stands_for_itself_and_what_is_not_there_for_nothing(tmp_path):
    (tmp_path / "body.mha").write_bytes(b"ElementDataFile = LOCAL\n\xff\x00")
    assert parts(str(tmp_path / "body.mha")) == [str(tmp_path / "body.mha")]
    assert parts(str(tmp_path / "nothing")) == parts("") == []


def test_another_image_has_another_digest_whatever_its_date_and_a_copy_the_same(series):
    before, first = heads(parts(str(series))), series / "1.dcm"
    text, date = first.read_bytes(), first.stat().st_mtime_ns
    for other in (text[:-1] + b"?", text + b"?"):
        first.write_bytes(other)
        os.utime(first, ns=(date, date))
        assert heads(parts(str(series))) != before
    first.write_bytes(text)
    assert heads(parts(str(series))) == before


@pytest.mark.parametrize("name", [b"br\xfcst.dcm", b"{v}.dcm", b"1\n.dcm"])
def test_a_name_that_cannot_be_recorded_is_not_and_its_content_is_known(series, name):
    """Snakemake writes names of inputs as UTF-8, a line each, and puts wildcards in the place of braces."""
    other = os.path.join(os.fsencode(series), name)
    os.rename(series / "1.dcm", other)
    files = parts(str(series))
    assert len(files) == 3
    assert recorded(files) == [str(series / "2.dcm"), str(series / "deeper/3.dcm")]
    before = heads(files)
    with open(other, "ab") as file:
        file.write(b"more")
    assert heads(parts(str(series))) != before
