"""Docstrings of the public names say what each argument is, and what comes back."""

import inspect
import re
import typing
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass

import pytest

import mammosim as ms

FUNCTIONS = [name for name in ms.__all__ if inspect.isfunction(getattr(ms, name, None))]
CLASSES = [name for name in ms.__all__ if inspect.isclass(getattr(ms, name, None))]


def unnamed(text: str | None, names: list[str]) -> list[str]:
    """Of some names those that a docstring lacks."""
    return [name for name in names if not re.search(rf"\b{re.escape(name)}\b", text or "")]


def arguments(function: Callable) -> list[str]:
    """Names of its parameters but for self and cls."""
    return [name for name in inspect.signature(function).parameters if name not in ("self", "cls")]


def reached() -> Iterator[type]:
    """Dataclasses that public functions take or return."""
    for name in FUNCTIONS:
        function = getattr(ms, name)
        for hint in typing.get_type_hints(function).values():
            for each in (hint, *typing.get_args(hint)):
                if is_dataclass(each) and inspect.isclass(each) and each.__module__.startswith("mammosim"):
                    yield each


KNOWN = {
    f"{each.__module__.split('.')[-1]}.{each.__qualname__}": each
    for each in [*(getattr(ms, name) for name in CLASSES), *reached()]
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_public_function_says_what_it_takes_and_gives(name):
    function = getattr(ms, name)
    text = inspect.getdoc(function) or ""
    assert unnamed(text, arguments(function)) == []
    if inspect.signature(function).return_annotation not in (None, "None"):
        assert "Returns" in text
    assert re.search(r"\braises?\b", text, re.I), "or that it raises nothing"


@pytest.mark.parametrize("name", KNOWN)
def test_a_public_class_says_what_it_holds(name):
    if is_dataclass(KNOWN[name]):
        kept = [field.name for field in fields(KNOWN[name]) if not field.name.startswith("_")]
        assert unnamed(inspect.getdoc(KNOWN[name]), kept) == []


@pytest.mark.parametrize("name", CLASSES)
def test_methods_of_a_public_class_say_what_they_take(name):
    of = vars(getattr(ms, name))
    methods = inspect.getmembers(getattr(ms, name), inspect.isroutine)
    public = [(each, found) for each, found in methods if each in of and not each.startswith("_")]
    silent = {each: unnamed(inspect.getdoc(found), arguments(found)) for each, found in public}
    assert all(inspect.getdoc(found) for _, found in public)
    assert {each: lacking for each, lacking in silent.items() if lacking} == {}


def test_something_is_reached():
    names = {name.split(".")[1] for name in KNOWN}
    assert {"Compression", "Registration", "Segmentation", "Unloaded", "Spectrum", "Geometry"} <= names
