"""The page of what was done is made of tables and figures as they are, and of why others are missing."""

import re
from base64 import b64encode

import pandas as pd
from matplotlib.figure import Figure

from mammosim.io.figures import write_figure
from mammosim.io.missing import write_missing
from mammosim.io.tables import write_table

ROWS = [
    {
        **{
            "position": "prone",
            "used": True,
            "there": True,
            "files": {"labels": "l.nii.gz"},
            "gravity": "0 -1 0",
        },
        **{"how": {"series": "t1 fs", "gaps": "resample"}, "codes": {"codes": "victre"}},
    }
]


def cells(page: str) -> str:
    """The page with cells of tables by what they hold, whatever kind of column they are in."""
    return re.sub(r'<td class="\w+">', "<td>", page)


def test_of_a_woman_who_cannot_be_pressed_the_page_has_the_reason(script, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    reason = "stress_free ada prone: no stress-free shape carries the weight, by anderson or inverse"
    paths = {name: f"results/{name}.csv" for name in ("stress_free_attempts", "compression", "image")}
    for path in paths.values():
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        write_missing(path, reason, job={"volunteer": "ada", "position": "prone"})
    write_figure(Figure(), "results/stress_free_ada.png", missing=reason)
    told = {
        "tables": {name: [path] for name, path in paths.items()},
        "planned": [("compression", "")],
        "gains": [],
        "thickness": "Half of her depth.",
        "modelled": "prone",
    }
    script("what").main("ada", ROWS, told, ["results/stress_free_ada.png"], "what.html")
    page = (tmp_path / "what.html").read_text()
    assert page.count(f"missing: {reason}") == len(paths), "in the place of each answer"
    (row,) = [line for line in cells(page).split("<tr>") if line.startswith(f"<td>{reason}</td>")]
    assert "stress_free_attempts, compression, image</td><td>stress_free_ada" in row


def test_what_is_there_is_linked_and_what_is_missing_is_told_once(script, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    pressed, image = "results/compression/ada/standard.csv", "results/xray/ada/standard_image.csv"
    there, gone = "results/study/figures/mesh_ada.png", "results/study/figures/mammogram_ada.png"
    for path in (pressed, image, there, "results/women/ada/what.html"):
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
    row = {"side": ["left"], "strategy": "standard", "moduli": "gravity", "plates_mm": 38.0, "force_n": 3.2}
    write_table(pd.DataFrame(row | {"thickness_from": "chosen: 0.5 of the 76 mm"}), pressed)
    other = pressed.replace("standard", "firm")
    write_table(pd.DataFrame(row | {"strategy": "firm", "thickness_from": "given", "force_n": 7.9}), other)
    write_missing(image, "image_row ada left: the field is too narrow", job={"side": "left"})
    write_figure(Figure(), there)
    write_figure(Figure(), gone, missing="image_row ada left: the field is too narrow")
    told = {
        "tables": {"compression": [pressed, other], "image": [image]},
        "planned": [("mesh", "")],
        "gains": [(("a supine series",), ["fit of moduli"])],
        "thickness": "Half of her depth.",
        "modelled": "prone",
    }
    script("what").main("ada", ROWS, told, [there, gone], "results/women/ada/what.html")
    page = (tmp_path / "results/women/ada/what.html").read_text()
    assert f'href="../../../{pressed}"' in page
    assert b64encode((tmp_path / there).read_bytes()).decode() in page, "the picture itself"
    assert page.count("data:image/png") == 1
    assert "chosen: 0.5 of the 76 mm" in page
    assert ">7.9</td>" in page, "of every table of one name"
    assert f'href="../../../{other}"' in page
    assert "Half of her depth." in page
    for given in ("l.nii.gz", "t1 fs", "resample", "victre"):
        assert f"<td>{given}</td>" in cells(page), "what was given, and how it was to be read"
    (row,) = [
        line
        for line in cells(page).split("<tr>")
        if "<td>image_row ada left: the field is too narrow</td><td>" in line
    ]
    assert "mammogram_ada" in row, "the figure that lacks it"
    assert "a supine series" in page


def test_the_position_that_she_is_modelled_in_is_not_listed_as_a_prediction(script, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rows = [
        {"position": position, "quantity": "skin_mean", "value_mm": value, "outcome": "converged"}
        for position, value in (("prone", 1e-9), ("supine", 1.25))
    ]
    write_table(pd.DataFrame(rows), "validation.csv")
    told = {"tables": {"validation": ["validation.csv"]}, "planned": [], "gains": [], "thickness": ""}
    script("what").main("ada", ROWS, told | {"modelled": "prone"}, [], "what.html")
    page = (tmp_path / "what.html").read_text()
    assert ">1.25</td>" in page
    assert "made of the prone series" in page
