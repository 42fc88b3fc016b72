"""Files of settings are laid over each other as a run does: the last one counts, and is the one to blame."""

import importlib.util

import pytest

from mammosim.core.errors import ConfigurationError


@pytest.fixture
def check(repository, tmp_path):
    """check(texts): files with these texts, the last over the others."""
    spec = importlib.util.spec_from_file_location("check_config", repository / "tools/check_config.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)

    def run(*texts):
        files = [tmp_path / f"{name}.yaml" for name in "abc"[: len(texts)]]
        for file, text in zip(files, texts):
            file.write_text(text)
        module.check([str(file) for file in files])

    return run


def test_a_later_file_corrects_an_earlier_one_and_is_blamed_where_it_does_not(check):
    wrong, right = "xray: {peak_kv: 200}\n", "xray: {peak_kv: 30}\n"
    check(wrong, right)
    with pytest.raises(ConfigurationError, match=r"b\.yaml: xray\.peak_kv = 200"):
        check(right, wrong)


def test_what_one_file_says_of_a_group_leaves_the_rest_of_it(check):
    check("xray: {peak_kv: 30}\n", "xray: {filter_um: 60.0}\n")


def test_keys_that_contradict_each_other_are_told_though_each_is_good(check):
    with pytest.raises(ConfigurationError, match=r"b\.yaml: propagation\.pressed = 6: must be less than"):
        check("propagation: {draws: 20}\n", "propagation: {draws: 6, pressed: 6}\n")
