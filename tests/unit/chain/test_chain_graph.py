"""A chain makes a product once, again where something it reads changed, and lets none read what it hides."""

import pytest

from mammosim.chain import graph, meshed
from mammosim.chain.graph import Chain, Files, Need, Stage, changed, nested, overridden, pruned, read_by
from mammosim.chain.stages import STAGES as CHAIN
from mammosim.core.errors import ConfigurationError, DamagedFile, MechanicsError, MeshError, MissingResult

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
    "heavy": Stage(
        lambda i: 2 * i["force"], ("force", Need("light", lambda i: i.has("lit"))), effects=("lit",)
    ),
    "one": Stage(lambda i: 1),
    "two": Stage(lambda i: 2),
    "curious": Stage(lambda i: i["light"]),
    "prying": Stage(lambda i: i.setting("size.mm")),
    "sneaking": Stage(lambda i: i.has("stiff")),
    "longer": Stage(lambda i: i.setting("sizes"), reads=("size",)),
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


@pytest.mark.parametrize(
    ("raised", "found"),
    [(MeshError, DamagedFile), (MissingResult, MissingResult), (ConfigurationError, ConfigurationError)],
)
def test_a_file_that_cannot_be_read_is_no_outcome_but_one_that_says_what_is_missing_is(
    raised, found, monkeypatch
):
    def load(files):
        raise raised(f"{files['mesh']}: why")

    monkeypatch.setattr(meshed, "load_mesh", load)
    with pytest.raises(found, match=r"mesh\.vtu") as error:
        CHAIN["mesh"].load({"mesh": "mesh.vtu"})
    assert type(error.value) is found


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


def test_beside_what_is_given_all_that_was_made_stays(chain):
    assert chain["length"] == 6
    assert chain.given({"light": True})["force"] == 12
    assert COUNT == ["length", "force"]


def test_two_products_of_the_same_declaration_are_two(chain):
    assert (chain["one"], chain["two"]) == (1, 2)


def test_a_product_takes_its_own_time_without_what_it_waited_for_and_none_where_it_is_read(monkeypatch):
    clock = [0.0]
    monkeypatch.setattr(graph.time, "process_time", lambda: clock[0])

    def lasts(seconds, value):
        clock[0] += seconds
        return value

    class Kept(Stage):
        def load(self, files):
            return lasts(9.0, files["shape"])

    stages = {
        "read": Kept(lambda i: "made"),
        "slow": Stage(lambda i: lasts(3.0, i["read"]), ("read",)),
        "end": Stage(lambda i: lasts(1.0, i["slow"]), ("slow",)),
    }
    chain = Chain(None, {}, frozenset(), stages).kept({"read": {"shape": "kept"}}).kept({"slow": {}})
    with_both = set(chain.files)
    assert with_both == {chain.key("read"), chain.key("slow")}, "files that were named before stay"
    chain = Chain(None, {}, frozenset(), stages).kept({"read": {"shape": "kept"}})
    assert chain["end"] == "kept"
    assert chain.seconds("end") == {"read": 0.0, "slow": 3.0, "end": 1.0}


def test_the_paths_of_a_product_have_its_wildcards_and_only_what_is_read_back():
    files = Files("{v}/{side}", {"shape": ".vtu"}, beside={"path": "_path.csv"})
    job = {"v": "ada", "side": "left"}
    assert files.paths(job) == {"shape": "ada/left.vtu"}
    assert files.paths(job, beside=True) == {"shape": "ada/left.vtu", "path": "ada/left_path.csv"}


def test_a_failure_is_remembered_and_raised_again_also_behind_it(chain):
    for name in ("behind", "fails", "behind"):
        with pytest.raises(MechanicsError, match="slides away"):
            chain[name]
    assert COUNT == ["fails"]


@pytest.mark.parametrize("name", ["curious", "prying", "sneaking", "longer"])
def test_a_product_cannot_read_what_it_does_not_name(chain, name):
    with pytest.raises(KeyError, match="does not name it"):
        chain[name]


def test_upstream_is_in_the_order_of_need(chain):
    assert chain.upstream("force") == ("length",)
    assert chain.upstream("heavy") == ("length", "force")


def test_a_product_that_is_needed_at_times_is_needed_then_only(chain):
    assert chain.needs("heavy") == ("force",)
    assert chain.with_effects({"lit"}).needs("heavy") == ("force", "light")
    assert STAGES["heavy"].all_needs == ("force", "light")


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
