"""Expressions of parameters: `${0.004 - clearance / 2}` in a scene, `peg_z < 0.006` for success.

They are arithmetic of numbers and names, comparisons, `and`, `or`, `not`, a few functions, and nothing
else of Python.
"""

from __future__ import annotations

import ast
import math
import operator
import random
import re
from typing import Any, Callable, Mapping, Optional

from .errors import StudyError, meant

BINARY: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
}
UNARY: dict[type, Callable[[Any], Any]] = {ast.USub: operator.neg, ast.UAdd: operator.pos, ast.Not: operator.not_}
FUNCTIONS: dict[str, Callable[..., Any]] = {
    "abs": abs,
    "min": min,
    "max": max,
    "sqrt": math.sqrt,
    "hypot": math.hypot,
    "sin": math.sin,
    "cos": math.cos,
    "tan": math.tan,
    "atan2": math.atan2,
    "radians": math.radians,
}
DRAWS = ("uniform", "normal")
CONSTANTS = {"pi": math.pi}
HOLE = re.compile(r"\$\{([^}]*)\}")


def draws(seed: int) -> dict[str, Callable[..., Any]]:
    """uniform(low, high) and normal(mean, deviation) of a trial's seed."""
    source = random.Random(seed)
    return {"uniform": source.uniform, "normal": source.gauss}


class Expression:
    """An expression that is read once and evaluated for each trial."""

    def __init__(self, text: str, where: str) -> None:
        self.text, self.where = text.strip(), where
        self.names: set[str] = set()
        try:
            self.tree = ast.parse(self.text, mode="eval").body
        except SyntaxError as bad:
            raise StudyError(f"{where}: '{self.text}' is no expression: {bad.msg}") from None
        self.check(self.tree)
        self.names -= set(CONSTANTS)

    def refuse(self, node: ast.AST) -> StudyError:
        part = ast.unparse(node)
        return StudyError(f"{self.where}: '{part}' is not possible in '{self.text}'; give arithmetic and comparisons")

    def check(self, node: ast.AST) -> None:
        if isinstance(node, ast.Call):
            name = node.func.id if isinstance(node.func, ast.Name) else ast.unparse(node.func)
            if name not in FUNCTIONS and name not in DRAWS:
                known = meant(name, [*FUNCTIONS, *DRAWS])
                raise StudyError(f"{self.where}: '{name}()' in '{self.text}' is not known{known}")
            if node.keywords:
                raise self.refuse(node)
            for argument in node.args:
                self.check(argument)
        elif isinstance(node, ast.Name):
            self.names.add(node.id)
        elif isinstance(node, ast.Constant):
            if not isinstance(node.value, (int, float, str)):
                raise self.refuse(node)
        else:
            self.check_operators(node)

    def check_operators(self, node: ast.AST) -> None:
        if isinstance(node, ast.BinOp) and type(node.op) in BINARY:
            parts = [node.left, node.right]
        elif isinstance(node, ast.UnaryOp) and type(node.op) in UNARY:
            parts = [node.operand]
        elif isinstance(node, ast.Compare) and all(type(op) in BINARY for op in node.ops):
            parts = [node.left, *node.comparators]
        elif isinstance(node, ast.BoolOp):
            parts = node.values
        else:
            raise self.refuse(node)
        for part in parts:
            self.check(part)

    def __call__(self, values: Mapping[str, Any], chance: Optional[Mapping[str, Callable[..., Any]]] = None) -> Any:
        try:
            return evaluate(self.tree, {**CONSTANTS, **values}, {**FUNCTIONS, **(chance or {})})
        except KeyError as missing:
            name = missing.args[0]
            raise StudyError(f"{self.where}: '{name}' in '{self.text}' is not known{meant(name, values)}") from None
        except (ArithmeticError, TypeError, ValueError) as bad:
            raise StudyError(f"{self.where}: '{self.text}': {bad}") from None


def evaluate(node: ast.AST, values: Mapping[str, Any], functions: Mapping[str, Callable[..., Any]]) -> Any:
    def of(part: ast.AST) -> Any:
        return evaluate(part, values, functions)

    if isinstance(node, ast.Constant):
        return node.value
    if isinstance(node, ast.Name):
        return values[node.id]
    if isinstance(node, ast.UnaryOp):
        return UNARY[type(node.op)](of(node.operand))
    if isinstance(node, ast.BinOp):
        return BINARY[type(node.op)](of(node.left), of(node.right))
    if isinstance(node, ast.BoolOp):
        stop = isinstance(node.op, ast.Or)  # the value that decides, as Python's own `or`
        for part in node.values[:-1]:
            value = of(part)
            if bool(value) == stop:
                return value
        return of(node.values[-1])
    if isinstance(node, ast.Compare):
        left = of(node.left)
        for op, comparator in zip(node.ops, node.comparators):
            right = of(comparator)
            if not BINARY[type(op)](left, right):
                return False
            left = right
        return True
    assert isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    return functions[node.func.id](*map(of, node.args))


class Template:
    """A text with `${expression}` in it."""

    def __init__(self, text: str, where: str) -> None:
        self.text, self.where = text, where
        self.parts = HOLE.split(text)  # text, expression, text, ...
        self.expressions = [Expression(part, where) for part in self.parts[1::2]]

    @property
    def names(self) -> set[str]:
        return set().union(*(e.names for e in self.expressions)) if self.expressions else set()

    def filled(self, values: Mapping[str, Any], seed: int) -> str:
        """With the values in place, numbers to all their digits."""
        chance = draws(seed)
        out = [self.parts[0]]
        for expression, text in zip(self.expressions, self.parts[2::2]):
            value = expression(values, chance)
            out += [repr(float(value)) if isinstance(value, float) else str(value), text]
        return "".join(out)
