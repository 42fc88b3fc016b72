"""What rules hand to their scripts, of data and settings, with scripts that only write it down."""

import json
import shutil
from dataclasses import replace

import pytest
import yaml
from whole_study import PARTS

pytestmark = pytest.mark.workflow
SCRIPT = """import json
from pathlib import Path

handed = {
    "input": {name: at if isinstance(at, str) else list(at) for name, at in snakemake.input.items()},
    "params": {name: value for name, value in snakemake.params.items() if name not in ("library", "now")},
}
for path in snakemake.output:
    Path(path).write_text(json.dumps(handed))
"""
COLUMNS = ("volunteer", "position", "images", "labels", "series", "gaps", "codes", "gravity")
ROWS = (
    ("ada", "prone", "mine/prone", "", "5", "resample", "", "0 -1 0"),
    ("ada", "supine", "mine/supine", "", "", "", "", "0 1 0"),
    ("bea", "prone", "", "mine/l.nii.gz", "", "", "mine/codes.tsv", "0 -1 0"),
    ("bea", "supine", "", "mine/l_supine.nii.gz", "", "", "victre", "0 1 0"),
)
TARGETS = (
    "results/checked/ada.html",
    "results/checked/bea.html",
    "results/checked/small.html",
    "results/images/ada/prone.nii.gz",
    "results/checked/bea_prone.csv",
    "results/truth/made_03/woman.json",
    "results/truth/small/stress_free.vtu",
)


@pytest.fixture(scope="module")
def handed(study, tmp_path_factory):
    """What the job of each file of TARGETS, and of those that it is made of, was given."""
    folder = tmp_path_factory.mktemp("handed")
    there = replace(study, home=folder / "home", run=folder / "run")
    there.home.mkdir()
    for part in PARTS:
        copy = shutil.copytree if (study.home / part).is_dir() else shutil.copy2
        copy(study.home / part, there.home / part)
    for name in (
        "check_page",
        "check_input",
        "import_image",
        "digital_woman",
        "digital_draw",
        "digital_body",
    ):
        (there.home / f"workflow/scripts/{name}.py").write_text(SCRIPT)
    mine = there.run / "mine"
    for series in ("prone", "supine"):
        (mine / series).mkdir(parents=True)
        (mine / series / "1.dcm").write_bytes(b"a slice")
    for name in ("l.nii.gz", "l_supine.nii.gz"):
        (mine / name).write_bytes(b"labels")
    (there.run / "results/raw/small/prone").mkdir(parents=True)  # and not her other positions yet
    (mine / "codes.tsv").write_text("code\ttissue\n0\tair\n")
    lines = "".join("\t".join(row) + "\n" for row in (COLUMNS, *ROWS))
    (mine / "volunteers.tsv").write_text(lines)
    recovery = yaml.safe_load((there.home / "config/recovery_smoke.yaml").read_text())
    (mine / "recovery.yaml").write_text(yaml.safe_dump(recovery | {"seeds": [1, 3]}))
    settings = {
        "recovery": "mine/recovery.yaml",
        **{"volunteers": ["ada", "bea"], "volunteer_table": "mine/volunteers.tsv", "seed": 7},
        **{"registration": {"chest_markers": "found"}, "compression": {"thickness_mm": {"ada": 52.0}}},
    }
    (mine / "mine.yaml").write_text(yaml.safe_dump(settings))
    smoke = str(there.home / "config/smoke.yaml")
    made = there.snakemake("--configfile", smoke, str(mine / "mine.yaml"), "--", *TARGETS)
    assert made.returncode == 0, made.stdout[-3000:]
    return lambda path: json.loads((there.run / path).read_text())


def test_the_page_before_a_run_judges_as_the_check_does(handed):
    pages = {v: handed(f"results/checked/{v}.html")["params"] for v in ("ada", "bea")}
    told = {v: page["told"] for v, page in pages.items()}
    rows = {f"{v}_{row['position']}": row for v, page in pages.items() for row in page["rows"]}
    for name in ("ada_prone", "ada_supine", "bea_prone"):
        check, volunteer = handed(f"results/checked/{name}.csv")["params"], name.split("_")[0]
        asked = told[volunteer]["asked"]
        assert asked["found"], "as is configured"
        assert check["chest_markers"] == "found"
        assert asked["registered"] == check["registered"]
        assert asked["sides"] == check["sides"]
        assert rows[name]["gravity"] == check["gravity"]
        assert rows[name]["how"] == check["how"]
        assert rows[name]["codes"] == check["labels"]
        assert told[volunteer]["element_mm"] == check["element_mm"]


def test_positions_of_labels_alone_are_not_brought_together(handed):
    assert handed("results/checked/ada_prone.csv")["params"]["registered"]
    assert not handed("results/checked/bea_prone.csv")["params"]["registered"]


def test_the_thickness_of_a_page_is_the_one_that_is_stated(handed):
    stated = {v: handed(f"results/checked/{v}.html")["params"]["told"]["stated"] for v in ("ada", "bea")}
    assert stated == {"ada": True, "bea": False}


def test_data_of_ones_own_are_not_waited_for(handed):
    assert not any(handed(f"results/checked/{v}.html")["params"]["told"]["waits"] for v in ("ada", "bea"))


def test_a_digital_woman_is_waited_for_until_all_of_her_scans_are_there(handed):
    params = handed("results/checked/small.html")["params"]
    there = {row["position"]: row["there"] for row in params["rows"]}
    assert there.pop("prone")
    assert there
    assert not any(there.values())
    assert params["told"]["waits"]


def test_an_image_is_imported_as_its_row_says_and_after_all_of_hers_is_checked(handed):
    found = handed("results/images/ada/prone.nii.gz")
    assert found["params"]["how"] == {"series": "5", "gaps": "resample"}
    assert found["input"]["images"] == "mine/prone"
    assert found["input"]["files"] == ["mine/prone/1.dcm"]
    assert found["input"]["others"] == [f"results/checked/ada_{p}.csv" for p in ("prone", "supine")]


def test_a_file_that_explains_codes_is_an_input_and_a_preset_is_none(handed):
    found = handed("results/checked/bea_prone.csv")
    assert found["input"]["codes"] == "mine/codes.tsv"
    assert found["params"]["labels"]["codes"] == "mine/codes.tsv"
    page = handed("results/checked/bea.html")["params"]["rows"]
    assert [row["codes"]["codes"] for row in page] == ["mine/codes.tsv", "victre"]


def test_each_woman_that_is_drawn_has_a_random_stream_of_her_own(handed, study):
    params = handed("results/truth/made_03/woman.json")["params"]
    recovery = yaml.safe_load((study.home / "config/recovery_smoke.yaml").read_text())
    assert params["stream"] == [7, "made", 3]
    assert params["ranges"] == recovery["ranges"]
    assert len(params["between"]) == len(recovery["between"]) >= 2


def test_digital_women_are_made_of_their_own_tissues(handed, study):
    """And not of those that the study assumes, or a wrong assumption would be true of them."""
    digital = yaml.safe_load((study.home / "config/default.yaml").read_text())["digital"]["tissues"]
    tissues = yaml.safe_load((study.home / f"config/tissues/{digital}.yaml").read_text())
    assert handed("results/truth/small/stress_free.vtu")["params"]["tissues"] == tissues
