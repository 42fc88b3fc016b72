"""A quantity is the number that its name says, from its column, and changes are in the unit of its name."""

from types import SimpleNamespace

import numpy as np
import pytest

from mammosim.chain.quantities import QUANTITIES, nipple_of, quantities
from mammosim.core.errors import ConfigurationError

PRESSED = {"force_n": 90.0, "plates_mm": 51.0, "thickness_mm": 50.0, "thickness_max_mm": 54.0,
           "mean_pressure_kpa": 8.0, "peak_pressure_kpa": 30.0, "logarithmic_p95": 0.4,
           "green_lagrange_p95": 0.6}  # fmt: skip
SEEN = {"scatter_to_primary": 0.5, "cnr": 3.0, "cnr_quantum": 4.0, "calcification_d": 5.0,
        "calcification_d_low": 5.0 - 1.96 * 0.3, "calcification_d_high": 5.0 + 1.96 * 0.3,
        "calcification_d_expected": 6.0}  # fmt: skip
CHAIN = {
    "pressed": SimpleNamespace(row=PRESSED),
    "mammogram": SimpleNamespace(row=SEEN),
    "exposure": 70.0,
    "exposed_dose": SimpleNamespace(dose_mgy=1.5, dose_se_mgy=0.03),
    "dose": SimpleNamespace(mgy_per_mas=0.02, relative_error=0.01),
    "slices": SimpleNamespace(cnr=lambda method: {"sart": 2.0, "filtered_backprojection": 1.0}[method]),
}
VALUES = {
    **{
        "force_n": 90.0,
        "thickness_mm": 50.0,
        "pressure_kpa": 8.0,
        "strain_percent": 0.4,
        "mas_percent": 70.0,
    },
    **{"agd_percent": 1.5, "scatter_to_primary": 0.5, "cnr_percent": 4.0, "d_percent": 6.0},
    **{"d_estimated_percent": 5.0, "slice_cnr_percent": 2.0},
}


def test_each_quantity_is_taken_from_its_column_of_the_products_that_it_names():
    assert set(VALUES) | {"nipple_mm"} == set(QUANTITIES)
    for name, value in VALUES.items():
        needed = {product: CHAIN[product] for product in QUANTITIES[name].products}
        assert QUANTITIES[name].of(needed) == value, name


def test_the_noise_of_an_answer_is_its_relative_standard_error():
    assert QUANTITIES["d_estimated_percent"].noise(CHAIN) == pytest.approx(0.3 / 5.0)
    assert QUANTITIES["agd_percent"].noise(CHAIN) == 0.01


def test_changes_are_in_percent_of_the_reference_where_the_name_says_so():
    for name, quantity in QUANTITIES.items():
        change = quantity.change(4.0, 5.0)
        assert change == pytest.approx(20.0 if name.endswith("percent") else 1.0), name
    assert QUANTITIES["nipple_mm"].change(np.array([3.0, 4.0, 1.0]), np.array([0.0, 0.0, 1.0])) == 5.0


def test_what_is_over_noise_means_nothing_without_it():
    needing = {name for name, quantity in QUANTITIES.items() if quantity.means_with == ("quantum_noise",)}
    assert needing == {"cnr_percent", "d_percent", "d_estimated_percent", "slice_cnr_percent"}


def test_the_nipple_moves_with_the_skin_from_the_common_frame_on(block):
    """It was marked 2 mm above the skin in a frame 5 mm to the right of the common one."""
    mesh, right = block(), np.array([5.0, 0.0, 0.0])
    breast = SimpleNamespace(nipple=np.array([7.0, -2.0, 11.3]), to_reference=lambda points: points + right)
    chain = {"breast": breast, "mesh": mesh}
    np.testing.assert_allclose(nipple_of(chain, mesh.points), [12.0, -2.0, 11.3])
    sunk = mesh.points * [1.0, 1.0, 2.0] - [0.0, 0.0, 40.0]
    np.testing.assert_allclose(nipple_of(chain, sunk), [12.0, -2.0, 22.6 - 40.0])
    loaded = chain | {"loaded": SimpleNamespace(mesh=mesh.moved_to(sunk))}
    np.testing.assert_allclose(QUANTITIES["nipple_mm"].of(loaded), [12.0, -2.0, 22.6 - 40.0])


def test_a_quantity_that_nobody_knows_is_named_with_those_there_are():
    assert list(quantities(["force_n", "nipple_mm"])) == ["force_n", "nipple_mm"]
    with pytest.raises(ConfigurationError, match="no quantity 'pain'; choose among: nipple_mm, force_n"):
        quantities(["force_n", "pain"])
