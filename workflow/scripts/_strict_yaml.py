"""YAML files of the study, read strictly: what YAML would read as something else is rejected by its line."""

import json
import re
from pathlib import Path
from typing import Any, NoReturn

import yaml

from mammosim.core.errors import ConfigurationError
from mammosim.io.plain import repeated

# YAML 1.2; version 1.1, which the library reads, takes 2e-1 and 1e1 for text.
FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+\.[0-9]*|[0-9]+(\.[0-9]*)?[eE][-+]?[0-9]+|\.[0-9]+[eE][-+]?[0-9]+)")
# Of version 1.1 only: 010 is 8, and 1:30 is 90.
OTHER_BASE = re.compile(r"[-+]?(0[0-9_]+|[0-9][0-9_]*(:[0-5]?[0-9])+(\.[0-9_]*)?)")
NO_TEXT = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f]")
UTF16 = (b"\xff\xfe", b"\xfe\xff")


class Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):
    """YAML whose keys are text and stand once, and whose numbers are decimal, 2e-1 too."""

    def construct_object(self, node: yaml.Node, deep: bool = False) -> Any:
        """What a node is, with all that is in it: so what holds itself is found, and rejected.

        A value that is none of its kind, as the date 2024-13-45, is rejected by its line, too.
        """
        if node in self.recursive_objects:
            _reject(node, "what begins here holds itself; write it out")
        try:
            return super().construct_object(node, deep=True)
        except (ValueError, KeyError, AttributeError, TypeError):
            kind = node.tag.rsplit(":", 1)[-1]
            _reject(node, f"{_source(node)} is no {kind} that can be read; correct it, or put it in quotes")

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[str, Any]:
        """The mapping of a node, merged with those that `<<` names."""
        keys = [key for key, _ in node.value if key.tag != "tag:yaml.org,2002:merge"]
        if twice := repeated([key.value for key in keys if isinstance(key, yaml.ScalarNode)]):
            same = [key for key in keys if key.value == twice[0]]
            lines = " and ".join(str(key.start_mark.line + 1) for key in same)
            _reject(same[-1], f"{twice[0]!r} is given twice, in lines {lines}; keep one")
        for key in keys:
            if key.tag != "tag:yaml.org,2002:str":
                _reject(key, f"the key {_source(key)} is no text; put it in quotes")
        return super().construct_mapping(node, deep=deep)

    def decimal(self, node: yaml.ScalarNode) -> int | float:
        """A number; rejected where it begins with 0 or has colons, which YAML 1.1 reads in other bases."""
        if OTHER_BASE.fullmatch(node.value):
            _reject(
                node,
                f"{node.value} is read in another base; write a decimal number, or text in quotes",
            )
        whole = node.tag == "tag:yaml.org,2002:int"
        return self.construct_yaml_int(node) if whole else self.construct_yaml_float(node)


Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(f"(?:{FLOAT.pattern})$"), list("-+.0123456789")
)
for kind in ("int", "float"):
    Loader.add_constructor(f"tag:yaml.org,2002:{kind}", Loader.decimal)


def _source(node: yaml.Node) -> str:
    if not isinstance(node, yaml.ScalarNode):
        return "that begins here"
    return node.value if len(node.value) <= 40 else f"{node.value[:37]}..."


def _reject(node: yaml.Node, problem: str) -> NoReturn:
    raise yaml.constructor.ConstructorError(None, None, problem, node.start_mark)


def read(path: str | Path, name: str | None = None) -> Any:
    """The values of a YAML or JSON file. name: what messages call it.

    Raises ConfigurationError with file, line and reason where it cannot be read, or cannot be meant.
    """
    name = name or str(path)
    text = text_of(path, name)
    try:
        if Path(path).suffix == ".json":
            return json.loads(text, object_pairs_hook=_once)
        return yaml.load(text, Loader=Loader)
    except json.JSONDecodeError as error:
        raise ConfigurationError(f"{name}, line {error.lineno}: {error.msg}; this is no JSON") from None
    except yaml.MarkedYAMLError as error:
        raise ConfigurationError(f"{name}, {_reason(error, text)}") from None
    except RecursionError:
        raise ConfigurationError(f"{name}: lists in lists, too many to be read; write settings") from None
    except ValueError as error:
        raise ConfigurationError(f"{name}: {error}; correct it") from None


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """A group of JSON, each of whose keys stands once."""
    if twice := repeated([key for key, _ in pairs]):
        raise ValueError(f"{twice[0]!r} is given twice")
    return dict(pairs)


def text_of(path: str | Path, name: str) -> str:
    """The text of a file, without the mark of UTF-8. Raises ConfigurationError where it is none."""
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise ConfigurationError(f"{name} cannot be read: {error.strerror}; give a file of YAML") from None
    if data.startswith(UTF16):
        raise ConfigurationError(f"{name}, line 1: this is UTF-16; save it as UTF-8")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise ConfigurationError(
            f"{name}, line {line}: byte {data[error.start]:#04x} is no UTF-8; save it as UTF-8"
        ) from None
    if odd := NO_TEXT.search(text):
        line = text[: odd.start()].count("\n") + 1
        raise ConfigurationError(
            f"{name}, line {line}: character {ord(odd[0]):#04x}: this is a binary file; give one of YAML"
        )
    return text


def _reason(error: yaml.MarkedYAMLError, text: str) -> str:
    """Line and cause of what the parser says."""
    at = error.problem_mark.line if error.problem_mark else 0
    lines = text.splitlines()
    if at < len(lines) and "\t" in re.match(r"\s*", lines[at])[0]:
        return f"line {at + 1}: a tab; indent by blanks"
    begun = error.context_mark and error.context_mark.line != at
    since = f", {error.context} that begins in line {error.context_mark.line + 1}" if begun else ""
    return f"line {at + 1}: {error.problem}{since}"
