"""Before a run: a page of each woman, and a line; and what config/README.md says can be done."""

import os
import re
import shlex
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pydicom
import pytest
import yaml
from tiny_woman import tiny_image, tiny_labels

from mammosim.core.labels import Label
from mammosim.core.volume import Image, LabelMap
from mammosim.io.dicom_writer import write_series
from mammosim.io.images import read_image, read_labels, write_labels

pytestmark = pytest.mark.workflow
README = Path(__file__).parents[2] / "config/README.md"
REAL = Path(__file__).parents[3] / "shared/data"


@pytest.fixture
def women(study, tmp_path):
    """Of rows of the table of volunteers, how to ask for something of them, in a folder of their own."""

    def of(*rows: dict[str, str], **settings):
        table = [{"position": "prone", "gravity": "0 -1 0"} | row for row in rows]
        pd.DataFrame(table).to_csv(tmp_path / "volunteers.tsv", sep="\t", index=False)
        names = [row["volunteer"] for row in rows]
        values = {"volunteers": names, "volunteer_table": "volunteers.tsv"} | settings
        (tmp_path / "mine.yaml").write_text(yaml.safe_dump(values))
        files = [str(study.home / "config/smoke.yaml"), str(tmp_path / "mine.yaml")]
        there = replace(study, run=tmp_path)

        def ask(*targets: str, dry: bool = False) -> subprocess.CompletedProcess[str]:
            return there.snakemake("--configfile", *files, *(["--dry-run"] if dry else []), "--", *targets)

        return ask

    return of


def labels_with(path: Path, **renamed: int) -> None:
    """Labels of the tiny woman, with other codes of some tissues."""
    labels = tiny_labels(8.0)
    values = labels.values.copy()
    for tissue, code in renamed.items():
        values[labels.values == Label[tissue]] = code
    write_labels(LabelMap(labels.grid, values), path)


def test_one_woman_who_is_rejected_hides_no_other_and_nothing_is_computed(women, tmp_path):
    labels_with(tmp_path / "ada.nii.gz")
    labels_with(tmp_path / "bea.nii.gz", GLANDULAR=50)
    result = women(
        {"volunteer": "bea", "labels": "bea.nii.gz"}, {"volunteer": "ada", "labels": "ada.nii.gz"}
    )("check")
    assert result.returncode != 0
    lines = result.stdout.splitlines()
    assert "ada: her data can be used; see results/checked/ada.html" in lines
    assert any(
        line.startswith("bea: prone: bea.nii.gz: mammosim has no tissue for code 50") for line in lines
    )
    assert "the data of bea cannot be used (1 of 2 volunteers)" in "\n".join(lines[-20:])
    pages = {name: (tmp_path / f"results/checked/{name}.html").read_text() for name in ("ada", "bea")}
    assert "has no tissue for code 50" in pages["bea"]
    assert all("data:image/png" in page for page in pages.values())
    done = {path.parent.name for path in (tmp_path / "results/benchmarks").glob("*/*.tsv")}
    assert done == {"check_page"}


def test_data_that_can_be_used_pass_and_are_looked_at_again_each_time(women, tmp_path):
    labels_with(tmp_path / "ada.nii.gz")
    check = women({"volunteer": "ada", "labels": "ada.nii.gz"})
    assert check("check").returncode == 0
    first = (tmp_path / "results/checked/ada.html").stat().st_mtime
    again = check("check")
    assert again.returncode == 0, again.stdout[-3000:]
    assert (tmp_path / "results/checked/ada.html").stat().st_mtime > first


def test_digital_women_are_not_waited_for(women):
    result = women(
        {"volunteer": "small", "images": "results/raw/small/prone", "strokes": "results/raw/small/s.csv"}
    )("check", dry=True)
    assert result.returncode == 0, result.stdout[-3000:]
    assert set(re.findall(r"^(?:local)?rule (\w+):$", result.stdout, flags=re.M)) == {"check", "check_page"}


def test_a_woman_without_a_thickness_is_planned_to_her_own_page(women, tmp_path):
    labels_with(tmp_path / "ada.nii.gz")
    ask = women({"volunteer": "ada", "labels": "ada.nii.gz"})
    result = ask("results/women/ada/what.html", dry=True)
    assert result.returncode == 0, result.stdout[-3000:]
    rules = set(re.findall(r"^(?:local)?rule (\w+):$", result.stdout, flags=re.M))
    assert {
        "check_input",
        "take_labels",
        "mesh",
        "compress",
        "dose",
        "mammogram",
        "tomosynthesis",
        "what",
    } <= rules
    assert rules.isdisjoint({"report", "table", "sweep", "upright", "identify", "trade_off"}), "of the study"
    assert "what" in set(re.findall(r"^(?:local)?rule (\w+):$", ask(dry=True).stdout, flags=re.M)), (
        "by default"
    )


def test_a_thickness_is_asked_where_none_can_be_chosen(women, tmp_path):
    labels_with(tmp_path / "ada.nii.gz")
    listed = "name,kind,x_mm,y_mm,z_mm\nnipple_left,nipple,70,-60,0\nnipple_right,nipple,-70,-60,0\n"
    (tmp_path / "list.csv").write_text(listed)
    supine = {"volunteer": "ada", "position": "supine", "gravity": "0 1 0", "labels": "ada.nii.gz"}
    result = women(supine | {"fiducials": "list.csv"})("study", dry=True)
    assert result.returncode == 0, result.stdout[-3000:]
    assert "no compression: no thickness is given for ada, which is chosen in prone only" in result.stdout


def two_series(folder: Path, image: Image) -> None:
    """Series 5 of an image, and series 7 of it twice as bright, the last three slices 4 mm further up."""
    for number, factor in ((5, 1.0), (7, 2.0)):
        series = folder / str(number)
        brighter = replace(image, values=factor * image.values)
        write_series(
            series,
            brighter,
            position="prone",
            volunteer=f"w{number}",
            echo_time_ms=4.0,
            repetition_time_ms=8.0,
        )
        for path in sorted(series.glob("*.dcm")):
            slice_ = pydicom.dcmread(path)
            slice_.SeriesNumber = number
            x, y, z = slice_.ImagePositionPatient
            late = number == 7 and z > image.grid.origin[2] + (image.grid.shape[0] - 3.5) * 8.0
            slice_.ImagePositionPatient = [x, y, z + 4.0 * late]
            slice_.save_as(path)
    os.rename(path, os.fsencode(path.parent) + b"/br\xfcst.dcm")  # a name of another encoding is no fault


def test_what_a_row_says_of_its_files_reaches_all_that_reads_them(women, tmp_path):
    """The series that is meant and its gaps, and the codes of labels: by the check and by what follows it."""
    image = tiny_image(tiny_labels(8.0))
    two_series(tmp_path / "data", image)
    labels_with(tmp_path / "bea.nii.gz", GLANDULAR=50)
    codes = {"air": 0, "adipose": 1, "glandular": 50, "muscle": 4, "thorax": 5}
    pd.DataFrame(codes.items(), columns=["tissue", "code"]).to_csv(tmp_path / "codes.csv", index=False)
    ask = women(
        {"volunteer": "ada", "images": "data", "series": "7", "gaps": "resample"},
        {"volunteer": "bea", "labels": "bea.nii.gz", "codes": "codes.csv"},
    )
    result = ask("results/images/ada/prone.nii.gz", "results/segmentation/bea/prone.nii.gz")
    assert result.returncode == 0, result.stdout[-3000:]
    read = read_image(tmp_path / "results/images/ada/prone.nii.gz")
    height = (read.grid.shape[0] - 1) * read.grid.spacing[2]
    assert height == pytest.approx((image.grid.shape[0] - 1) * 8.0 + 4.0), "even slices from end to end"
    assert np.percentile(read.values, 90) == pytest.approx(2 * np.percentile(image.values, 90), rel=0.05)
    tissues = read_labels(tmp_path / "results/segmentation/bea/prone.nii.gz").values
    assert (tissues == Label.GLANDULAR).sum() == (tiny_labels(8.0).values == Label.GLANDULAR).sum()


BLOCKS = re.findall(r"^```sh\n(.*?)^```$", README.read_text(), flags=re.M | re.S)


@pytest.mark.parametrize("block", BLOCKS, ids=[block.split()[-1] for block in BLOCKS])
def test_what_the_readme_says_can_be_planned(block, study, tmp_path):
    shutil.copytree(study.home / "config", tmp_path / "config")
    for folder in ("mine", "real/Breast_MRI_001", "real/Exam_10"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "real/Exam_10/Label_map_simple.zip").touch()
    labels = tiny_labels(8.0)
    write_labels(labels, tmp_path / "mine/labels.nii.gz")
    write_series(
        tmp_path / "mine/prone",
        tiny_image(labels),
        position="prone",
        volunteer="ada",
        echo_time_ms=70.0,
        repetition_time_ms=4500.0,
    )
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(study.home / "workflow/Snakefile")]
    command += ["--workflow-profile", "none", "--dry-run"]
    ran = subprocess.run(
        ["bash", "-e", "-c", block.replace(".venv/bin/snakemake", shlex.join(command))],
        cwd=tmp_path,
        env=os.environ,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
    )
    assert ran.returncode == 0, ran.stdout[-3000:]
    assert "This was a dry-run" in ran.stdout


@pytest.fixture
def real_women(study, tmp_path):
    """How to ask for something of config/real.yaml, in a folder without data."""
    files = [str(study.home / "config" / name) for name in ("own.yaml", "real.yaml")]
    there = replace(study, run=tmp_path)

    def ask(*targets: str, dry: bool = False) -> subprocess.CompletedProcess[str]:
        return there.snakemake("--configfile", *files, *(["--dry-run"] if dry else []), "--", *targets)

    return ask


def test_of_two_real_women_whoever_is_there_is_studied(real_women, tmp_path):
    nobody = real_women("check", dry=True)
    assert nobody.returncode != 0
    assert (
        "nobody's data are there: duke_001: no images real/Breast_MRI_001; exam_10: no labels "
        "real/Exam_10/Label_map_simple.zip; config/README.md says where to get data"
    ) in nobody.stdout
    labels = tmp_path / "real/Exam_10/Label_map_simple.zip"
    labels.parent.mkdir(parents=True)
    labels.touch()
    one = real_women("check", dry=True)
    assert one.returncode == 0, one.stdout[-3000:]
    said = "Not planned for duke_001: no study of her: images real/Breast_MRI_001 is not there."
    assert said in one.stdout.splitlines()
    assert set(re.findall(r"^check_page +(\d+)$", one.stdout, flags=re.M)) == {"1"}


@pytest.mark.data
@pytest.mark.skipif(not REAL.is_dir(), reason=f"no {REAL}: the real images are not part of the project")
def test_two_real_women_are_planned_and_checked(real_women, tmp_path):
    """A series as a scanner wrote it, and labels that somebody drew: each has her page, and passes."""
    for place, file in {
        "real/Breast_MRI_001/series.zip": "duke_breast_mri_001_dicom.zip",
        "real/Exam_10/Label_map_simple.zip": "pelicano_exam10_label_map_simple.zip",
    }.items():
        (tmp_path / place).parent.mkdir(parents=True)
        (tmp_path / place).symlink_to(REAL / file)
    names = ("duke_001", "exam_10")
    planned = real_women(*(f"results/women/{name}/what.html" for name in names), dry=True)
    assert planned.returncode == 0, planned.stdout[-3000:]
    checked = real_women("check")
    assert checked.returncode == 0, checked.stdout[-3000:]
    lines = checked.stdout.splitlines()
    assert all(f"{name}: her data can be used; see results/checked/{name}.html" in lines for name in names)
    pages = [(tmp_path / f"results/checked/{name}.html").read_text() for name in names]
    assert "duke_001, prone: 0.80 x 0.80 x 1.10 mm" in pages[0]
    assert all("data:image/png" in page for page in pages)
