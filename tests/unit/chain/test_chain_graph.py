"""A chain makes a product once, again where something it reads changed, and lets none read what it hides."""

import pytest

from mammosim.chain.graph import Chain, Stage, changed, nested, overridden, pruned, read_by
from mammosim.core.errors import ConfigurationError, MechanicsError

COUNT: list[str] = []


def _counted(name, value):
    def make(inputs):
        COUNT.append(name)
        return value(inputs)

    return make


def _fails(inputs):
    COUNT.append("fails")
    raise MechanicsError("it slides away")


STAGES = {
    "length": Stage(_counted("length", lambda i: i.setting("size.mm") * i.subject), reads=("size",)),
    "force": Stage(
        _counted("force", lambda i: i["length"] * (2 if i.has("stiff") else 1)), ("length",), (), ("stiff",)
    ),
    "light": Stage(_counted("light", lambda i: i.has("noise")), effects=("noise",)),
    "fails": Stage(_fails),
    "behind": Stage(lambda i: i["fails"], ("fails",)),
    "curious": Stage(lambda i: i["light"]),
    "prying": Stage(lambda i: i.setting("size.mm")),
    "sneaking": Stage(lambda i: i.has("stiff")),
}


@pytest.fixture
def chain():
    COUNT.clear()
    return Chain(3, {"size": {"mm": 2.0}, "other": 1}, frozenset({"stiff"}), STAGES)


def test_a_product_is_made_once_and_shared_by_chains_in_which_nothing_it_reads_differs(chain):
    assert chain["force"] == 12
    assert chain.with_effects({"stiff", "noise"})["force"] == 12
    assert chain.with_settings({"other": 2})["force"] == 12
    assert sorted(COUNT) == ["force", "length"]


def test_an_effect_makes_again_only_what_has_it(chain):
    assert (chain["force"], chain.with_effects(())["force"]) == (12, 6)
    assert sorted(COUNT) == ["force", "force", "length"]


def test_a_setting_makes_again_all_that_follows_from_it(chain):
    assert (chain["force"], chain.with_settings({"size.mm": 5.0})["force"]) == (12, 30)
    assert sorted(COUNT) == ["force", "force", "length", "length"]


def test_what_was_made_before_is_taken_as_given_and_costs_nothing(chain):
    with_length = chain.given({"length": 7.0})
    assert with_length["force"] == 14
    assert with_length.seconds("force")["length"] == 0
    assert COUNT == ["force"]


def test_a_failure_is_remembered_and_raised_again_also_behind_it(chain):
    for name in ("behind", "fails", "behind"):
        with pytest.raises(MechanicsError, match="slides away"):
            chain[name]
    assert COUNT == ["fails"]


@pytest.mark.parametrize("name", ["curious", "prying", "sneaking"])
def test_a_product_cannot_read_what_it_does_not_name(chain, name):
    with pytest.raises(KeyError, match="does not name it"):
        chain[name]


def test_upstream_is_in_the_order_of_need(chain):
    assert chain.upstream("force") == ("length",)


def test_an_unknown_setting_is_named_with_what_there_is(chain):
    with pytest.raises(ConfigurationError, match="no setting 'hight'; choose one of: mm"):
        chain.with_settings({"size.hight": 1.0})
    with pytest.raises(ConfigurationError, match=r"no setting 'size.hight'; known beside it: mm"):
        chain.setting("size.hight")


def test_a_change_leaves_the_values_as_they_were():
    values = {"a": {"b": 1, "c": 2}}
    assert changed(values, ["a", "b"], 5) == {"a": {"b": 5, "c": 2}}
    assert values["a"]["b"] == 1


def test_dotted_names_are_nested_values_and_come_back_by_them():
    given = {"a.b": 1, "a.c.d": [2], "e": {"f": 3}}
    values = nested(given)
    assert values == {"a": {"b": 1, "c": {"d": [2]}}, "e": {"f": 3}}
    assert pruned(values, ["a.c", "e.f", "absent.x", "a.b.deeper"]) == {"a": {"c": {"d": [2]}}, "e": {"f": 3}}
    assert overridden(values, {"a": {"b": 5}})["a"] == {"b": 5, "c": {"d": [2]}}


def test_what_is_read_is_named_by_a_product_or_by_what_it_is_made_of(chain):
    assert read_by(chain.stages, ["force"]) == ("size",)
    assert read_by(chain.stages, []) == ()
