"""Lists of named points: our CSV, and the point lists of 3D Slicer; in memory always LPS, mm."""

import csv
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from mammosim.core.errors import FiducialError
from mammosim.core.fiducials import KINDS, Fiducials
from mammosim.io.atomic import replacing
from mammosim.io.tables import read_table, write_table

COLUMNS = ("name", "kind", "x_mm", "y_mm", "z_mm")
RAS_TO_LPS = np.array([-1.0, -1.0, 1.0])


def read_fiducials(path: str | Path) -> Fiducials:
    """Read `.csv` (name, kind, x_mm, y_mm, z_mm), Slicer `.fcsv` or `.mrk.json`.

    Slicer lists have no kinds: it is read from the name, e.g. chest_1, breast_3, nipple_left.
    Raises FiducialError: absent, another format, a missing column, no number, a name without a kind.
    """
    path = Path(path)
    if not path.is_file():
        raise FiducialError(f"no fiducial list {path}; mark the points, or correct the path")
    if path.name.endswith(".mrk.json"):
        return _from_points(_markups(path), path)
    if path.suffix == ".fcsv":
        return _from_points(_fcsv(path), path)
    if path.suffix == ".csv":
        return _from_table(read_table(path), path)
    raise FiducialError(f"{path}: unknown format {path.suffix!r}; choose one of: .csv, .fcsv, .mrk.json")


def write_fiducials(fiducials: Fiducials, path: str | Path) -> None:
    """Write `.csv`, `.fcsv` or `.mrk.json`, complete or absent. Raises FiducialError otherwise."""
    path = Path(path)
    if path.suffix == ".csv":
        x, y, z = np.asarray(fiducials.points, float).reshape(-1, 3).T
        columns = (fiducials.names, fiducials.kinds, x, y, z)
        write_table(pd.DataFrame(dict(zip(COLUMNS, columns))), path)
    elif path.suffix == ".fcsv":
        _write_text(_fcsv_text(fiducials), path)
    elif path.name.endswith(".mrk.json"):
        _write_text(json.dumps(_markups_of(fiducials), indent=1) + "\n", path)
    else:
        raise FiducialError(f"{path}: unknown format {path.suffix!r}; choose one of: .csv, .fcsv, .mrk.json")


def _from_table(table: pd.DataFrame, path: Path) -> Fiducials:
    if missing := [name for name in COLUMNS if name not in table]:
        raise FiducialError(f"{path} lacks {', '.join(missing)}; its header must be: {','.join(COLUMNS)}")
    numbers = table[list(COLUMNS[2:])].apply(pd.to_numeric, errors="coerce")
    bad = table.index[numbers.isna().any(axis=1)]
    if len(bad):
        raise FiducialError(f"{path}: row {bad[0] + 1} ({table['name'][bad[0]]}) has no three numbers in mm")
    names, kinds = (tuple(table[key].astype(str)) for key in ("name", "kind"))
    return Fiducials(names, kinds, numbers.to_numpy(float))


def _from_points(named: list[tuple[str, np.ndarray]], path: Path) -> Fiducials:
    names = tuple(name for name, _ in named)
    points = np.array([point for _, point in named], float).reshape(-1, 3)
    return Fiducials(names, tuple(_kind(name, path) for name in names), points)


def _kind(name: str, path: Path) -> str:
    kind = re.split(r"[_\-\s]", name.lower())[0]
    if kind not in KINDS:
        raise FiducialError(
            f"{path}: the name {name!r} begins with no kind; name the points chest_1..4, breast_1..6, "
            "nipple_left and nipple_right"
        )
    return kind


def _sign(system: Any, path: Path) -> np.ndarray:
    """Factors (3,) to LPS of a Slicer coordinate system, named or numbered (0 RAS, 1 LPS)."""
    system = str(system).strip().upper()
    if system in ("LPS", "1"):
        return np.ones(3)
    if system in ("RAS", "0"):
        return RAS_TO_LPS
    raise FiducialError(f"{path}: unknown coordinate system {system!r}; choose one of: LPS, RAS")


def _markups(path: Path) -> list[tuple[str, np.ndarray]]:
    try:
        (markups,) = json.loads(path.read_text(encoding="utf-8"))["markups"]
        sign = _sign(markups.get("coordinateSystem", "LPS"), path)
        return [(p["label"], sign * np.array(p["position"], float)) for p in markups["controlPoints"]]
    except (ValueError, KeyError, TypeError) as error:
        raise FiducialError(
            f"{path} is not a Slicer point list; export one list of points ({error})"
        ) from error


def _fcsv(path: Path) -> list[tuple[str, np.ndarray]]:
    lines = path.read_text(encoding="utf-8").splitlines()
    header = dict(
        line.lstrip("# ").split(" = ", 1) for line in lines if line.startswith("#") and " = " in line
    )
    sign = _sign(header.get("CoordinateSystem", "RAS"), path)
    columns = header.get("columns", "id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID").split(
        ","
    )
    rows = csv.DictReader([line for line in lines if not line.startswith("#") and line], fieldnames=columns)
    try:
        return [(row["label"], sign * np.array([row["x"], row["y"], row["z"]], float)) for row in rows]
    except (ValueError, KeyError, TypeError) as error:
        raise FiducialError(f"{path} is not a Slicer fiducial list: {error}; export it again") from error


def _write_text(text: str, path: Path) -> None:
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _fcsv_text(fiducials: Fiducials) -> str:
    head = (
        "# Markups fiducial file version = 4.11\n# CoordinateSystem = LPS\n"
        "# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n"
    )
    points = np.asarray(fiducials.points, float).tolist()
    rows = [
        f"{k},{x!r},{y!r},{z!r},0,0,0,1,1,1,0,{name},,\n"
        for k, (name, (x, y, z)) in enumerate(zip(fiducials.names, points), start=1)
    ]
    return head + "".join(rows)


def _markups_of(fiducials: Fiducials) -> dict[str, Any]:
    points = [
        {"id": str(k), "label": name, "position": point}
        for k, (name, point) in enumerate(
            zip(fiducials.names, np.asarray(fiducials.points, float).tolist()), start=1
        )
    ]
    schema = (
        "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/"
        "markups-schema-v1.0.3.json#"
    )
    return {
        "@schema": schema,
        "markups": [{"type": "Fiducial", "coordinateSystem": "LPS", "controlPoints": points}],
    }
