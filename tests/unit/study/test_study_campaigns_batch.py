"""A batch of points: what is finished stays, what is shared is made once, and failures stop nobody."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from small_breast import small_chain

from mammosim.chain import meshed, quantities
from mammosim.core.errors import EquilibriumError, MeshError
from mammosim.study.campaigns import batch as batches
from mammosim.study.campaigns.batch import Batch, Item

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
        modulus = chain["body"].tissues[batches_fat(chain)].youngs_modulus_kpa
        asked.append(modulus)
        if modulus == 13:
            raise EquilibriumError("the paddle slips\nat once", mode=None)
        if modulus == 17:
            raise ZeroDivisionError("a mistake of the program")
        if modulus == 19:
            raise KeyboardInterrupt
        return float("inf") if modulus == 23 else modulus * len(chain["mesh"].cells)

    found = quantities.Quantity(
        "stiffness", ("body", "mesh"), stiffness, noise=lambda chain: 0.5, column="stiff"
    )
    monkeypatch.setattr(batches, "QUANTITIES", {"stiffness": found})
    return asked


def batches_fat(chain):
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


def batch(chain, folder: Path) -> Batch:
    return Batch(chain, ["body", "mesh"], folder / "points", folder / "products", CODE)


def test_points_are_answered_with_their_errors_and_share_what_they_are_made_of(
    chain, asked, tmp_path, caplog
):
    caplog.set_level("INFO")
    one, two = batch(chain, tmp_path).rows(items(1, 2))
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
    rows = list(batch(chain, tmp_path).rows([*items(13, 23), rejected, *items(2)]))
    assert [row["outcome"] for row in rows] == ["failed", "converged", "rejected", "converged"]
    assert rows[0]["reason"] == "the paddle slips at once"
    assert rows[1]["answers"]["stiff"] is None
    assert rows[1]["reason"] == "no finite number: stiff"
    assert rows[2]["reason"].endswith("too much")
    assert asked == [13, 23, 2]
    assert json.loads(batch(chain, tmp_path).file(items(13)[0]).read_text())["outcome"] == "failed"


def test_what_cannot_be_meshed_fails_every_point_that_shares_it(chain, asked, tmp_path, monkeypatch):
    def no_mesh(inputs):
        raise MeshError("elements of 16 mm are not attached")

    monkeypatch.setattr("mammosim.chain.meshed.mesh", no_mesh)
    rows = list(batch(chain, tmp_path).rows(items(1, 2, size=15.0)))
    assert {(row["outcome"], row["reason"]) for row in rows} == {
        ("failed", "elements of 16 mm are not attached")
    }
    assert not (tmp_path / "products").exists()


def test_a_mistake_of_the_program_fails_the_job_after_the_other_points(chain, asked, tmp_path):
    found = []
    with pytest.raises(RuntimeError, match=r"1 points ended in a fault .*1716.*ZeroDivisionError: a mistake"):
        found.extend(batch(chain, tmp_path).rows(items(1, 17, 2)))
    assert asked == [1, 17, 2]
    assert len(list((tmp_path / "points").rglob("*.json"))) == 2, "the fault is not kept as an answer"
