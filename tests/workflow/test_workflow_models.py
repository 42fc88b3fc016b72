"""Published models: what a run plans of them, and files of models that cannot be meant."""

import pytest
import yaml

pytestmark = pytest.mark.workflow


@pytest.fixture
def mine(study, tmp_path):
    """A function that asks for a model of one's own, han2012 with changes, in a folder of its own."""

    def asked(*options, **changes):
        values = yaml.safe_load((study.home / "config/models/han2012.yaml").read_text()) | changes
        (tmp_path / "config/models").mkdir(parents=True, exist_ok=True)
        (tmp_path / "config/models/mine.yaml").write_text(yaml.safe_dump(values))
        only = tmp_path / "only.yaml"
        only.write_text("models: {names: [mine]}\n")
        smoke = study.home / "config/smoke.yaml"
        where = ("--directory", str(tmp_path), "--configfile", str(smoke), str(only))
        return study.snakemake(*where, *options)

    return asked


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"law": "fung"}, "config/models/mine.yaml: law = 'fung': must be one of: neo_hookean"),
        ({"effects": ["blood"]}, "config/models/mine.yaml: effects.0 = 'blood': must be one of: gland"),
        ({"colour": "red"}, "config/models/mine.yaml: there is no key 'colour'"),
        (
            {"source": "nobody1900"},
            "config/models/mine.yaml: source = 'nobody1900': config/references.bib has no",
        ),
        (
            {"tissues": "wool"},
            "config/models/mine.yaml: tissues = 'wool': not in config/tissues; take one of",
        ),
        ({"tissues": {"tissues": {}}}, "config/models/mine.yaml: no parameters for tissue 'adipose'"),
        (
            {"tissues": "../tissues/standard"},
            "config/models/mine.yaml: tissues = '../tissues/standard': not in",
        ),
        (
            {"tissues": {"tissues": {"adipose": {"youngs_modulus_kpa": -1.0}}}},
            "config/models/mine.yaml: tissues.tissues.adipose.youngs_modulus_kpa = -1.0: must be",
        ),
        ({"effects": ["sliding"]}, "config/models/mine.yaml: settings.sliding is not there"),
    ],
)
def test_a_model_that_cannot_be_meant_is_one_line_that_names_its_file(mine, changes, words):
    result = mine("--dry-run", "--quiet", "all", "--", "models", **changes)
    said = result.stdout
    assert result.returncode != 0
    assert words in said
    assert "Traceback" not in said


def test_two_models_of_one_title_are_told_apart_by_nobody(mine, study, tmp_path):
    both = tmp_path / "both.yaml"
    both.write_text("models: {names: [mine, han2012]}\n")
    result = mine("--configfile", str(both), "--dry-run", "--quiet", "all", "--", "models")
    assert result.returncode != 0
    assert "config/models/mine.yaml and config/models/han2012.yaml have the same title" in result.stdout


def test_a_model_of_ones_own_is_planned_with_what_it_begins_with(mine):
    """Its method is one of the study's, and its tissues are: then it begins with the study's own shape."""
    own = mine("--dry-run", "--quiet", "rules", "--", "models")
    planned = own.stdout
    assert own.returncode == 0, planned
    assert "published_model small left mine" in planned
    assert "unload" not in planned, "its tissues are its own"
    like = mine("--dry-run", "--quiet", "rules", "--", "models", tissues="standard")
    assert "unload" in like.stdout
