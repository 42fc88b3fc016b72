"""A file that a rule wrote and that was cut short later is damaged, whatever it holds, and no outcome."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from mammosim.core.errors import DamagedFile, MeshError, MissingResult, TableError, written
from mammosim.core.fiducials import Fiducials
from mammosim.core.rigid import IDENTITY
from mammosim.core.volume import Grid, Image, LabelMap
from mammosim.io import fiducials, images
from mammosim.io.meshes import read_mesh, read_mesh_arrays, write_mesh, write_mesh_arrays
from mammosim.io.missing import write_missing
from mammosim.io.tables import read_json, read_table, write_json, write_table
from mammosim.io.transforms import read_transform, write_transform
from mammosim.io.written import read_fiducials, read_image, read_labels
from mammosim.meshing.shapes import box

GRID = Grid((4, 5, 6), np.ones(3), np.zeros(3), np.eye(3))
POINTS = Fiducials(
    ("nipple_left", "nipple_right"), ("nipple", "nipple"), np.array([[60.0, -90.0, 0.0], [-60.0, -90.0, 0.0]])
)
Write = Callable[[Any, Path], None]
KINDS: dict[str, tuple[str, Any, Write, Callable[[Path], Any]]] = {
    "table": ("t.csv", pd.DataFrame({"a": [1.0, 2.0]}), write_table, read_table),
    "json": ("t.json", {"a": [1, 2]}, write_json, read_json),
    "mesh": ("m.vtu", box((1, 1, 1), (20.0, 20.0, 20.0)), write_mesh, read_mesh),
    "arrays": ("m.npz", box((1, 1, 1), (20.0, 20.0, 20.0)), write_mesh_arrays, read_mesh_arrays),
    "transform": ("t.tfm", IDENTITY, write_transform, read_transform),
    "image": ("i.nii.gz", Image(GRID, np.ones(GRID.shape)), images.write_image, read_image),
    "labels": ("l.nii.gz", LabelMap(GRID, np.ones(GRID.shape, np.uint8)), images.write_labels, read_labels),
    "points": ("p.csv", POINTS, fiducials.write_fiducials, read_fiducials),
}


@pytest.mark.parametrize("kind", KINDS)
def test_a_file_cut_short_after_it_was_written_is_damaged(kind: str, tmp_path: Path) -> None:
    name, product, write, read = KINDS[kind]
    write(product, path := tmp_path / name)
    read(path)
    content = path.read_bytes()
    path.write_bytes(content[: len(content) - 5])
    with pytest.raises(DamagedFile, match=re.escape(name)):
        read(path)


@pytest.mark.parametrize("kind", KINDS)
def test_a_missing_result_stays_missing(kind: str, tmp_path: Path) -> None:
    name, _, _, read = KINDS[kind]
    write_missing(path := tmp_path / name, "the field is too narrow")
    with pytest.raises(MissingResult, match="the field is too narrow"):
        read(path)


def test_what_a_person_wrote_is_wrong_and_not_damaged(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text("a,b\n1,2\n3\n")
    with pytest.raises(TableError, match="row 2 has 1 of 2 cells") as caught:
        read_table(tmp_path / "t.csv", by_hand=True)
    assert not isinstance(caught.value, DamagedFile)


def test_any_other_fault_of_a_file_that_was_written_is_damage() -> None:
    with pytest.raises(DamagedFile, match="no tissue"), written():
        raise MeshError("m.vtu has no tissue")


def test_scripts_read_images_and_points_of_the_study_as_such() -> None:
    """Only the check of what a woman brings reads these as given by a person."""
    scripts = Path(__file__).parents[3] / "workflow/scripts"
    otherwise = re.compile(r"from mammosim\.io\.(images|fiducials) import .*\bread_")
    found = {path.name for path in scripts.rglob("*.py") if otherwise.search(path.read_text())}
    assert found == {"check_input.py"}
