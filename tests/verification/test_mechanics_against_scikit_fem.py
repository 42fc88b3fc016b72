"""The forms of scikit-fem, assembled by it, have the same equilibrium as the compiled kernels."""

import json
import subprocess
import sys

import numpy as np
import pytest

from mammosim.io.meshes import write_mesh_arrays
from mammosim.mechanics.body import load
from mammosim.study.peers.mechanics import AWAY_FROM_THE_HELD_FACE, Case, hemisphere

SKIN = {"youngs_modulus_kpa": 10.0, "poisson_ratio": 0.45, "thickness_mm": 4.0}


@pytest.mark.parametrize("skin", [{}, {"layer": SKIN}])
def test_scikit_fem_finds_the_same_equilibrium(repository, tmp_path, skin):
    case = Case.of({"youngs_modulus_kpa": 1.0, "poisson_ratio": 0.45} | skin)
    mesh = hemisphere(25.0, layer_mm=4.0 if skin else 0.0)
    files = [str(tmp_path / name) for name in ("mesh.npz", "mesh.npz", "case.json", "found.npz")]
    write_mesh_arrays(mesh, files[0])
    (tmp_path / "case.json").write_text(json.dumps(case.facts() | {"tolerance": 1e-10, "load_steps": 1}))
    adapter = repository / "workflow/scripts/peers/with_scikit_fem.py"
    subprocess.run([sys.executable, str(adapter), *files], check=True)
    with np.load(files[3]) as found:
        assert found["outcome"] == "converged"
        u = found["u"]
    ours = load(mesh, case.tissues, AWAY_FROM_THE_HELD_FACE).points - mesh.points
    # Forces out of balance by 1e-8 of the weight move nodes by about 1e-8 of the displacement, times the
    # condition of the elements, below 100 here.
    assert np.abs(u - ours).max() <= 1e-6 * np.abs(ours).max()
