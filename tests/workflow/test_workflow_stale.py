"""What makes results stale, and what does not, with scripts that compute nothing."""

import os
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
import yaml
from whole_study import PARTS

TARGET = "results/images/ada/prone.nii.gz"
MADE = {"check_input: results/checked/ada_prone.csv", f"import_image: {TARGET}"}
SCRIPT = """from pathlib import Path

def never():
    import SimpleITK

Path(snakemake.output[0]).write_text("made")
"""
ROW = "volunteer\tposition\timages\tgravity\nada\tprone\tmine/prone\t0 -1 0\n"


@pytest.fixture
def hers(study, tmp_path):
    """A woman of one's own whose image was imported, by scripts that write a word."""
    there = replace(study, home=tmp_path / "home", run=tmp_path / "run")
    there.home.mkdir()
    for part in PARTS:
        copy = shutil.copytree if (study.home / part).is_dir() else shutil.copy2
        copy(study.home / part, there.home / part)
    series = there.run / "mine/prone"
    series.mkdir(parents=True)
    for number in range(3):
        (series / f"{number}.dcm").write_bytes(b"a slice %d" % number)
    (there.run / "mine/volunteers.tsv").write_text(ROW)
    settings = {"volunteers": ["ada"], "volunteer_table": "mine/volunteers.tsv"}
    (there.run / "mine/mine.yaml").write_text(yaml.safe_dump(settings))
    for name in ("check_input", "import_image"):
        (there.home / f"workflow/scripts/{name}.py").write_text(SCRIPT)
    made = there.snakemake(*asked(there))
    assert made.returncode == 0, made.stdout
    return there


def asked(study) -> list[str]:
    smoke = str(study.home / "config/smoke.yaml")
    return ["--configfile", smoke, str(study.run / "mine/mine.yaml"), "--", TARGET]


def stale(study) -> set[str]:
    return set(study.jobs(*asked(study)))


def test_a_slice_overwritten_in_place_is_another_image_whatever_its_date(hers):
    assert stale(hers) == set()
    slice_ = hers.run / "mine/prone/1.dcm"
    before, text = slice_.stat(), slice_.read_bytes()
    slice_.write_bytes(b"another")
    assert stale(hers) == MADE
    os.utime(slice_, ns=(before.st_atime_ns, before.st_mtime_ns))
    assert stale(hers) == MADE
    slice_.write_bytes(text)
    os.utime(slice_, ns=(before.st_atime_ns, before.st_mtime_ns))
    assert stale(hers) == set()


def test_what_a_system_leaves_in_a_folder_of_images_reruns_nothing(hers):
    series = hers.run / "mine/prone"
    for name in (".DS_Store", "._1.dcm", "Thumbs.db"):
        (series / name).write_bytes(b"left behind")
    assert stale(hers) == set()
    (series / "3.dcm").write_bytes(b"one more slice")
    assert stale(hers) == MADE
    (series / "3.dcm").unlink()
    assert stale(hers) == set()


def test_another_version_of_a_package_reruns_what_imports_it(hers):
    lock = hers.home / "environment.lock"
    text = lock.read_text()
    for package, jobs in {"simpleitk==": MADE, "matplotlib==": set()}.items():
        lock.write_text(text.replace(package, f"{package}9"))
        assert stale(hers) == jobs, package


def test_a_moved_checkout_reruns_nothing(hers, tmp_path):
    there = replace(hers, home=tmp_path / "ö ä/home", run=tmp_path / "ö ä/run")
    there.home.parent.mkdir()
    for old, new in ((hers.home, there.home), (hers.run, there.run)):
        shutil.move(old, new)
    assert stale(there) == set()


def test_results_without_their_records_are_said_to_be_unknown(hers):
    shutil.rmtree(hers.run / ".snakemake")
    said = hers.snakemake("--dry-run", *asked(hers)).stdout
    assert "Nothing to be done" in said
    (warning,) = (line for line in said.splitlines() if "no record" in line)
    assert str(Path("results")) in warning
    assert "--forceall" in warning


def labelled(study) -> list[str]:
    """What asks for bea's labels: her row names labels, codes, points and strokes, and no images."""
    columns = ("volunteer", "position", "labels", "codes", "fiducials", "strokes", "gravity")
    files = {"labels": "l.nii.gz", "codes": "c.csv", "fiducials": "f.csv", "strokes": "s.csv"}
    for name in files.values():
        (study.run / "mine" / name).write_bytes(b"as it was")
    values = {"volunteer": "bea", "position": "prone", "gravity": "0 -1 0"}
    values |= {column: f"mine/{name}" for column, name in files.items()}
    lines = ("\t".join(columns), "\t".join(values[column] for column in columns))
    (study.run / "mine/bea.tsv").write_text("\n".join(lines) + "\n")
    settings = {"volunteers": ["bea"], "volunteer_table": "mine/bea.tsv"}
    (study.run / "mine/bea.yaml").write_text(yaml.safe_dump(settings))
    (study.home / "workflow/scripts/stage.py").write_text(
        "from pathlib import Path\n\nfor path in snakemake.output:\n    Path(path).write_text('made')\n"
    )
    smoke = str(study.home / "config/smoke.yaml")
    target = "results/segmentation/bea/prone.nii.gz"
    return ["--configfile", smoke, str(study.run / "mine/bea.yaml"), "--", target]


def test_whatever_else_a_row_names_is_looked_at_again_when_it_is_another(hers):
    words = labelled(hers)
    made = hers.snakemake(*words)
    assert made.returncode == 0, made.stdout[-3000:]

    def rules() -> set[str]:
        return {job.split(":")[0] for job in hers.jobs(*words)}

    assert rules() == set()
    mine = hers.run / "mine"
    for name, touched in (
        ("l.nii.gz", {"check_input", "take_labels"}),
        ("c.csv", {"check_input", "take_labels"}),
        ("f.csv", {"check_input"}),
        ("s.csv", {"check_input"}),
    ):
        before = (mine / name).stat()
        (mine / name).write_bytes(b"another one")
        if name == "l.nii.gz":  # known by its content, whatever its date
            os.utime(mine / name, ns=(before.st_atime_ns, before.st_mtime_ns))
        assert touched <= rules(), name
        (mine / name).write_bytes(b"as it was")
        os.utime(mine / name, ns=(before.st_atime_ns, before.st_mtime_ns))
