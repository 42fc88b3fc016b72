"""Formulas of configurations in a small, safe language: `across**2 / 400 + 3 * exp(-outward / 20)`.

Names that are allowed, numbers, + - * / **, brackets, and FUNCTIONS.
"""

import ast
import operator
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from mammosim.core.errors import ConfigurationError

LONGEST = 500  # characters
FUNCTIONS: Mapping[str, Callable[[Any], Any]] = {
    "sqrt": np.sqrt, "exp": np.exp, "log": np.log, "sin": np.sin, "cos": np.cos, "tan": np.tan,
    "tanh": np.tanh, "abs": np.abs,
}  # fmt: skip
CONSTANTS: Mapping[str, float] = {"pi": float(np.pi)}
OPERATORS: Mapping[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}  # fmt: skip


@dataclass(frozen=True)
class Formula:
    """text: as written; tree: what it means."""

    text: str
    tree: ast.expr

    @classmethod
    def read(cls, text: str, names: Collection[str]) -> "Formula":
        """names: of its variables. Raises ConfigurationError for anything outside the language."""
        if not text.strip() or len(text) > LONGEST:
            raise ConfigurationError(f"{text[:40]!r} is no formula of 1 to {LONGEST} characters; write one")
        try:
            tree = ast.parse(text.strip(), mode="eval").body
        except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
            why = error.msg if isinstance(error, SyntaxError) else "it cannot be read"
            raise ConfigurationError(
                f"{text!r} is no formula: {why}; write it as `{min(names)}**2 / 400`"
            ) from None
        _require(tree, names)
        return cls(text, tree)

    def __call__(self, values: Mapping[str, np.ndarray]) -> np.ndarray:
        """Its values (n,) where each variable has values (n,)."""
        return np.asarray(_value(self.tree, values), dtype=float)


def _require(node: ast.expr, names: Collection[str]) -> None:
    """Raise ConfigurationError for what is outside the language."""
    match node:
        case ast.Name(id=name) if name in names or name in CONSTANTS:
            return
        case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
            return
        case ast.UnaryOp(op=ast.USub(), operand=inside):
            _require(inside, names)
        case ast.BinOp(op=op, left=left, right=right) if type(op) in OPERATORS:
            _require(left, names)
            _require(right, names)
        case ast.Call(func=ast.Name(id=name), args=[inside], keywords=[]) if name in FUNCTIONS:
            _require(inside, names)
        case _:
            raise ConfigurationError(
                f"{ast.unparse(node)!r} is not understood; a formula has {', '.join((*names, *CONSTANTS))}, "
                f"numbers, + - * / **, brackets, {', '.join(FUNCTIONS)}"
            )


def _value(node: ast.expr, values: Mapping[str, np.ndarray]) -> Any:
    match node:
        case ast.Name(id=name):
            return values[name] if name in values else CONSTANTS[name]
        case ast.Constant(value=number):
            return np.float64(number)  # type: ignore[arg-type]
        case ast.UnaryOp(operand=inside):
            return -_value(inside, values)
        case ast.BinOp(op=op, left=left, right=right):
            return OPERATORS[type(op)](_value(left, values), _value(right, values))
        case ast.Call(func=ast.Name(id=name), args=[inside]):
            return FUNCTIONS[name](_value(inside, values))
    raise AssertionError(ast.dump(node))
