"""The answer of a study is made of whatever tables are there, also of none."""

import pandas as pd
import pytest

from mammosim.io.tables import read_rows, write_table

KEYS = {"volunteer": "ada", "side": "left", "moduli": "gravity"}
PRESSED = KEYS | {"tilt_deg": 0.0, "deflection_mm": 0.0, "thickness_from": "given", "moduli_factor": 1.0,
                  "outcome": "converged"}  # fmt: skip
IMAGE = KEYS | {"dose_se_mgy": 0.01, "cnr_quantum": 3.0, "lesion_pixels": 200,
                "calcification_d_expected": 8.0, "calcification_d_low": 7.0,
                "calcification_d_high": 9.0}  # fmt: skip
ONE = "ada was scanned in one position, two are needed"


def pressed(strategy: str, mm: float, newton: float) -> dict:
    strength = {"force_n": newton, "mean_pressure_kpa": newton / 10, "logarithmic_p95": 20 / mm}
    return PRESSED | {"strategy": strategy, "thickness_mm": mm} | strength


@pytest.fixture
def answered(script, repository, tmp_path):
    """The three tables of a study of ada's left breast."""

    def made(tables: dict[str, list[dict]], voxel_mm: float = 1.0, not_planned=()) -> list[pd.DataFrame]:
        for name, rows in tables.items():
            write_table(pd.DataFrame(rows), tmp_path / f"{name}.csv")
        out = {name: str(tmp_path / f"out_{name}.csv") for name in ("answer", "strategies", "limits")}
        settings = {
            "loss_percent": {"dose": 5.0, "detectability": 5.0},
            "xray": {"voxel_mm": voxel_mm, "energies": 20, "scatter_error_percent": 2.0, "rays_per_pixel": 1},
            "volunteers": ["ada"],
            "known": {"sides": ["left"], "digital": [], "not_planned": list(not_planned)},
        }
        files = {
            "tables": [str(tmp_path / f"{name}.csv") for name in tables],
            "measured": str(repository / "config/accuracy/measured.csv"),
        }
        script("answer").main(files, settings, out)
        return [read_rows(path) for path in out.values()]

    return made


def test_a_study_in_which_nobody_is_pressed_says_why(answered):
    answer, strategies, limits = answered(
        {}, not_planned=[["ada", "compression", "ada was not scanned prone"]]
    )
    assert strategies.empty
    left = answer.set_index("side").loc["left"]
    assert left.sentence.endswith("compression can be reduced**: ada was not scanned prone.")
    assert pd.isna(answer.set_index("side").sentence["right"])
    assert limits.because[0] == "ada was not scanned prone"


def test_where_only_the_standard_is_x_rayed_what_the_others_cost_is_not_known(answered):
    tables = {
        "compression": [pressed("standard", 50.0, 2.0), pressed("reduced", 60.0, 1.0)],
        "image": [IMAGE | {"strategy": "standard", "dose_mgy": 2.0}],
    }
    answer, strategies, limits = answered(tables, not_planned=[["ada", "fit of moduli", ONE]])
    left = answer.set_index("side").loc["left"]
    assert (left.verdict, left.not_known) == ("cannot be said", "reduced")
    assert "`reduced` (60.0 mm, 1.00 N)" in left.sentence
    assert set(strategies.strategy) == {"standard", "reduced"}
    assert limits.what_would_say_it[0] == "more names in compression.strategies and xray.strategies"
    assert limits.because.str.endswith(ONE).any()


def test_settings_whose_errors_were_not_measured_leave_the_mass_open(answered):
    tables = {
        "compression": [pressed("standard", 50.0, 2.0), pressed("reduced", 51.0, 1.9)],
        "image": [IMAGE | {"strategy": name, "dose_mgy": 2.0} for name in ("standard", "reduced")],
    }
    measured, coarse = answered(tables), answered(tables, voxel_mm=2.2)
    numbers = [tables[1].set_index(["strategy", "quantity"]) for tables in (measured, coarse)]
    masses = [each.loc[("reduced", "mass_d")] for each in numbers]
    assert masses[0].change_high_percent > 5
    assert masses[1].change_high_percent < masses[0].change_high_percent, "of the pixels alone"
    assert masses[1].interval_from == "pixels"
    assert (masses[0].complete, masses[1].complete) == (True, False)
    assert coarse[2].cannot_be_said.str.startswith("how sure the change of d' of the mass is").any()
