"""Published models: what their files say, what each does otherwise than the study, and the row of one."""

import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import yaml
from small_breast import small_breast, small_chain, study_settings

from mammosim.chain.graph import Chain, read_by
from mammosim.chain.outcome import CONVERGED
from mammosim.chain.published_stages import shared, stages_of
from mammosim.chain.stages import STAGES
from mammosim.core.errors import ConfigurationError
from mammosim.core.mesh import TetMesh
from mammosim.core.rigid import RigidTransform
from mammosim.figures.models import models as drawn
from mammosim.mechanics.body import Body
from mammosim.mechanics.other_laws import IncrementalBody, NetworkBody
from mammosim.study.models.model import PRODUCTS, Model
from mammosim.study.models.rows import SHOWN, measured_row, numbers, table
from mammosim.study.models.scores import nipple_away_mm, score
from mammosim.study.report.texts import quoted, words

NAMES = (
    *("azar2002", "rajagopal2007", "pathmanathan2008", "han2012", "gamage2012", "patete2013", "kuhlmann2013"),
    *("carter2012", "georgii2016", "eiben2014", "eder2014", "report", "mira2018"),
)


SOFT = {"youngs_modulus_kpa": 1.0, "poisson_ratio": 0.45, "density_g_cm3": 1.0}
FLESH = {"tissues": dict.fromkeys(("adipose", "glandular", "muscle"), SOFT)}


def model(repository, name, **changes):
    values = yaml.safe_load((repository / f"config/models/{name}.yaml").read_text()) | changes
    if isinstance(values["tissues"], str):
        values["tissues"] = yaml.safe_load(
            (repository / f"config/tissues/{values['tissues']}.yaml").read_text()
        )
    return Model.of(name, values)


def test_all_files_are_compared_by_default(repository):
    listed = yaml.safe_load((repository / "config/default.yaml").read_text())["models"]["names"]
    files = {path.stem for path in (repository / "config/models").glob("*.yaml")}
    assert set(listed) == files == set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_each_says_where_it_is_from_what_is_reproduced_and_what_is_not(repository, name):
    found = model(repository, name)
    keys = re.findall(r"^@\w+\{([^,\s]+),", (repository / "config/references.bib").read_text(), re.MULTILINE)
    assert found.source in keys
    assert min(map(len, (found.title, found.reproduced, found.not_reproduced, found.known_from))) > 4
    assert set(found.words) <= set(SHOWN)
    # Whatever number was not read is an assumption, and says so.
    text = (repository / f"config/models/{name}.yaml").read_text()
    assert "ASSUME:" in text


@pytest.mark.parametrize(
    ("name", "moduli", "skin", "chest"),
    [
        ("eder2014", "fat 1, gland as fat, muscle as fat; nu 0.495", "none", "held on the ribs"),
        ("gamage2012", "fat 1, gland 2, muscle 30; nu 0.48", "10 kPa, 1.45 mm",
         "held on the ribs, which the skin cannot pass"),
        ("carter2012", "fat 0.894, gland 1.19, muscle 30; nu 0.49", "10 kPa, 1.45 mm",
         "slides on the ribs, 0 kPa/mm along them"),
        ("mira2018", "fat 0.2, gland 0.2, muscle 30; nu 0.495",
         "4 kPa, 1.45 mm; fascia 120 kPa, 0.1 mm; ligaments as fibres",
         "slides on the ribs, 0.0007 kPa/mm along them, which the skin cannot pass"),
    ],
)  # fmt: skip
def test_its_words_are_those_of_its_tissues_and_effects(repository, name, moduli, skin, chest):
    words = model(repository, name).words
    assert (words["moduli_kpa"], words["skin"], words["chest"]) == (moduli, skin, chest)


@pytest.mark.parametrize("name", NAMES)
def test_each_differs_from_the_study_in_what_it_says(repository, name):
    found, study = model(repository, name), study_settings(repository)
    settings = found.over(study, "prone")
    assert settings["tissues"] == settings["load"]["tissues"] == found.tissues
    assert settings["mechanics"]["stress_free"]["default"] == found.method
    assert {**study["mechanics"], "stress_free": None} == {**settings["mechanics"], "stress_free": None}
    assert settings["compression"] == study["compression"]
    same = {"law": "neo_hookean", "method": study["mechanics"]["stress_free"]["default"]}
    same |= {"tissues": study["tissues"], "effects": set(study["mechanics"]["effects"])}
    own = {"law": found.law, "method": found.method, "tissues": found.tissues, "effects": set(found.effects)}
    assert own != same


def test_a_tolerance_of_its_own_is_that_of_its_stress_free_shape(repository):
    study = study_settings(repository)
    ends = {
        name: model(repository, name).over(study, "prone")["mechanics"]["stress_free"]["tolerance_mm"]
        for name in ("patete2013", "han2012")
    }
    assert ends == {"patete2013": 2.0, "han2012": study["mechanics"]["stress_free"]["tolerance_mm"]}


@pytest.mark.parametrize("name", NAMES)
def test_each_is_the_same_of_its_plain_values_as_a_job_has_them(repository, name):
    found = model(repository, name)
    assert Model.of(name, found.plain) == found


def test_the_law_in_increments_has_ten_unless_its_model_says_otherwise(repository):
    study = study_settings(repository)
    values = {"law": "small_strain_increments"}
    taken = {
        name: model(repository, name, **changes).over(study, "prone")["model"]["increments"]
        for name, changes in {"azar2002": {}, "han2012": values, "eder2014": {}}.items()
    }
    assert taken == {"azar2002": 20, "han2012": 10, "eder2014": 10}


def test_no_two_are_the_same(repository):
    said = [
        (m.law, m.method, str(m.tissues), m.effects, str(m.settings))
        for m in (model(repository, n) for n in NAMES)
    ]
    assert len(set(said)) == len(NAMES)


# Which stages of a model are none of the study's.
OTHERWISE = {
    "eiben2014": set(),
    "report": set(),
    "azar2002": {"body", "unloaded"},
    "rajagopal2007": {"unloaded"},
    "patete2013": {"body"},
    "carter2012": {"body"},
}


@pytest.mark.parametrize("name", OTHERWISE)
def test_only_what_a_model_does_otherwise_has_a_stage_of_its_own(repository, name):
    found = model(repository, name)
    always = {"stress_free", "loaded", "pressed_body", "force"}
    assert {
        stage for stage, made in found.stages.items() if made is not STAGES.get(stage)
    } == always | OTHERWISE[name]
    assert set(read_by(found.stages, PRODUCTS)) >= {"load.position", "tissues", "load.thickness_mm"}


def test_a_model_of_the_tissues_and_a_method_of_the_study_begins_with_its_shape(repository):
    study = small_chain(repository)
    where = {"pull_back": "eiben2014", "mean_start": "report", "fixed_point": "han2012"}
    begins = {}
    for method, name in where.items():
        found = model(repository, name)
        by = study.with_settings({"mechanics.stress_free.default": method})
        chain = Chain(
            study.subject, found.over(study.settings, "prone"), frozenset(found.effects), found.stages
        )
        begins[name] = set(shared(PRODUCTS, chain, by)) & {"unloaded", "mesh"}
    assert begins == {
        "eiben2014": {"unloaded", "mesh"},
        "report": {"unloaded", "mesh"},
        "han2012": {"mesh"},  # gland of its own
    }


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"law": "fung"}, r"config/models/han2012\.yaml: law: no 'fung'; choose one of: neo_hookean"),
        ({"method": "guess"}, "method: no 'guess'; choose one of: reverse_gravity"),
        ({"effects": ["gland", "blood"]}, "effects: no 'blood'; choose one of: gland"),
        ({"effects": ["sliding"]}, "settings.sliding is not there; give the numbers of that effect"),
        ({"settings": {"water": {"density_g_cm3": 1.0}}}, "settings.water: nothing of the model uses it"),
        ({"increments": 0, "law": "small_strain_increments"}, "increments"),
        ({"increments": 50}, "increments: only the law small_strain_increments has them; leave it out"),
        (
            {"tolerance_mm": 1.0, "method": "as_measured"},
            "tolerance_mm: the method as_measured unloads nothing",
        ),
        ({"tissues": FLESH}, "tissues has no skin; add it, or leave `skin` out of the effects"),
        ({"colour": "red"}, "colour"),
    ],
)
def test_what_cannot_be_meant_is_one_line_that_names_the_file(repository, changes, words):
    with pytest.raises(ConfigurationError, match=words) as caught:
        model(repository, "han2012", **changes)
    assert str(caught.value).startswith("config/models/han2012.yaml")
    assert str(caught.value).count("config/models/han2012.yaml") == 1
    assert "\n" not in str(caught.value)


@pytest.fixture(scope="module")
def made(repository):
    """Chains of models of the small breast, whose ribs are flat; its mesh is made once."""
    study = small_chain(repository)
    breast, mesh = small_breast(), study["mesh"]

    def chain(name, **changes):
        found = model(repository, name, **changes)
        of = Chain(study.subject, found.over(study.settings, "prone"), frozenset(found.effects), found.stages)
        return of.given({"breast": breast, "mesh": mesh})

    return chain


NIPPLE = small_breast().to_reference(small_breast().nipple[None])[0]


def test_the_row_of_a_model_says_where_its_nipples_are_and_what_it_took(made):
    row = measured_row(made("pathmanathan2008"), {"prone": NIPPLE}, took=1000.0)
    assert row["outcome"] == CONVERGED
    assert row["nipple_prone_mm"] < 0.05, "the inverse formulation, loaded again"
    assert np.isnan(row["nipple_supine_mm"]), "nobody measured it there"
    assert row["nipple_supine_y_mm"] > row["nipple_prone_y_mm"] + 2.0
    assert row["nipple_upright_z_mm"] < row["nipple_prone_z_mm"] - 2.0
    assert row["force_n"] > 0
    assert row["seconds"] > 1000.0


def test_water_leaves_little_of_the_weight(made):
    """Between the shape without gravity, which the inverse formulation finds, and the prone one."""
    free = measured_row(made("rajagopal2007", method="inverse", settings={}), {"prone": NIPPLE})
    wet = measured_row(made("rajagopal2007"), {"prone": NIPPLE})
    assert free["nipple_prone_mm"] < 0.05
    assert 0.05 < wet["nipple_prone_mm"] < 0.5 * free["stress_free_moved_mm"]


def test_water_that_ends_before_the_ribs_carries_less(made):
    """The nearer its surface is to the nipple, the more of the breast hangs as it did in air."""

    def moved(before_ribs_mm):
        water = {"density_g_cm3": 1.0, "before_ribs_mm": before_ribs_mm}
        chain = made("rajagopal2007", settings={"water": water})
        return np.abs(chain["unloaded"].mesh.points - chain["mesh"].points).max()

    assert moved(40.0) < 0.9 * moved(0.0)


@pytest.mark.parametrize(
    ("name", "kind"), [("azar2002", IncrementalBody), ("patete2013", NetworkBody), ("mira2018", Body)]
)
def test_its_body_is_of_its_law(made, name, kind):
    assert type(made(name)["body"]) is kind


@pytest.mark.parametrize(
    ("name", "on_ribs"),
    [
        ("han2012", {}),
        ("carter2012", {"Slides": ("sliding", "normal_kpa_per_mm", "tangential_kpa_per_mm")}),
        ("gamage2012", {"ChestWall": ("chest_wall", "penalty_kpa_per_mm")}),
        (
            "mira2018",
            {
                "Slides": ("sliding", "normal_kpa_per_mm", "tangential_kpa_per_mm"),
                "ChestWall": ("chest_wall", "penalty_kpa_per_mm"),
            },
        ),
    ],
)
def test_it_slides_on_the_ribs_and_cannot_pass_them_as_its_file_says(made, repository, name, on_ribs):
    parts = {type(part).__name__: part for part in made(name)["body"].parts}
    assert {"Slides", "ChestWall"} & set(parts) == set(on_ribs)
    for kind, (effect, *numbers_of) in on_ribs.items():
        given = model(repository, name).settings[effect]
        assert {each: getattr(parts[kind], each) for each in numbers_of} == given


def test_its_force_is_that_at_the_distance_of_the_plates_that_was_asked_for(made):
    by_increments = made("azar2002", increments=3).with_settings({"load.thickness_mm": 78.0})
    assert by_increments["force"].thickness_mm == 78.0
    along_a_path = made("han2012").with_settings({"load.thickness_mm": 62.0})
    path = along_a_path["standard_path"].path
    assert along_a_path["force"].thickness_mm == pytest.approx(62.0, abs=0.5)
    assert along_a_path["force"].force_n == path.force_n.max() > path.force_n.min()


def test_a_model_that_begins_with_the_measured_shape_has_its_prone_nipple_by_assumption(made):
    chain = made("azar2002", increments=2)
    row = measured_row(chain.with_settings({"load.thickness_mm": 62.0}), {"prone": NIPPLE})
    assert row["nipple_prone_mm"] < 1e-6
    assert row["stress_free_moved_mm"] < 1e-9
    assert row["nipple_supine_y_mm"] > row["nipple_prone_y_mm"] + 2.0


def test_what_fails_is_said_once_and_everything_else_is_there(made):
    """Too soft for its weight, without skin: there is no shape to load or press."""
    soft = {"youngs_modulus_kpa": 0.02, "poisson_ratio": 0.45, "density_g_cm3": 1.0}
    tissues = {"tissues": dict.fromkeys(("adipose", "glandular", "muscle"), soft)}
    row = measured_row(made("eder2014", tissues=tissues), {"prone": NIPPLE})
    assert row["outcome"].startswith("stress-free shape ")
    assert "\n" not in row["outcome"]
    assert not any(f"; {doing} " in row["outcome"] for doing in ("prone", "supine", "upright", "between"))
    assert np.isnan(row["force_n"])
    assert np.isnan(row["nipple_prone_mm"])


ROWS = pd.DataFrame(
    {
        "volunteer": "small", "side": "left", "model": ["a", "b"], "title": ["A", "B"], "law": "neo-Hookean",
        "moduli_kpa": "1", "skin": "none", "chest": "held", "unloading": "x", "known_from": "title",
        "reproduced": "r", "not_reproduced": "n", "nipple_prone_mm": [0.0, 1.0],
        "nipple_supine_mm": [3.0, np.nan],
        "nipple_upright_mm": np.nan, "stress_free_moved_mm": [9.0, np.nan], "thickness_mm": [45.0, np.nan],
        "force_n": [2.0, np.nan], "seconds": [10.0, 5.0], "outcome": [CONVERGED, "supine failed: why"],
    }
)  # fmt: skip
SCORES = pd.DataFrame(
    {
        "volunteer": "small", "side": "left", "model": ["b", "a"], "stress_free_mean_mm": [4.0, 1.0],
        "stress_free_median_mm": [5.0, 2.0], "nipple_upright_mm": [np.nan, 7.0],
    }
)  # fmt: skip


def test_scores_join_the_rows_of_their_models_and_a_real_woman_has_none():
    both = table(ROWS, SCORES)
    assert list(both.columns) == list(SHOWN)
    assert list(both.stress_free_mean_mm) == [1.0, 4.0]
    assert both.nipple_upright_mm[0] == 7.0
    assert table(ROWS, None)[["stress_free_mean_mm", "nipple_upright_mm"]].isna().all(axis=None)


def test_the_page_is_told_who_is_nearest_and_what_failed():
    said = numbers(table(ROWS, SCORES))
    assert said["models.converged"] == 1
    assert said["models.failed"] == "B"
    assert (said["models.nearest"], said["models.nearest_mm"]) == ("A", 3.0)
    assert said["models.seconds"] == 15.0
    nothing = numbers(table(ROWS.assign(nipple_supine_mm=np.nan, force_n=np.nan), SCORES))
    assert nothing["models.nearest"] is None
    assert nothing["models.force_most_n"] is None


def test_a_title_is_read_as_it_stands():
    marked = table(ROWS.assign(title=["B", r"$\frac$ **A**"]), SCORES)
    drawn(marked).canvas.draw()
    text = quoted("{models.failed} of {models.nearest}", numbers(marked))
    assert str(words(text)) == r"$\frac$ **A** of B"


def test_the_figure_has_every_model_and_marks_what_it_did_not_find():
    axes = drawn(table(ROWS, SCORES)).axes
    assert [label.get_text() for label in axes[0].get_yticklabels()] == ["A", "B"]
    assert axes[2].lines[0].get_xdata()[0] == 2.0
    open_marks = [line for line in axes[2].lines if line.get_markerfacecolor() == "white"]
    assert [line.get_ydata()[0] for line in open_marks] == [0]


def test_a_score_knows_the_frames_of_shape_and_nipple(repository):
    mesh = small_chain(repository)["mesh"]
    motion = RigidTransform(np.eye(3), np.array([0.0, 4.0, 0.0]))
    truth = replace(mesh, points=motion.inverse()(mesh.points))
    assert score(mesh, truth, motion=motion)["stress_free_median_mm"] == pytest.approx(0.0, abs=1e-6)
    assert np.isnan(score(None, truth, motion=motion)["stress_free_mean_mm"])
    assert isinstance(truth, TetMesh)
    row = pd.Series({"nipple_upright_x_mm": 1.0, "nipple_upright_y_mm": 6.0, "nipple_upright_z_mm": 3.0})
    assert nipple_away_mm(row, np.array([1.0, 2.0, 6.0]), motion=motion) == pytest.approx(3.0)


def test_stages_of_a_plain_model_differ_in_nothing_but_what_is_always_so():
    from mammosim.chain.published_stages import Otherwise

    plain = stages_of(Otherwise("neo_hookean", "inverse", frozenset({"skin"})))
    assert plain["body"] is STAGES["body"]
    assert plain["unloaded"] is STAGES["unloaded"]
