"""Systems of tomosynthesis as the table has them."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from mammosim.core.errors import XrayError
from mammosim.io.tabulated import tabulated
from mammosim.xray.systems import system_named, system_of, systems


def test_impossible_systems_are_rejected():
    with pytest.raises(XrayError, match="choose one of: hologic"):
        system_named("kodak")
    with pytest.raises(XrayError, match="one view has no arc"):
        replace(system_named("ge"), views=1)
    with pytest.raises(XrayError, match="behind the detector"):
        replace(system_named("ge"), source_to_pivot_mm=700.0)
    with pytest.raises(XrayError, match="the detector turns"):
        replace(system_named("ge"), detector_turn_deg=30.0)


@pytest.mark.parametrize("made", [lambda t: t.drop(columns="arc_deg"), lambda t: t.assign(arc_deg=np.nan)])
def test_a_system_that_lacks_something_is_rejected_by_name_with_what_it_lacks(made):
    with pytest.raises(XrayError, match=r"'ge' lacks arc_deg; complete its row .* one: hologic"):
        system_of(made(pd.DataFrame(tabulated("imaging_systems"))), "ge")


def test_every_system_of_the_table_is_complete():
    assert all(system_named(name).size_mm[0] > 200 for name in systems())


def test_magnification_is_the_ratio_of_distances():
    assert system_named("victre_2d").magnification(325.0) == pytest.approx(2.0)
