"""Files that cannot be read, or that YAML would read as something else, are rejected by file and line."""

import runpy
import subprocess
import sys

import pytest

from mammosim.core.errors import ConfigurationError


@pytest.fixture(scope="module")
def read(repository):
    return runpy.run_path(str(repository / "workflow/scripts/_strict_yaml.py"))["read"]


@pytest.fixture
def written(tmp_path):
    """A function that writes bytes or text to mine.yaml."""

    def write(content: bytes | str, name: str = "mine.yaml"):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


def test_numbers_are_those_of_yaml_1_2(read, written):
    numbers = "[2e-1, 1e1, 1E+3, -.5e2, .5, 5., 1.0e-8, -3, 0, 0.5, 100_000]"
    found = read(written(f"a: {numbers}\nb: ['1e1', e1, 1e, 1.2.3, made_01]\n"))
    assert found["a"] == [0.2, 10.0, 1000.0, -50.0, 0.5, 5.0, 1e-8, -3, 0, 0.5, 100000]
    assert found["b"] == ["1e1", "e1", "1e", "1.2.3", "made_01"]


@pytest.mark.parametrize("text", [b"\xef\xbb\xbfseed: 1\nmesh: {a: 2}\n", b"seed: 1\r\nmesh:\r\n  a: 2\r\n"])
def test_a_mark_of_utf8_and_line_ends_of_windows_change_nothing(read, written, text):
    assert read(written(text)) == {"seed": 1, "mesh": {"a": 2}}


def test_anchors_and_merged_keys_are_read_and_may_be_overridden(read, written):
    found = read(written("a: &a {x: 1, y: 2}\nb: {<<: *a, y: 3}\nc: [&n 4.0, *n]\n"))
    assert found == {"a": {"x": 1, "y": 2}, "b": {"x": 1, "y": 3}, "c": [4.0, 4.0]}


def test_json_is_read_whatever_its_indentation(read, written):
    for mark in ("", "\ufeff"):
        assert read(written(f'{mark}{{\n\t"seed": 1\n}}\n', "mine.json")) == {"seed": 1}
    with pytest.raises(ConfigurationError, match=r"mine\.json, line 2: .* this is no JSON"):
        read(written('{\n\t"seed": ,\n}\n', "mine.json"))


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("xray:\n\tpeak_kv: 27.0\n", "mine.yaml, line 2: a tab; indent by blanks"),
        ("xray:\n  peak_kv: 27.0\n \tgrid: 3\n", "mine.yaml, line 3: a tab; indent by blanks"),
        (b"\x00\x01\x02", "mine.yaml, line 1: character 0x00: this is a binary file; give one of YAML"),
        (b"seed: 1\n\x89PNG\r\n\x1a\n", "mine.yaml, line 2: byte 0x89 is no UTF-8; save it as UTF-8"),
        ("seed: 1\n".encode("utf-16"), "mine.yaml, line 1: this is UTF-16; save it as UTF-8"),
        (
            "seed: 1\nxray: {a: 1}\nxray: {a: 2}\n",
            "line 3: 'xray' is given twice, in lines 2 and 3; keep one",
        ),
        ("a: {b: 1, b: 2}\n", "line 1: 'b' is given twice, in lines 1 and 1; keep one"),
        ("a: {no: 1}\n", "line 1: the key no is no text; put it in quotes"),
        ("a:\n  007: 45\n", "line 2: the key 007 is no text; put it in quotes"),
        ("a:\n  [1, 2]: 45\n", "line 2: the key that begins here is no text"),
        ("seed: 010\n", "line 1: 010 is read in another base; write a decimal number, or text in quotes"),
        ("seed: 1:30\n", "line 1: 1:30 is read in another base"),
        ("a: 1\nb: {c: [1, 2\nd: 3\n", "while parsing a flow sequence that begins in line 2"),
        ("a: 1\n b: 2\n", "mine.yaml, line 2: mapping values are not allowed"),
        ("a: 1\n---\nb: 2\n", "mine.yaml, line 2: but found another document"),
        ("a: *none\n", "mine.yaml, line 1: found undefined alias"),
        ("a: &a [1, *a]\n", "mine.yaml, line 1: what begins here holds itself; write it out"),
        ("a: &a {b: *a}\n", "mine.yaml, line 1: what begins here holds itself"),
        (
            "a: 2024-13-45\n",
            "line 1: 2024-13-45 is no timestamp that can be read; correct it, or put it in quotes",
        ),
        ("a: 1\nb: !!int abc\n", "line 2: abc is no int that can be read"),
        ("a: !!bool 5\n", "line 1: 5 is no bool that can be read"),
        (
            "a: " + "9" * 5000 + "\n",
            "line 1: 9999999999999999999999999999999999999... is no int that can be read",
        ),
        ("a: " + "[" * 1500 + "]" * 1500 + "\n", "mine.yaml: lists in lists, too many to be read"),
        ("a: !!python/name:os.system x\n", "mine.yaml, line 1: could not determine a constructor"),
    ],
)
def test_what_cannot_be_read_is_named_by_file_line_and_cause(read, written, content, words):
    path = written(content)
    with pytest.raises(ConfigurationError) as error:
        read(path)
    assert str(error.value).startswith(str(path))
    assert words in str(error.value)
    assert "\n" not in str(error.value)


def test_a_key_of_json_stands_once(read, written):
    with pytest.raises(ConfigurationError, match=r"mine\.json: 'b' is given twice; correct it"):
        read(written('{"a": {"b": 1, "b": 2}}', "mine.json"))


def test_a_folder_and_a_missing_file_are_named(read, tmp_path):
    for path in (tmp_path, tmp_path / "none.yaml"):
        with pytest.raises(ConfigurationError, match=f"{path.name} cannot be read: .*; give a file of YAML"):
            read(path)


def test_the_tool_names_file_and_line_of_what_snakemake_cannot_read(repository, written):
    def told(content: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, str(repository / "tools/check_config.py"), str(written(content))]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    assert "mine.yaml, line 2: a tab" in told("xray:\n\tpeak_kv: 27.0\n").stderr
    assert "mine.yaml has no keys" in told("").stderr
    assert "mine.yaml has no keys" in told("- seed: 1\n").stderr
    two = told("propagation: {draws: 3, pressed: 6}\nxray: {peak_kv: 2e2}\n")
    assert two.returncode == 1
    assert "mine.yaml: propagation.pressed = 6: must be less than propagation.draws = 3" in two.stderr
    assert "mine.yaml: xray.peak_kv = 200.0: must be a number from 20 to 40" in two.stderr
    good = told("xray: {peak_kv: 3e1}\n")
    assert good.returncode == 0, good.stderr
    assert "nothing to correct" in good.stdout


def test_every_file_of_settings_of_the_study_can_be_read(read, repository):
    folders = ("config", "workflow/schemas", "workflow/report")
    files = [path for folder in folders for path in sorted((repository / folder).rglob("*.yaml"))]
    assert len(files) > 30
    assert all(isinstance(read(path), dict) for path in files)


@pytest.mark.parametrize(
    "words",
    [
        ["--configfile", "none.yaml"],
        ["--configfile", "{smoke}", "results/x.csv"],
        ["--configfiles=none.yaml"],
    ],
)
def test_a_file_of_settings_that_is_not_there_is_said_in_one_line(repository, tmp_path, words):
    """Also a target that is taken for one, since `--` is left out."""
    result = begun(repository, tmp_path, *words)
    assert result.returncode == 1
    said = [
        line for line in result.stderr.splitlines() if not line.startswith("Using workflow specific profile")
    ]
    (line,) = said
    assert "there is no such file in" in line
    assert "write -- before it" in line


def test_files_of_settings_that_are_there_are_read(repository, tmp_path):
    result = begun(repository, tmp_path, "--configfile", "{smoke}", "--", "results/xray/spectrum.csv")
    assert result.returncode == 0, result.stderr


def begun(repository, folder, *words: str) -> subprocess.CompletedProcess[str]:
    """A dry run in a folder, with the profile that is loaded by itself; {smoke}: the smoke configuration."""
    words = [word.format(smoke=repository / "config/smoke.yaml") for word in words]
    snakemake = [
        sys.executable,
        "-m",
        "snakemake",
        "--snakefile",
        str(repository / "workflow/Snakefile"),
        "-n",
    ]
    return subprocess.run([*snakemake, *words], cwd=folder, text=True, capture_output=True, check=False)
