"""The comparison with other programs: what is not installed is a row that says so, misprints are refused."""

import pandas as pd
import pytest

pytestmark = pytest.mark.workflow


@pytest.fixture(scope="module")
def rows(study) -> pd.DataFrame:
    """mammosim, and a program that the copy of the study has no environment for."""
    files = [f"results/peers/stiff/20mm_{program}.csv" for program in ("mammosim", "felupe")]
    outcome = study.snakemake(*files)
    assert outcome.returncode == 0, outcome.stdout[-4000:]
    return pd.concat([pd.read_csv(study.run / file) for file in files]).set_index("program")


def test_mammosim_converges_to_the_residual_asked_for(rows):
    ours = rows.loc["mammosim"]
    assert ours.outcome == "converged"
    assert ours.residual <= 1e-8
    assert ours.apex_mm == pytest.approx(13.2, abs=0.1)  # 13.39 at 8 mm, and coarser is stiffer
    assert 0 < ours.cpu_s < 60


def test_what_is_not_installed_says_how_to_install_it(rows):
    assert rows.loc["felupe"].outcome == "not installed: make peers"
    assert pd.isna(rows.loc["felupe"].apex_mm)


def test_a_misspelt_program_is_refused(study, tmp_path):
    text = (study.home / "config/peers_smoke.yaml").read_text().replace("felupe", "felupi")
    (tmp_path / "wrong.yaml").write_text(text)
    (tmp_path / "extra.yaml").write_text(f"peers: {tmp_path / 'wrong.yaml'}\n")
    smoke = study.home / "config/smoke.yaml"
    message = study.snakemake("--dry-run", "--configfile", str(smoke), str(tmp_path / "extra.yaml"))
    assert message.returncode != 0
    assert "choose one of" in message.stdout
