"""Any part of the chain alone: what her data allow is planned, and the rest is named with its reason.

The data of a digital volunteer are given in parts, under another name, in a folder where nothing else is.
"""

import re
import shutil
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml

from mammosim.core.labels import Label
from mammosim.core.volume import LabelMap
from mammosim.io.images import read_labels, write_labels

pytestmark = pytest.mark.workflow
ONE = "ada was scanned in one position, two are needed"
MAMMOGRAM = "results/xray/ada/left/standard_gravity_mammogram.csv"
# From what is given to the mammogram, whatever it is.
ALWAYS = {"check_input", "fiducials", "mesh", "stress_free", "standard_path", "compress", "phantom", "field"}
ALWAYS |= {"spectrum", "scatter", "mammogram", "unload"}
# Smaller than the tiny study: what is asked is whether there is an answer.
SMALLEST = {
    "mesh": {"element_mm": {"breast": 26.0, "chest": 34.0}},
    "compression": {"thickness_mm": {"ada": 60.0}, "steps": 3},
    "xray": {
        **{"energies": 4, "voxel_mm": 5.0, "pixel_mm": 3.0, "scatter_error_percent": 30.0},
        "calcifications": {"pixel_mm": 0.4, "images": 5},
    },
}


@dataclass(frozen=True)
class Own:
    """The study of one woman: a folder with her table and the files that it names."""

    study: Any
    settings: Path

    def ask(self, *arguments: str):
        """Run snakemake with her settings."""
        smoke = str(self.study.home / "config/smoke.yaml")
        return self.study.snakemake("--configfile", smoke, str(self.settings), *arguments)

    def plan(self, *targets: str) -> tuple[set[str], str]:
        """The rules that a dry run would run, and all that it says."""
        result = self.ask("--dry-run", "--", *targets)
        assert result.returncode == 0, result.stdout[-3000:]
        outputs = re.findall(r"^    output: (.*)$", result.stdout, flags=re.M)
        assert [path for path in outputs if re.search("small|large|fibrous|made_", path)] == [], "of others"
        return set(re.findall(r"^(?:local)?rule (\w+):$", result.stdout, flags=re.M)), result.stdout


@pytest.fixture
def own(finished, tmp_path):
    """Of rows of the table of volunteers, the study of ada alone, in a folder of its own."""
    run = tmp_path / "run"
    run.mkdir()
    raw = finished.run / "results/raw/small"
    (run / "data").mkdir()
    for position in ("prone", "supine"):
        shutil.copytree(raw / position, run / "data" / position)
        for what in ("fiducials", "strokes"):
            shutil.copy(raw / f"{position}_{what}.csv", run / "data")
    shutil.copy(finished.run / "results/segmentation/small/prone.nii.gz", run / "data/prone_labels.nii.gz")

    def of(*rows: dict[str, str], **settings) -> Own:
        rows = [{"volunteer": "ada", "position": "prone", "gravity": "0 -1 0"} | row for row in rows]
        pd.DataFrame(rows).to_csv(run / "volunteers.tsv", sep="\t", index=False)
        values = {"volunteers": ["ada"], "volunteer_table": "volunteers.tsv"} | SMALLEST | settings
        (tmp_path / "own.yaml").write_text(yaml.safe_dump(values))
        return Own(replace(finished, run=run), tmp_path / "own.yaml")

    return of


SERIES = {"images": "data/prone", "strokes": "data/prone_strokes.csv"}
SUPINE = {
    "position": "supine",
    "gravity": "0 1 0",
    "images": "data/supine",
    "strokes": "data/supine_strokes.csv",
}


def test_one_series_without_markers_plans_her_own_stages_up_to_the_mammogram(own):
    rules, words = own(SERIES).plan(MAMMOGRAM)
    assert rules == ALWAYS | {"import_image", "segment"}
    told = [line for line in words.splitlines() if line.startswith("Not planned")]
    assert len(told) == 1, "one line"
    assert "no fit of moduli" in told[0]
    assert told[0].endswith(f"{ONE}.")


def test_the_study_of_one_series_asks_for_no_fit_and_fails_nowhere(own):
    rules, _ = own(SERIES).plan("study")
    assert {"report", "not_planned", "tomosynthesis", "dose", "upright", "figure_stress_free"} <= rules
    unplanned = {"register", "identify", "identify_grid", "validate", "propagate", "morph", "sweep"}
    unplanned |= {"take_labels", "moduli_ratio", "figure_moduli", "figure_registration", "figure_morph"}
    assert rules.isdisjoint(unplanned)


def test_two_series_without_markers_are_registered_by_the_rib_cage_and_fitted(own):
    rules, words = own(SERIES, SUPINE).plan("study")
    assert {"register", "identify", "morph", "validate", "figure_registration", "segment"} <= rules
    assert rules.isdisjoint({"sweep", "propagate"})
    assert "no sweep of moduli: no nipples are given for ada supine" in words
    assert "no validation, no propagation of the fit's uncertainty: no position of ada is held out" in words


def test_a_rib_cage_is_registered_in_the_workflow(own):
    ada, files = own(SERIES, SUPINE), ("prone.tfm", "prone_steps.csv")
    result = ada.ask("--", *(f"results/registration/ada/{file}" for file in files))
    assert result.returncode == 0, result.stdout[-6000:]
    steps = pd.read_csv(ada.study.run / "results/registration/ada/prone_steps.csv")
    assert steps.method.tolist() == ["rib cage"] * 2
    assert steps.error_95_mm.iloc[-1] < 10.0
    assert pd.read_csv(ada.study.run / "results/fiducials/ada/supine.csv").empty


def test_two_marked_series_plan_a_fit_and_no_validation(own):
    given = {"prone": SERIES, "supine": SUPINE}
    marked = [row | {"fiducials": f"data/{p}_fiducials.csv"} for p, row in given.items()]
    rules, words = own(*marked).plan("study")
    assert {"register", "identify", "morph", "sweep", "figure_identification"} <= rules
    assert rules.isdisjoint({"propagate", "figure_validation"})
    assert "no position of ada is held out of the fit" in words


def test_where_nobody_can_be_pressed_the_study_asks_for_nothing_that_compares_presses(own):
    ida = own({"position": "supine", "gravity": "0 1 0", "labels": "data/prone_labels.nii.gz"})
    rules, words = ida.plan("study")
    assert "report" in rules
    assert rules.isdisjoint({"fiducials", "mesh", "unload", "stress_free", "compress", "figure_mesh"})
    outputs = re.findall(r"^    output: (.*)$", words, flags=re.M)
    assert [
        each for each in outputs if re.search("curves|amounts|dose_routes|trade_off|image.csv", each)
    ] == []


def test_softening_of_nobody_is_rejected_with_the_reason(own):
    result = own(SERIES).ask("--dry-run", "--", "softening")
    assert result.returncode != 0
    assert f"softening cannot be computed: {ONE}" in result.stdout


def test_labels_alone_go_to_a_mammogram_without_any_image(own):
    """Planned without segmentation and registration, and run: her labels are the product of segmentation."""
    ada = own({"labels": "data/prone_labels.nii.gz"})
    assert ada.plan(MAMMOGRAM)[0] == ALWAYS | {"take_labels"}
    result = ada.ask("--", MAMMOGRAM, "results/study/not_planned.csv")
    assert result.returncode == 0, result.stdout[-6000:]
    assert "no segmentation: labels are given for ada" in result.stdout
    row = pd.read_csv(ada.study.run / MAMMOGRAM).iloc[0]
    assert (row.volunteer, row.moduli) == ("ada", "gravity")
    assert row.mas > 0
    assert row.cnr_quantum > 0
    given, used = (
        ada.study.run / "data/prone_labels.nii.gz",
        ada.study.run / "results/segmentation/ada/prone.nii.gz",
    )
    assert (read_labels(given).values == read_labels(used).values).all()
    rows = pd.read_csv(ada.study.run / "results/study/not_planned.csv").set_index("not_planned").reason
    assert rows["segmentation"] == "labels are given for ada"
    assert rows["fit of moduli"] == rows["registration"] == ONE


def test_labels_that_nobody_knows_end_the_run_at_once(own):
    ada = own({"labels": "data/others.nii.gz"})
    known = read_labels(ada.study.run / "data/prone_labels.nii.gz")
    others = np.where(known.values == Label.THORAX, np.uint8(50), known.values)
    write_labels(LabelMap(known.grid, others), ada.study.run / "data/others.nii.gz")
    result = ada.ask("--", MAMMOGRAM)
    assert result.returncode != 0
    last = "\n".join(result.stdout.splitlines()[-20:])
    assert "check_input ada prone: ImageError: data/others.nii.gz: mammosim has no tissue for code 50" in last
    assert not (ada.study.run / "results/segmentation").exists()


def test_a_woman_scanned_prone_only_needs_no_supine(own):
    """Prone is the reference, nothing is held out, and no fit is asked."""
    _, words = own(
        SERIES | {"fiducials": "data/prone_fiducials.csv"},
        reference_position="prone",
        segmentation={"positions": ["prone"]},
        validation={"positions": []},
    ).plan("study")
    assert f"no fit of moduli, no validation, no propagation of the fit's uncertainty: {ONE}." in words
