"""What the rules promise before anything runs."""

import re
from dataclasses import replace

import pytest
import yaml

from mammosim.chain.stages import STAGES

MAY_READ_THE_TRUTH = ("digital_", "score_")
# What is made by default, and on demand of volunteers beside the study.
TARGETS = ("study", "recovery", "wrong_model", "models")
TWO = ("small", "large")


@pytest.fixture(scope="module")
def jobs(study):
    """Every job of every target with digital volunteers, of which the study has two."""
    return study.jobs("--forceall", *TARGETS, "--config", f"volunteers=[{', '.join(TWO)}]")


def test_each_woman_of_a_study_has_the_same_jobs(jobs):
    # Published models are compared on the first woman alone.
    each = [job for job in jobs if not re.search(r"results/models|/model_|truth/\w+/upright", job)]
    first, second = ({job.replace(v, "v") for job in each if v in re.split(r"\W|_", job)} for v in TWO)
    assert len(first) > 60
    assert first == second


def test_only_rules_that_make_or_score_volunteers_read_the_truth(jobs):
    assert len(jobs) > 60
    peeking = {
        job
        for job, inputs in jobs.items()
        if not job.startswith(MAY_READ_THE_TRUTH) and any("results/truth/" in path for path in inputs)
    }
    assert peeking == set()


def test_a_position_held_out_reaches_only_what_judges_the_fit(jobs):
    """Its labels and mesh are made for the validation; nothing that leads to the moduli may read them."""
    readers = {
        job.split(":")[0]
        for job, inputs in jobs.items()
        if any(re.search(r"(segmentation|meshes|registration)/\w+/supine_tilted", path) for path in inputs)
    }
    assert {"validate", "propagate"} <= readers
    judges = {"mesh", "validate", "propagate", "propagation_rows", "what", "view"}
    assert {rule for rule in readers if not rule.startswith(("figure_", "score_", "table"))} <= judges


def test_scores_are_read_by_tables_and_pictures_only(jobs):
    readers = {
        job.split(":")[0] for job, inputs in jobs.items() if any("results/scores/" in path for path in inputs)
    }
    assert readers <= {"table", "recovery_table", "models_table", "figure_segmentation"}


def test_made_volunteers_go_the_way_of_every_volunteer(study):
    volunteers = ("small", "fibrous", "made_01")
    jobs = study.jobs("--forceall", *(f"results/meshes/{v}/prone.vtu" for v in volunteers))
    small, fibrous, made = (
        {job.split(":")[0] for job in jobs if re.search(rf"/{v}[/_]", job)} for v in volunteers
    )
    assert {"digital_woman", "digital_scan", "import_image", "fiducials", "segment", "mesh"} <= small
    assert fibrous == small
    assert made == small - {"digital_woman"} | {"digital_draw"}


def test_every_rule_says_what_it_does_and_keeps_a_log(repository):
    text = "\n".join(path.read_text() for path in sorted((repository / "workflow/rules").glob("*.smk")))
    rules = re.split(r"^ *rule ?(?=[\w:])", text, flags=re.M)[1:]
    assert len(rules) > 30
    silent = [rule.split(":")[0] for rule in rules if not re.match(r'[^:]*:\s*(name:\s*\w+\s*)?"""', rule)]
    assert silent == []
    for parts in (("log:",), ("benchmark:",), ("resources:",), ("library=",)):
        assert [rule.split(":")[0] for rule in rules if not any(part in rule for part in parts)] == []


# What an image must pass before anything else is done with it, the page that says so, and what makes digital
# volunteers.
MUST_SUCCEED = {"check_input", "check_page", "import_image"} | {
    f"digital_{what}" for what in ("woman", "draw", "body", "position", "scan")
}


def test_every_stage_of_a_volunteer_may_find_no_answer(repository):
    """One that asks for a volunteer, or makes a figure of her, writes the reason in place of its outputs."""
    text = "\n".join(path.read_text() for path in sorted((repository / "workflow/rules").glob("*.smk")))
    unable = set()
    for rule in re.split(r"^ *rule ?(?=[\w:])", text, flags=re.M)[1:]:
        output = re.search(r" output:\n(.*?)\n +\w+:", rule, flags=re.S)
        script = re.search(r'"\.\./scripts/(\w+\.py)"', rule)
        of_a_volunteer = output and re.search(r"\{[vw]\}|figures/(?!accuracy|scenes|peers|hard)", output[1])
        if of_a_volunteer and "_stage.run" not in (repository / "workflow/scripts" / script[1]).read_text():
            unable.add(rule.split(":")[0])
    on_demand = {"soften", "figure_recovery", "figure_wrong_model", "figure_softening", "figure_effects"}
    assert unable - on_demand - {"figure_spectra", "figure_report195", "report"} == MUST_SUCCEED


def test_jobs_that_make_products_by_themselves_depend_on_the_code_of_their_stages(repository):
    """Stages are imported by name: their code has to be declared, or an edit would leave old answers."""
    text = "\n".join(path.read_text() for path in sorted((repository / "workflow/rules").glob("*.smk")))
    checked = set()
    for rule in re.split(r"^(?:rule|checkpoint) ", text, flags=re.M)[1:]:
        script = re.search(r'"\.\./scripts/(\w+\.py)"', rule)
        if script and "chain_of" in (repository / "workflow/scripts" / script[1]).read_text():
            assert re.search(rf'library=library\("{script[1]}", ["*]', rule), rule.split(":")[0]
            checked.add(rule.split(":")[0])
    assert checked >= {"soften", "screen", "accuracy_start", "accuracy_trial", "propagate_press", "dose"}


# Keys that choose what is made, and not how: rules read them.
CHOOSE = {
    *("segmentation.positions", "mechanics.sweep", "mechanics.upright", "mechanics.unloading"),
    *("mechanics.effects", "compression.sides", "compression.strategies_file", "compression.strategies"),
    *("compression.moduli", "compression.thickness_mm", "xray.strategies", "xray.report195", "xray.effects"),
}


def test_every_key_of_the_chain_is_read_by_a_stage_or_chooses_what_is_made(repository):
    config = yaml.safe_load((repository / "config/default.yaml").read_text())
    read = {name for stage in STAGES.values() for name in stage.reads}
    groups = ("registration", "segmentation", "mesh", "morph", "mechanics", "effects", "compression", "xray")
    keys = {f"{group}.{key}" for group in groups for key in config[group]}
    unread = {
        key
        for key in keys
        if not any(f"{key}.".startswith(f"{name}.") or name.startswith(f"{key}.") for name in read)
    }
    assert unread == CHOOSE
    text = "\n".join(path.read_text() for path in (repository / "workflow/rules").glob("*.smk"))
    assert [key for key in CHOOSE if f'["{key.split(".")[1]}"]' not in text] == []


def test_a_key_that_is_given_twice_or_is_no_number_is_named_with_its_file(study, tmp_path):
    cases = {
        "mesh: {element_mm: 4, element_mm: 5}\n": "line 1: 'element_mm' is given twice, in lines 1 and 1",
        "mesh: {behind_markers_mm: .nan}\n": "mesh.behind_markers_mm = nan: must be a number from 10 to 200",
    }
    for text, words in cases.items():
        wrong = tmp_path / "wrong.yaml"
        wrong.write_text(text)
        result = study.snakemake("--dry-run", "--configfile", str(wrong))
        assert result.returncode != 0
        assert "wrong.yaml" in result.stdout
        assert words in result.stdout


OPEN = "solid s\n" + "facet normal 0 0 1\nouter loop\n{}endloop\nendfacet\n".format(
    "".join(f"vertex {x} {y} 0\n" for x, y in ((0, 0), (90, 0), (0, 90)))
) + "endsolid s\n"  # fmt: skip


@pytest.mark.parametrize(
    ("plates", "words"),
    [
        ("paddle: {surface: {file: FILE}}", "soft.paddle.surface: the surface of FILE is open: 3 edges"),
        (
            "support: {curved: {across_radius_mm: 60}}",
            "soft: a face of across_radius_mm = 60 would be steeper",
        ),
        ("paddle: {sloped: {angel_deg: 3}}", "soft.paddle.sloped has no key 'angel_deg'; did you mean"),
    ],
)
def test_plates_that_cannot_be_stop_before_the_first_job(study, tmp_path, plates, words):
    (tmp_path / "open.stl").write_text(OPEN)
    plates, words = (text.replace("FILE", str(tmp_path / "open.stl")) for text in (plates, words))
    strategies, wrong = tmp_path / "strategies.yaml", tmp_path / "wrong.yaml"
    until = "until: {thickness_share: 1.0}"
    strategies.write_text(f"standard: {{{until}}}\nsoft: {{{plates}, {until}}}\n")
    names = "strategies: [standard, soft]"
    wrong.write_text(f"compression: {{strategies_file: {strategies}, {names}}}\nxray: {{{names}}}\n")
    result = study.snakemake("--dry-run", "--configfile", str(wrong))
    assert result.returncode != 0
    assert f"{strategies}: " in result.stdout
    assert words in result.stdout


def test_a_misspelt_key_stops_before_the_first_job(study, tmp_path):
    wrong = tmp_path / "wrong.yaml"
    wrong.write_text("mechanics: {swep: 1}\n")
    result = study.snakemake("--dry-run", "--configfile", str(wrong))
    assert result.returncode != 0
    assert "wrong.yaml" in result.stdout
    assert "mechanics has no key 'swep'; did you mean 'sweep'?" in result.stdout


def test_a_dry_run_imports_nothing_heavy(study, tmp_path):
    """What a start imports is waited for at every start: a table is read without pandas.

    Where results are there, Snakemake itself imports it to compare parameters.
    """
    result = replace(study, run=tmp_path).snakemake(
        "--dry-run", "--quiet", env={"PYTHONPROFILEIMPORTTIME": "1"}
    )
    assert result.returncode == 0, result.stdout[-2000:]
    imported = {
        line.split("|")[-1].strip() for line in result.stdout.splitlines() if line.startswith("import time:")
    }
    assert "mammosim.chain.configuration" in imported
    assert (
        imported & {"pandas", "numba", "scipy", "matplotlib", "SimpleITK", "gmsh", "meshio", "sklearn"}
        == set()
    )


def test_settings_that_cannot_be_meant_stop_before_the_first_job(study, tmp_path):
    """Every fault at once, each in one line with the file that gave it."""
    faults = {
        "xray": ({"strategies": ["standard", "squash"]}, "'squash' is not in compression.strategies"),
        "compression": ({"strategies": ["standard", "hug"]}, "'hug' is not in the file of compression."),
        "scenes": ({"coarse": "exact"}, "'exact' is not in study and config/accuracy"),
        "digital": (
            {"women": {"Ada": {"seed": 3}}},
            "has lower case letters, digits and _ (60 at most) only; write ada",
        ),
        "mesh": ({"behind_markers_mm": 0.08}, "was it given in m? Write 80"),
    }
    wrong = tmp_path / "wrong.yaml"
    wrong.write_text(yaml.safe_dump({group: values for group, (values, _) in faults.items()}))
    result = study.snakemake("--dry-run", "--configfile", str(study.home / "config/smoke.yaml"), str(wrong))
    assert result.returncode != 0
    for _, words in faults.values():
        (line,) = [line for line in result.stdout.splitlines() if words in line]
        assert str(wrong) in line
        assert "default.yaml" not in line


def test_numbers_without_a_point_are_numbers_wherever_they_are_given(study, tmp_path):
    """Snakemake reads `--configfile` and `--config` by YAML 1.1, to which 2e-1 is text."""
    mine = tmp_path / "mine.yaml"
    mine.write_text("mechanics: {sweep: {youngs_modulus_kpa: [2e-1, 1e1]}}\n")
    files = ("--configfile", str(study.home / "config/smoke.yaml"), str(mine), "--config", "seed=2e3")
    jobs = study.jobs("--forceall", *files)
    assert {job.rsplit("/", 1)[-1] for job in jobs if job.startswith("sweep:")} == {
        "0.2kpa.csv",
        "10.0kpa.csv",
    }
