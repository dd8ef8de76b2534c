"""Expressions of variables, evaluated without executing anything: sums, products, powers, a few functions."""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.special import erf

_OPERATORS: dict[type, Callable[..., Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
    ast.USub: operator.neg,
}
_FUNCTIONS: dict[str, Callable[..., Any]] = {
    **{name: getattr(np, name) for name in ("abs", "exp", "log", "maximum", "minimum", "sqrt")},
    "erf": erf,
}
_REDUCED = ("isel", "max", "mean", "min", "sum")


def value_of(node: ast.AST, value: Callable[[str], Any]) -> Any:
    """Evaluate sums, powers, functions, ``x.isel(dim=k)`` and ``x.mean(dim)``; a name has its `value`."""
    if isinstance(node, ast.Expression):
        return value_of(node.body, value)
    if isinstance(node, ast.Constant) and isinstance(node.value, int | float):
        return float(node.value)
    if isinstance(node, ast.Name):
        return value(node.id)
    if isinstance(node, ast.BinOp):
        return _OPERATORS[type(node.op)](value_of(node.left, value), value_of(node.right, value))
    if isinstance(node, ast.UnaryOp):
        return _OPERATORS[type(node.op)](value_of(node.operand, value))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in _FUNCTIONS:
        return _FUNCTIONS[node.func.id](*(value_of(part, value) for part in node.args))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in _REDUCED:
        how = {str(k.arg): ast.literal_eval(k.value) for k in node.keywords}
        reduced = getattr(value_of(node.func.value, value), node.func.attr)
        return reduced(*map(ast.literal_eval, node.args), **how)
    raise LookupError(ast.dump(node))
