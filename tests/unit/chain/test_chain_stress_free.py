"""A small breast that is too heavy for its moduli: which shape and which moduli carry it from then on."""

from pathlib import Path

import numpy as np
import pytest
from small_breast import small_chain

from mammosim.chain.files import grouped, job_outputs
from mammosim.chain.graph import Made
from mammosim.chain.jobs import make
from mammosim.chain.outcome import CONVERGED
from mammosim.chain.press import MEASURED
from mammosim.chain.stages import STAGES
from mammosim.core.errors import ConfigurationError, MechanicsError, MissingResult
from mammosim.core.labels import Label
from mammosim.io.missing import write_missing
from mammosim.mechanics.body import Skin
from mammosim.mechanics.unloading_order import reloaded_mm

PLACES = {"v": "ada", "p": "prone", "side": "left", "method": "anderson", "moduli": "gravity", "also": ""}
WEAK = 8.0  # moduli this much smaller than those of the study carry her under half of her weight


def tissues(chain, factor):
    """Those of the study, all moduli times a factor."""
    given = chain.setting("tissues")
    solids = {name: of(tissue, factor) for name, tissue in given["tissues"].items()}
    return {"tissues": solids, "skin": of(given["skin"], factor)}


def of(tissue, factor):
    return tissue | {"youngs_modulus_kpa": factor * tissue["youngs_modulus_kpa"]}


def with_moduli(chain, own, pressed=None):
    return chain.with_settings({"tissues": own, "load.tissues": own if pressed is None else pressed})


@pytest.fixture(scope="module")
def study(repository):
    return small_chain(repository)


@pytest.fixture(scope="module")
def heavy(study):
    return with_moduli(study, tissues(study, 1 / WEAK))


def test_where_the_default_method_finds_a_shape_it_is_that_with_the_moduli_as_given(study):
    found = study["stress_free"]
    assert found.mesh is study["unloaded"].mesh
    assert found.moduli_factor == 1.0
    assert found.attempts.outcome.tolist() == [CONVERGED]
    assert study["press_setup"].moduli_factor == 1.0


def test_a_comparison_of_methods_shows_that_the_default_fails(heavy):
    with pytest.raises(MechanicsError, match="no equilibrium under gravity"):
        heavy["unloaded"]


def test_what_was_tried_is_told_in_its_order_with_reasons_and_moduli(heavy):
    table = heavy["stress_free"].attempts
    assert table.method.tolist()[:2] == ["anderson", "inverse"]
    assert table.moduli_factor.is_monotonic_increasing
    assert all(why.startswith("failed: ") for why in table.outcome[:-1])
    assert table.outcome.iloc[-1] == CONVERGED
    np.testing.assert_allclose(table.adipose_kpa, table.moduli_factor / WEAK)
    np.testing.assert_allclose(table.skin_kpa, 10 * table.moduli_factor / WEAK)


def test_with_the_moduli_that_carry_her_she_hangs_as_she_was_measured(heavy):
    found, gravity = heavy["stress_free"], heavy["breast"].gravity
    assert found.moduli_factor > 1.0
    carried = heavy["body"].stiffened(found.moduli_factor)
    largest = reloaded_mm(found.mesh.points, heavy["mesh"], carried, gravity)
    assert largest == pytest.approx(found.attempts.largest_mm.iloc[-1])
    assert largest <= heavy.setting("mechanics.stress_free.tolerance_mm")


def test_all_that_follows_has_the_moduli_that_carry_her_and_another_set_is_as_given(heavy, study):
    factor = heavy["stress_free"].moduli_factor
    for name in ("loaded_body", "pressed_body"):
        body = heavy[name]
        assert body.tissues[Label.ADIPOSE].youngs_modulus_kpa == pytest.approx(factor / WEAK)
        (skin,) = [part for part in body.parts if isinstance(part, Skin)]
        assert skin.youngs_modulus_kpa == pytest.approx(10 * factor / WEAK)
    assert heavy["press_setup"].moduli_factor == factor
    assert "moduli_factor" in MEASURED
    other = {"load.moduli": "compression", "load.tissues": tissues(study, 5.0)}
    firm = heavy.with_settings(other)
    assert firm["stress_free"] is heavy["stress_free"]
    assert firm["pressed_body"].tissues[Label.ADIPOSE].youngs_modulus_kpa == 5.0
    assert firm["press_setup"].moduli_factor == 1.0


def test_moduli_next_to_her_own_are_multiplied_as_hers_are(heavy):
    """Of a campaign that varies what is pressed alone: her own point is no exception among its neighbours."""
    own, factor = heavy.setting("tissues"), heavy["stress_free"].moduli_factor
    for share in (0.999, 1.0, 1.001):
        near = heavy.with_settings({"load.tissues": tissues(heavy, share)})
        assert near["stress_free"] is heavy["stress_free"]
        assert near["press_setup"].moduli_factor == factor
        adipose = near["pressed_body"].tissues[Label.ADIPOSE].youngs_modulus_kpa
        assert adipose == pytest.approx(share * factor / WEAK)
    # The same values as another set are as they are given.
    named = heavy.with_settings({"load.moduli": "soft", "load.tissues": own})
    assert named["press_setup"].moduli_factor == 1.0
    assert named["pressed_body"].tissues[Label.ADIPOSE].youngs_modulus_kpa == pytest.approx(1 / WEAK)


def test_a_shape_is_read_with_its_factor_and_of_a_failed_method_its_reason(heavy, tmp_path):
    """As in jobs: the default method's own file says that it is missing, and why."""
    shape = tmp_path / "unloaded.vtu"
    write_missing(shape, "unload ada prone anderson: it diverges")
    files = {
        name: str(tmp_path / Path(path).name) for name, path in job_outputs(["stress_free"], PLACES).items()
    }
    apart = type(heavy)(heavy.subject, heavy.settings, heavy.effects, STAGES, dict(heavy.made))
    del apart.made[apart.key("unloaded")], apart.made[apart.key("stress_free")]
    make(apart.kept({"unloaded": {"shape": str(shape)}}), ["stress_free"], files, {"volunteer": "ada"})
    read = STAGES["stress_free"].load(grouped(files)["stress_free"])
    assert read.moduli_factor == heavy["stress_free"].moduli_factor
    np.testing.assert_array_equal(read.mesh.points, heavy["stress_free"].mesh.points)
    assert "unload ada prone anderson: it diverges" in read.attempts.outcome[0]


def test_without_other_methods_and_moduli_the_reason_is_in_one_line(heavy):
    alone = heavy.with_settings(
        {"mechanics.stress_free.fallback": [], "mechanics.stress_free.moduli_factors": []}
    )
    with pytest.raises(
        MechanicsError, match="no stress-free shape carries the weight, by anderson"
    ) as caught:
        alone["stress_free"]
    assert "\n" not in str(caught.value)
    with pytest.raises(MechanicsError):
        alone["pressed_body"]


@pytest.mark.parametrize("error", [ConfigurationError("no such method"), MissingResult("no mesh")])
def test_what_is_no_failure_of_a_method_is_not_answered_by_another(heavy, error):
    """A setting that cannot be meant ends it, and so does a mesh that is missing."""
    name = "unloaded" if isinstance(error, ConfigurationError) else "mesh"
    broken = type(heavy)(heavy.subject, heavy.settings, heavy.effects, STAGES, dict(heavy.made))
    broken.made[broken.key(name)] = Made(None, error, 0.0)
    del broken.made[broken.key("stress_free")]
    with pytest.raises(type(error), match=str(error)):
        broken["stress_free"]
