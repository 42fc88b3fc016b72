"""Conditions on varied settings, in a small, safe language: `load.thickness_mm < 40 and xray.anode == "W"`.

Keys of the campaign, numbers, text in quotes, true and false; + - * /; comparisons; and, or, not; brackets.
"""

import ast
import operator
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

from mammosim.core.errors import ConfigurationError

LONGEST = 500  # characters
LITERALS: Mapping[str, bool] = {"true": True, "false": False}
COMPARISONS: Mapping[type[ast.cmpop], Callable[[Any, Any], bool]] = {
    ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt, ast.GtE: operator.ge,
    ast.Eq: operator.eq, ast.NotEq: operator.ne,
}  # fmt: skip
ARITHMETIC: Mapping[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
}  # fmt: skip


@dataclass(frozen=True)
class Condition:
    """text: as written; tree: what it means."""

    text: str
    tree: ast.expr

    @classmethod
    def read(cls, text: Any, known: Collection[str], place: str) -> "Condition":
        """known: the keys that it may name. Raises ConfigurationError for anything outside the language."""
        if not isinstance(text, str) or not text.strip() or len(text) > LONGEST:
            raise ConfigurationError(f"{place} = {text!r}: write a condition, as `{min(known)} < 1`")
        try:
            tree = ast.parse(text.strip(), mode="eval").body
        except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
            why = error.msg if isinstance(error, SyntaxError) else "it cannot be read"
            raise ConfigurationError(f"{place} = {text!r}: {why}; write it as `{min(known)} < 1`") from None
        _require(tree, known, place)
        return cls(text, tree)

    def holds(self, values: Mapping[str, Any]) -> bool:
        """Whether it holds of a point. Raises ConfigurationError where its parts cannot be compared."""
        try:
            found = _value(self.tree, values)
        except (TypeError, ZeroDivisionError, OverflowError) as error:
            raise ConfigurationError(f"{self.text!r} cannot be decided: {error}; correct it") from None
        if not isinstance(found, bool):
            raise ConfigurationError(f"{self.text!r} is {found!r}, neither true nor false; compare it")
        return found


def _require(node: ast.AST, known: Collection[str], place: str) -> None:
    """Raise ConfigurationError for what is outside the language."""
    if isinstance(node, (ast.Name, ast.Attribute)):
        key = _key(node)
        if key not in known and key not in LITERALS:
            near = get_close_matches(key, known, n=1)
            advice = f"did you mean {near[0]}?" if near else f"it may name: {', '.join(known)}"
            raise ConfigurationError(f"{place}: {key!r} is not varied; {advice} (text stands in quotes)")
        return
    if isinstance(node, ast.Constant) and isinstance(node.value, (int, float, str)):
        return
    allowed = (ast.Compare, ast.BoolOp, ast.BinOp, ast.UnaryOp)
    inside = list(ast.iter_child_nodes(node))
    operators = (*COMPARISONS, *ARITHMETIC, ast.And, ast.Or, ast.Not, ast.USub)
    if not isinstance(node, allowed) or any(
        isinstance(each, (ast.cmpop, ast.operator, ast.boolop, ast.unaryop))
        and not isinstance(each, operators)
        for each in inside
    ):
        raise ConfigurationError(
            f"{place}: {ast.unparse(node)!r} is not understood; a condition has keys, numbers, text, "
            "+ - * /, < <= == != >= >, and, or, not"
        )
    for each in inside:
        if isinstance(each, ast.expr):
            _require(each, known, place)


def _key(node: ast.AST) -> str:
    if isinstance(node, ast.Name):
        return node.id
    return f"{_key(node.value)}.{node.attr}" if isinstance(node, ast.Attribute) else ast.unparse(node)


def _value(node: ast.AST, values: Mapping[str, Any]) -> Any:
    match node:
        case ast.Constant(value=value):
            return value
        case ast.Name() | ast.Attribute():
            key = _key(node)
            return values[key] if key in values else LITERALS[key]
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            return not _truth(operand, values)
        case ast.UnaryOp(operand=operand):
            return -_number(operand, values)
        case ast.BinOp(left=left, op=op, right=right):
            return ARITHMETIC[type(op)](_number(left, values), _number(right, values))
        case ast.BoolOp(op=op, values=parts):
            return (all if isinstance(op, ast.And) else any)(_truth(part, values) for part in parts)
        case ast.Compare(left=left, ops=ops, comparators=others):
            found = [_value(each, values) for each in (left, *others)]
            return all(COMPARISONS[type(op)](a, b) for op, a, b in zip(ops, found, found[1:]))
    raise KeyError(node)


def _truth(node: ast.AST, values: Mapping[str, Any]) -> bool:
    """Raises TypeError for a number or text, which `a == 1 or 2` has beside what is compared."""
    value = _value(node, values)
    if not isinstance(value, bool):
        raise TypeError(f"{value!r} is neither true nor false")
    return value


def _number(node: ast.AST, values: Mapping[str, Any]) -> float | int:
    """Raises TypeError for text, with which nothing is computed."""
    value = _value(node, values)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise TypeError(f"{value!r} is no number")
    return value
