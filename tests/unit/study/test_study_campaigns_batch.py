"""A batch of points: what is finished stays, what is shared is made once, and failures stop nobody."""

import json
import shutil
import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from small_breast import small_chain

from mammosim.chain import meshed, quantities
from mammosim.chain.graph import Made
from mammosim.core.errors import ConfigurationError, EquilibriumError, MeshError, UnloadingError
from mammosim.study.campaigns import answers
from mammosim.study.campaigns.answers import faults, moduli_factor
from mammosim.study.campaigns.batch import Batch, Item
from mammosim.study.campaigns.failures import Failures

ADIPOSE = "tissues.tissues.adipose.youngs_modulus_kpa"
CODE = {"mesh": "code", "spectrum": "code"}


@pytest.fixture(scope="module")
def chain(repository):
    """Of the small breast, which is only meshed."""
    return small_chain(repository)


@pytest.fixture
def asked(monkeypatch):
    """What is asked is quick: the modulus of fat times the number of elements; the moduli that were asked."""
    asked = []

    def stiffness(chain):
        modulus = chain["body"].tissues[fat_of(chain)].youngs_modulus_kpa
        asked.append(modulus)
        if modulus == 13:
            raise EquilibriumError("the paddle slips\nat once", mode=None)
        if modulus == 17:
            raise ZeroDivisionError("a mistake of the program")
        if modulus == 29:
            raise ConfigurationError("it cannot be meant")
        if modulus == 19:
            raise KeyboardInterrupt
        return float("inf") if modulus == 23 else modulus * len(chain["mesh"].cells)

    found = quantities.Quantity(
        "stiffness", ("body", "mesh"), stiffness, noise=lambda chain: 0.5, column="stiff"
    )
    monkeypatch.setattr(answers, "QUANTITIES", {"stiffness": found})
    return asked


def fat_of(chain):
    return next(label for label in chain["body"].tissues if label.name == "ADIPOSE")


def items(*moduli, size=16.0):
    changes = {"mesh.element_mm.breast": size}
    return [
        Item(
            name=f"{modulus:02d}{size:g}",
            shown={"fat": modulus},
            changes={**changes, ADIPOSE: modulus},
            effects=None,
            kept={},
            own={"mesh": f"mesh{size:g}", "body": f"body{modulus}"},
            stored={"mesh": f"mesh{size:g}"},
        )
        for modulus in moduli
    ]


def batch(chain, folder: Path, run: str = "") -> Batch:
    return Batch(chain, ["body", "mesh"], folder / "points", folder / "products", CODE, Failures(run))


def test_points_are_answered_with_their_errors_and_share_what_they_are_made_of(
    chain, asked, tmp_path, caplog
):
    caplog.set_level("INFO")
    began = time.process_time()
    one, two = batch(chain, tmp_path).rows(items(1, 2))
    assert 0 < one["seconds"] + two["seconds"] <= time.process_time() - began
    assert one["shown"] == {"fat": 1}
    assert one["outcome"] == "converged"
    assert two["answers"]["stiff"] == 2 * one["answers"]["stiff"]
    assert two["errors"]["stiff"] == 0.5 * two["answers"]["stiff"]
    assert caplog.text.count("mesh is shared and kept") == 1
    assert one["took"]["mesh"] > 0
    assert "mesh" not in two["took"]
    assert one["seconds"] > one["took"]["mesh"]
    assert sum(two["took"].values()) <= two["seconds"], "what an earlier point took is not told again"
    assert len(list((tmp_path / "products/mesh").iterdir())) == 1
    # What no later point needs is not held.
    assert not any(key[0] == "body" for key in chain.made)


def test_what_points_share_and_can_be_read_no_more_is_a_fault_until_it_is_made_again(chain, asked, tmp_path):
    assert [row["outcome"] for row in batch(chain, tmp_path).rows(items(1))] == ["converged"]
    (file,) = (tmp_path / "products/mesh").glob("*/*.vtu")
    whole = file.read_bytes()
    file.write_bytes(whole[: len(whole) // 2])
    (row,) = batch(chain, tmp_path).rows(items(3))
    assert row["outcome"] == "failed"
    assert faults([{"volunteer": "small", "side": "left"} | row])
    assert file.name in row["reason"]
    file.unlink()
    (row,) = batch(chain, tmp_path).rows(items(3))
    assert row["outcome"] == "converged"


def test_a_point_has_its_own_effects(chain, asked, tmp_path, monkeypatch):
    parts = quantities.Quantity("parts", ("body",), lambda chain: len(chain["body"].parts))
    monkeypatch.setattr(answers, "QUANTITIES", {"parts": parts})
    (point,) = items(1)
    bare = replace(
        point, name="bare", effects=sorted(chain.effects - {"skin"}), own={"body": "bare"}, stored={}
    )
    found = [row["answers"]["parts"] for row in batch(chain, tmp_path).rows([point, bare])]
    assert found[0] == found[1] + 1


def test_finished_points_are_not_computed_again_and_damaged_ones_are(chain, asked, tmp_path):
    first = list(batch(chain, tmp_path).rows(items(1, 2)))
    assert {row["outcome"] for row in first} == {"converged"}
    asked.clear()
    assert list(batch(chain, tmp_path).rows(items(1, 2, 3)))[:2] == first
    assert asked == [3]
    file = batch(chain, tmp_path).file(items(2)[0])
    file.write_text(file.read_text()[:40])
    asked.clear()
    (again,) = batch(chain, tmp_path).rows(items(2))
    assert asked == [2]
    assert again["answers"] == first[1]["answers"]


def test_what_two_batches_make_at_once_is_of_the_first_and_stays_while_it_is_read(
    chain, asked, tmp_path, monkeypatch
):
    save, said = meshed.save_mesh, []

    def after_another(mesh, files, job):
        save(mesh, files, job)
        if not said:
            folder = Path(files["mesh"]).parent
            there = folder.with_name(folder.name.split(".unfinished-")[0].removeprefix("."))
            shutil.copytree(folder, there)
            said.append((there, there.stat().st_ino))

    monkeypatch.setattr(meshed, "save_mesh", after_another)
    (row,) = batch(chain, tmp_path).rows(items(4, size=14.0))
    ((there, number),) = said
    assert row["outcome"] == "converged"
    assert there.stat().st_ino == number, "it was not taken away from its reader"
    assert list(there.parent.iterdir()) == [there]
    damaged = there / "mesh.vtu"
    damaged.unlink()
    (again,) = batch(chain, tmp_path).rows(items(6, size=14.0))
    assert damaged.exists()
    assert again["outcome"] == "converged"


def test_a_killed_batch_has_lost_one_point(chain, asked, tmp_path):
    with pytest.raises(KeyboardInterrupt):
        list(batch(chain, tmp_path).rows(items(1, 2, 19, 3)))
    assert len(list((tmp_path / "points").rglob("*.json"))) == 2
    asked.clear()
    rows = list(batch(chain, tmp_path).rows(items(1, 2, 3)))
    assert asked == [3]
    assert [row["outcome"] for row in rows] == ["converged"] * 3


def test_inputs_of_other_content_are_computed_again(chain, asked, tmp_path):
    labels = tmp_path / "labels.nii.gz"
    labels.write_bytes(b"one")
    item = replace(items(1)[0], kept={"labels": {"labels": str(labels)}})
    # The chain of the small breast has labels already: their file is only looked at.
    (one,) = batch(chain, tmp_path).rows([item])
    asked.clear()
    labels.write_bytes(b"other")
    (other,) = batch(chain, tmp_path).rows([item])
    assert asked == [1]
    assert one["inputs"] != other["inputs"]
    assert len(list((tmp_path / "products/mesh").iterdir())) == 2


def test_a_point_that_fails_says_why_and_stops_nobody(chain, asked, tmp_path):
    rejected = replace(items(5)[0], rejected="config/campaigns/mine.yaml: fat = 5: too much")
    rows = list(batch(chain, tmp_path).rows([*items(13, 23), rejected, *items(2, 29)]))
    outcomes = [row["outcome"] for row in rows]
    assert outcomes == ["failed", "converged", "rejected", "converged", "rejected"]
    assert rows[0]["reason"] == "the paddle slips at once"
    assert rows[1]["answers"]["stiff"] is None
    assert rows[1]["reason"] == "no finite number: stiff"
    assert rows[2]["reason"].endswith("too much")
    assert asked == [13, 23, 2, 29]
    assert json.loads(batch(chain, tmp_path).file(items(13)[0]).read_text())["outcome"] == "failed"


@pytest.fixture
def no_mesh(monkeypatch):
    """How often it was tried; `error`: what it fails with, None where it is made."""
    made, tried = meshed.mesh, SimpleNamespace(times=0, error=MeshError("elements are not attached"))

    def mesh(inputs):
        tried.times += 1
        if tried.error is not None:
            raise tried.error
        return made(inputs)

    monkeypatch.setattr("mammosim.chain.meshed.mesh", mesh)
    return tried


def outcomes(chain, folder, points, run):
    """Of a batch in a process of its own."""
    apart = replace(chain, made=dict(chain.made))
    return [(row["outcome"], row["reason"]) for row in batch(apart, folder, run).rows(points)]


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (MeshError("elements are not attached"), "elements are not attached"),
        (ZeroDivisionError("a mistake"), "fault of the program: ZeroDivisionError: a mistake"),
    ],
)
def test_what_points_share_is_tried_once_in_a_run_and_again_in_the_next(
    chain, asked, tmp_path, no_mesh, error, reason
):
    no_mesh.error = error
    assert outcomes(chain, tmp_path, items(1, 2, size=15.0), "a") == [("failed", reason)] * 2
    assert outcomes(chain, tmp_path, items(3, size=15.0), "a") == [("failed", reason)]
    assert no_mesh.times == 1
    # Other settings, other code, or another run: it may be made.
    assert outcomes(chain, tmp_path, [replace(items(4)[0], stored={"mesh": "finer"})], "a")[0][0] == "failed"
    assert no_mesh.times == 2
    no_mesh.error = None
    assert outcomes(chain, tmp_path, items(5, size=15.0), "b")[0][0] == "converged"
    assert no_mesh.times == 3
    # What was made is there for all runs.
    assert outcomes(chain, tmp_path, items(6, size=15.0), "a")[0][0] == "converged"
    assert no_mesh.times == 3


def test_other_inputs_or_code_are_tried_in_the_same_run(chain, asked, tmp_path, no_mesh, monkeypatch):
    labels = tmp_path / "labels.nii.gz"
    labels.write_bytes(b"one")
    point = replace(items(1)[0], kept={"labels": {"labels": str(labels)}})
    outcomes(chain, tmp_path, [point], "a")
    labels.write_bytes(b"other")
    outcomes(chain, tmp_path, [point], "a")
    assert no_mesh.times == 2
    monkeypatch.setitem(CODE, "mesh", "newer")
    outcomes(chain, tmp_path, [replace(point, name="0216")], "a")
    assert no_mesh.times == 3


def test_a_run_that_is_not_known_keeps_no_failure(chain, asked, tmp_path, no_mesh):
    for modulus in (1, 2):
        assert outcomes(chain, tmp_path, items(modulus), "")[0][0] == "failed"
    assert no_mesh.times == 2
    assert not (tmp_path / "products").exists()


@pytest.mark.parametrize("mode", [None, np.ones((2, 3))])
def test_a_failure_is_read_as_it_was(tmp_path, mode):
    failure = UnloadingError("half of the weight", load_factor=0.5, mode=mode)
    Failures("a").keep(failure, tmp_path / "unloaded/1")
    known = Failures("a").known(tmp_path / "unloaded/1")
    assert type(known) is UnloadingError
    assert (str(known), known.load_factor) == ("half of the weight", 0.5)
    assert (known.mode is None) == (mode is None)
    assert Failures("b").known(tmp_path / "unloaded/1") is None
    assert Failures("a").known(tmp_path / "unloaded/2") is None


def test_a_mistake_of_the_program_has_its_row_and_is_not_kept(chain, asked, tmp_path, caplog):
    rows = list(batch(chain, tmp_path).rows(items(1, 17, 2)))
    assert asked == [1, 17, 2]
    assert [row["outcome"] for row in rows] == ["converged", "failed", "converged"]
    assert rows[1]["reason"] == "fault of the program: ZeroDivisionError: a mistake of the program"
    assert rows[1]["answers"] == {}
    assert "Traceback" in caplog.text
    (fault,) = faults(rows)
    assert fault == "point 1716 (fat = 17): ZeroDivisionError: a mistake of the program"
    assert len(list((tmp_path / "points").rglob("*.json"))) == 2, "the fault is not kept as an answer"
    asked.clear()
    list(batch(chain, tmp_path).rows(items(1, 17, 2)))
    assert asked == [17], "it is computed again"


def test_a_disk_without_room_ends_the_batch(chain, asked, tmp_path, monkeypatch):
    def full(mesh, files, job):
        raise OSError(28, "No space left on device", files["mesh"])

    monkeypatch.setattr(meshed, "save_mesh", full)
    with pytest.raises(OSError, match="No space left"):
        list(batch(chain, tmp_path, "a").rows(items(1, 2, size=13.0)))
    assert not asked


def test_a_point_says_by_what_all_moduli_were_multiplied(chain):
    """Of what is pressed that of its set of moduli, of what hangs always that of the weight."""
    carried = SimpleNamespace(moduli_factor=1.5, mesh=None)
    heavy = chain.given({"stress_free": carried})
    other = heavy.with_settings({"load.moduli": "compression"}).given({"stress_free": carried})
    assert moduli_factor(heavy, {"pressed", "stress_free"}) == 1.5
    assert moduli_factor(other, {"pressed", "stress_free"}) == 1.0
    assert moduli_factor(other, {"loaded", "stress_free"}) == 1.5
    assert moduli_factor(heavy, {"mesh"}) is None
    fails = replace(chain, made=dict(chain.made))
    fails.made[fails.key("stress_free")] = Made(None, MeshError("no mesh"), 0.0)
    assert moduli_factor(fails, {"pressed", "stress_free"}) is None
