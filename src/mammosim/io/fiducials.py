"""Lists of named points: our CSV, and the point lists of 3D Slicer; in memory always LPS, mm."""

import csv
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from mammosim.core.errors import FiducialError, MissingResult
from mammosim.core.fiducials import KINDS, NAMES, Fiducials, advice_on, kind_of, usual_name
from mammosim.io.atomic import replacing
from mammosim.io.given import ends_whole, given_json, given_table, given_text, numbers
from mammosim.io.missing import missing_rows, reason_of, require_there
from mammosim.io.tables import write_table

AXES = ("x_mm", "y_mm", "z_mm")
COLUMNS = ("name", "kind", *AXES)
FCSV_COLUMNS = "id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID"
RAS_TO_LPS = np.array([-1.0, -1.0, 1.0])
MM = {"mm": 1.0, "um": 1e-3, "cm": 10.0, "m": 1000.0}
NOT_PLACED = "is not placed; place it, or delete it from the list"
# What a point lacks by the status of its position, in the order of Slicer's numbers from 0.
LACKING = {
    "undefined": NOT_PLACED,
    "preview": NOT_PLACED,
    "defined": "",
    "missing": "was skipped (positionStatus missing); place it, or delete it from the list",
}
BY_NUMBER = dict(enumerate(LACKING.values()))


def read_fiducials(path: str | Path) -> Fiducials:
    """Read `.csv` (name, kind, x_mm, y_mm, z_mm; or the table of 3D Slicer), Slicer `.fcsv` or `.mrk.json`.

    Names are those of core.fiducials; 'Breast 1' is read as breast_1. Without kinds, the name tells it.
    Raises FiducialError, which names file and point: absent, another format, a missing column, no finite
    number, a point that was not placed, an unknown name, unit or frame; MissingResult as every reader.
    """
    path = Path(path)
    if not path.is_file():
        raise FiducialError(f"no fiducial list {path}; mark the points, or correct the path")
    require_there(path)
    for ending, read in {".mrk.json": _markups, ".fcsv": _fcsv, ".csv": _from_table}.items():
        if path.name.lower().endswith(ending):
            return _whole(read(path), path)
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


def _whole(found: Fiducials, path: Path) -> Fiducials:
    """The same. Raises FiducialError where lines end early, and so does the list."""
    absent = [name for name in NAMES if name not in found.names]
    if absent and path.suffix.lower() != ".json" and not ends_whole(path):
        raise FiducialError(
            f"{path}: its last line has no end, and {', '.join(absent)} are missing: was it cut off? copy it "
            "again, or end the last line if nothing more was marked"
        )
    return found


def _from_table(path: Path) -> Fiducials:
    if given_text(path).strip() == ",".join(COLUMNS):  # as a stage writes it where nobody marked anything
        return Fiducials((), (), np.empty((0, 3)))
    table = given_table(path, error=FiducialError, columns=COLUMNS)
    if "outcome" in table and missing_rows(table).all():
        raise MissingResult(reason_of(str(table["outcome"].iloc[0])))
    table = table.rename(columns={name: name.lower() for name in table})
    table = table.rename(columns={"label": "name", **dict(zip(("l", "p", "s"), AXES))})
    sign = RAS_TO_LPS if {"r", "a"} <= set(table) else np.ones(3)
    table = table.rename(columns=dict(zip(("r", "a"), AXES)))
    if missing := [name for name in ("name", *AXES) if name not in table]:
        raise FiducialError(f"{path} lacks {', '.join(missing)}; its header must be: {','.join(COLUMNS)}")
    names = ["" if pd.isna(name) else str(name) for name in table["name"]]
    _require_kinds(table, names, path)
    placed = table["defined"] != 0 if "defined" in table else [True] * len(table)
    points = sign * numbers(table, AXES)
    return _checked(
        [
            _Given(name, point, "" if there else NOT_PLACED, f"row {number} ({name})")
            for number, (name, point, there) in enumerate(zip(names, points, placed), 1)
        ],
        path,
    )


def _require_kinds(table: pd.DataFrame, names: list[str], path: Path) -> None:
    """Raise FiducialError where a column of kinds contradicts the names."""
    for number, (name, kind) in enumerate(zip(names, table.get("kind", [])), 1):
        if kind not in KINDS:
            raise FiducialError(
                f"{path}: row {number} ({name}) has unknown kind {kind!r}; choose one of: {', '.join(KINDS)}"
            )
        if (meant := usual_name(name)) and kind_of(meant) != kind:
            raise FiducialError(
                f"{path}: row {number}: kind {kind!r} contradicts the name {name!r}; correct one of them"
            )


@dataclass(frozen=True)
class _Given:
    """A point as it was written: position (3,) in LPS and mm, None without; where: it stands in its file.

    lacking: why it has no place, '' where it has one.
    """

    name: str
    position: np.ndarray | None
    lacking: str
    where: str


def _checked(points: list[_Given], path: Path) -> Fiducials:
    """Raises FiducialError, which names file and point: no point, no name of ours, twice, no place."""
    if not points:
        raise FiducialError(f"{path} lists no point; mark chest_1 to chest_4, nipple_left and nipple_right")
    meant = [usual_name(each.name) for each in points]
    for each, name in zip(points, meant):
        if not name:
            raise FiducialError(f"{path}: {each.name!r} is no name of a point; {advice_on(each.name, meant)}")
        if meant.count(name) > 1:
            raise FiducialError(f"{path}: {name} stands twice; fiducial names must be unique")
        if each.lacking:
            raise FiducialError(f"{path}: {each.where} {each.lacking}")
        if each.position is None or not np.all(np.isfinite(each.position)):
            raise FiducialError(f"{path}: {each.where} has no three finite numbers in mm; mark it again")
    kinds = tuple(kind_of(name) for name in meant)
    return Fiducials(tuple(meant), kinds, np.array([each.position for each in points], float))


def _sign(system: Any, path: Path) -> np.ndarray:
    """Factors (3,) to LPS of a Slicer coordinate system, named or numbered (0 RAS, 1 LPS)."""
    system = str(system).strip().upper()
    if system in ("LPS", "1"):
        return np.ones(3)
    if system in ("RAS", "0"):
        return RAS_TO_LPS
    raise FiducialError(f"{path}: unknown coordinate system {system!r}; choose one of: LPS, RAS")


def _millimetres(units: Any, path: Path) -> float:
    """The length in mm of a unit, a UCUM code or a DICOM triple of which that is the first."""
    code = units[0] if isinstance(units, list) and units else units
    if code not in MM:
        raise FiducialError(f"{path}: unknown coordinateUnits {code!r}; choose one of: {', '.join(MM)}")
    return MM[str(code)]


def _markups(path: Path) -> Fiducials:
    """The control points of every list of points in the file, each in its own frame and unit."""
    try:
        every = given_json(path, error=FiducialError)["markups"]
        lists = [each for each in every if each.get("type", "Fiducial") == "Fiducial"]
        return _checked([point for each in lists for point in _controls(each, path)], path)
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise FiducialError(f"{path} is not a point list as 3D Slicer writes it; export it again") from error


def _controls(markups: dict[str, Any], path: Path) -> list[_Given]:
    """Raises FiducialError for an unknown frame or unit."""
    scale = _sign(markups.get("coordinateSystem", "LPS"), path)
    scale = scale * _millimetres(markups.get("coordinateUnits", "mm"), path)
    return [
        _Given(
            label := str(point.get("label", "")),
            _scaled(point.get("position"), scale),
            LACKING.get(str(point.get("positionStatus", "defined")).lower(), NOT_PLACED),
            label,
        )
        for point in markups.get("controlPoints") or ()
    ]


def _scaled(position: Any, scale: np.ndarray) -> np.ndarray | None:
    """The position (3,) in LPS and mm; None where there are no three numbers."""
    if not isinstance(position, list) or len(position) != 3:
        return None
    try:
        placed: np.ndarray = scale * np.array(position, float)
    except (TypeError, ValueError):
        return None
    return placed if placed.shape == (3,) else None


def _fcsv(path: Path) -> Fiducials:
    """Points of a header `# key = value` with or without blanks, and rows; a list of Slicer 4 or 5."""
    lines = given_text(path).splitlines()
    pairs = [line.lstrip("# ").split("=", 1) for line in lines if line.startswith("#") and "=" in line]
    header = {key.strip().lower(): value.strip() for key, value in pairs}
    sign = _sign(header.get("coordinatesystem", "RAS"), path)
    columns = [name.strip() for name in header.get("columns", FCSV_COLUMNS).split(",")]
    rows = csv.DictReader([line for line in lines if not line.startswith("#") and line.strip()], columns)
    try:
        return _checked(
            [
                _Given(
                    (row["label"] or "").strip(),
                    sign * np.array([row["x"], row["y"], row["z"]], float),
                    # Beyond the columns that its header names, Slicer 5 writes the status of the position.
                    BY_NUMBER.get(int((row.get(None) or ["2"])[0] or 2), NOT_PLACED),
                    f"row {number} ({row['label']})",
                )
                for number, row in enumerate(rows, 1)
            ],
            path,
        )
    except (ValueError, KeyError, TypeError) as error:
        raise FiducialError(f"{path} is not a Slicer fiducial list: {error}; export it again") from error


def _write_text(text: str, path: Path) -> None:
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _fcsv_text(fiducials: Fiducials) -> str:
    head = f"# Markups fiducial file version = 4.11\n# CoordinateSystem = LPS\n# columns = {FCSV_COLUMNS}\n"
    points = np.asarray(fiducials.points, float).tolist()
    rows = [
        f"{k},{x!r},{y!r},{z!r},0,0,0,1,1,1,0,{name},,\n"
        for k, (name, (x, y, z)) in enumerate(zip(fiducials.names, points), start=1)
    ]
    return head + "".join(rows)


def _markups_of(fiducials: Fiducials) -> dict[str, Any]:
    points = [
        {"id": str(k), "label": name, "position": point, "positionStatus": "defined"}
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
        "markups": [
            {
                "type": "Fiducial",
                "coordinateSystem": "LPS",
                "coordinateUnits": "mm",
                "controlPoints": points,
            }
        ],
    }
