"""What the rules promise before anything runs."""

import re

MAY_READ_THE_TRUTH = ("digital_", "score_")


def test_only_rules_that_make_or_score_volunteers_read_the_truth(study):
    jobs = study.jobs("--forceall")
    assert len(jobs) > 40
    peeking = {
        job
        for job, inputs in jobs.items()
        if not job.startswith(MAY_READ_THE_TRUTH) and any("results/truth/" in path for path in inputs)
    }
    assert peeking == set()


def test_a_position_held_out_reaches_only_what_judges_the_fit(study):
    """Its labels and mesh are made for the validation; nothing that leads to the moduli may read them."""
    readers = {
        job.split(":")[0]
        for job, inputs in study.jobs("--forceall").items()
        if any(re.search(r"(segmentation|meshes|registration)/\w+/supine_tilted", path) for path in inputs)
    }
    assert {"validate", "propagate"} <= readers
    judges = {"mesh", "validate", "propagate", "propagation_rows"}
    assert {rule for rule in readers if not rule.startswith(("figure_", "score_", "table"))} <= judges


def test_scores_are_read_by_tables_and_pictures_only(study):
    readers = {
        job.split(":")[0]
        for job, inputs in study.jobs("--forceall").items()
        if any("results/scores/" in path for path in inputs)
    }
    assert readers <= {"table", "figure_segmentation"}


def test_every_rule_says_what_it_does_and_keeps_a_log(repository):
    text = "\n".join(path.read_text() for path in sorted((repository / "workflow/rules").glob("*.smk")))
    rules = re.split(r"^rule ", text, flags=re.M)[1:]
    assert len(rules) > 30
    silent = [rule.split(":")[0] for rule in rules if not rule.split(":\n", 1)[1].lstrip().startswith('"""')]
    assert silent == []
    for part in ("log:", "benchmark:", "resources:", "library=library("):
        assert [rule.split(":")[0] for rule in rules if part not in rule] == []


def test_a_misspelt_key_stops_before_the_first_job(study, tmp_path):
    wrong = tmp_path / "wrong.yaml"
    wrong.write_text("mechanics: {swep: 1}\n")
    result = study.snakemake("--dry-run", "--configfile", str(wrong))
    assert result.returncode != 0
    assert "wrong.yaml" in result.stdout
    assert "mechanics has no key 'swep'; did you mean 'sweep'?" in result.stdout
