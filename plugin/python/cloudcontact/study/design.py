"""Which trials a study has: a grid, a Latin hypercube or a list of parameters, and the seed of each."""

from __future__ import annotations

import itertools
import math
import numbers
import random
from dataclasses import dataclass
from typing import Any, Mapping, Optional, Sequence, Union

import numpy as np

from .errors import StudyError, meant

Value = Union[float, int, bool, str]
DESIGNS = ("grid", "latin", "list")
RESERVED = ("number", "repeat", "seed", "status", "error", "versions")


def number(value: Any) -> Any:
    """numpy's numbers and others that are like Python's as Python's own; anything else as it is."""
    if isinstance(value, np.generic) or (isinstance(value, np.ndarray) and value.ndim == 0):
        value = value.item()
    if isinstance(value, numbers.Integral) and not isinstance(value, bool):
        return int(value)
    return float(value) if isinstance(value, numbers.Real) and not isinstance(value, bool) else value


def finite(value: Any) -> bool:
    """Whether it is a number of Python's that a double can hold."""
    try:
        return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
    except OverflowError:
        return False


def whole(value: Any, least: int, where: str) -> int:
    """A whole number, as Python's own."""
    value = number(value)
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        raise StudyError(f"{where} a whole number of {least} or more")
    return value


@dataclass(frozen=True)
class Range:
    """Numbers from `low` to `high`, both included.

    count: how many a grid takes; a Latin hypercube needs none. log: evenly spaced logarithms.
    """

    low: float
    high: float
    count: Optional[int] = None
    log: bool = False

    def checked(self, where: str) -> Range:
        """With numbers of Python's own."""
        low, high = number(self.low), number(self.high)
        if not finite(low) or not finite(high):
            raise StudyError(f"{where}: from and to must be finite numbers")
        count = None if self.count is None else whole(self.count, 1, f"{where}: count must be")
        if self.log and not (low > 0 and high > 0):
            raise StudyError(f"{where}: with log, from and to must be above 0")
        return Range(low, high, count, bool(self.log))

    def at(self, share: float) -> float:
        """The number at a share 0..1 of the way."""
        if share == 0 or share == 1:
            return float(self.high if share else self.low)
        if self.log:
            return float(self.low * (self.high / self.low) ** share)
        return float(self.low + (self.high - self.low) * share)

    def values(self, where: str) -> list[float]:
        if self.count is None:
            raise StudyError(f"{where}: a grid needs count, the number of values from {self.low} to {self.high}")
        return [self.at(i / (self.count - 1) if self.count > 1 else 0.0) for i in range(self.count)]


Parameter = Union[Value, Sequence[Value], Range]


@dataclass(frozen=True)
class Point:
    """A trial: its number from 0, the number of its repeat, its seed, its parameters."""

    number: int
    repeat: int
    seed: int
    parameters: dict[str, Value]


def seed_of(study: int, number: int) -> int:
    """Of a trial: 63 bits that depend on the study's seed and the trial's number alone."""
    words = np.random.SeedSequence(study, spawn_key=(number,)).generate_state(2, np.uint32)
    return (int(words[0]) << 31) ^ int(words[1])


def plain(value: Any, where: str) -> Value:
    """A number, text or bool of Python itself."""
    value = number(value)
    if isinstance(value, float) and not math.isfinite(value):
        raise StudyError(f"{where}: {value} is not finite")
    if isinstance(value, int) and abs(value) >= 2**63:
        raise StudyError(f"{where}: {value} has more than 63 bits; give it as a text")
    if not isinstance(value, (bool, int, float, str)):
        raise StudyError(f"{where}: {value!r} is no number, text or true/false")
    return str.__str__(value) if isinstance(value, str) else value  # not of a class that workers may not have


def checked(parameters: Mapping[str, Parameter]) -> dict[str, Union[Range, list[Value]]]:
    """Each parameter as a Range or a list of values."""
    out: dict[str, Union[Range, list[Value]]] = {}
    if not isinstance(parameters, Mapping):
        raise StudyError("parameters: must be a dict of names and values")
    for name, given in parameters.items():
        where = f"parameters.{name}"
        if not isinstance(name, str) or not name.isidentifier():
            raise StudyError(f"{where}: is no name; give letters, digits and _")
        if name.lower() in RESERVED:
            raise StudyError(f"{where}: is a column of the results; give another name")
        if name.lower() in map(str.lower, out):
            raise StudyError(f"{where}: another parameter has this name but for its capitals")
        if isinstance(given, Range):
            out[name] = given.checked(where)
        elif isinstance(given, (list, tuple, range, np.ndarray)) and getattr(given, "ndim", 1) > 0:
            out[name] = [plain(v, where) for v in given]
            if not out[name]:
                raise StudyError(f"{where}: has no value")
        else:
            out[name] = [plain(given, where)]
    return out


def grid(parameters: Mapping[str, Union[Range, list[Value]]]) -> list[dict[str, Value]]:
    """All combinations; the last parameter changes fastest."""
    values: list[Sequence[Value]] = []
    for name, p in parameters.items():
        if isinstance(p, Range):
            values.append(p.values(f"parameters.{name}"))
        else:
            values.append(p)
    return [dict(zip(parameters, row)) for row in itertools.product(*values)]


def latin(parameters: Mapping[str, Union[Range, list[Value]]], trials: int, seed: int) -> list[dict[str, Value]]:
    """`trials` points: each range is cut into as many equal parts, and each part is met once.

    Of a list of values each is met equally often, to one.
    """
    source = random.Random(seed)
    columns: dict[str, list[Value]] = {}
    for name, p in parameters.items():
        order = list(range(trials))
        source.shuffle(order)
        if isinstance(p, Range):
            columns[name] = [p.at((i + source.random()) / trials) for i in order]
        else:
            columns[name] = [p[i % len(p)] for i in order]
    return [{name: columns[name][i] for name in columns} for i in range(trials)]


def listed(rows: Sequence[Mapping[str, Any]], fixed: Mapping[str, Union[Range, list[Value]]]) -> list[dict[str, Value]]:
    """The rows, each with the parameters that are the same in all."""
    shared: dict[str, Value] = {}
    for name, p in fixed.items():
        if isinstance(p, Range) or len(p) != 1:
            raise StudyError(f"parameters.{name}: the design is a list; give one value here, others in the list")
        shared[name] = p[0]
    out: list[dict[str, Value]] = []
    for i, row in enumerate(rows):
        where = f"trials[{i}]"
        if not isinstance(row, Mapping):
            raise StudyError(f"{where}: must be a table of parameters")
        out.append({**shared, **{name: plain(v, f"{where}.{name}") for name, v in row.items()}})
        if set(out[i]) != set(out[0]):
            name = sorted(set(out[i]) ^ set(out[0]))[0]
            raise StudyError(f"{where}: all rows need the same parameters; '{name}' is not in all")
    return out


def plan(
    parameters: Mapping[str, Parameter],
    design: str,
    trials: Union[None, int, Sequence[Mapping[str, Any]]],
    repeats: int,
    seed: int,
) -> list[Point]:
    """All trials, in their order."""
    if design not in DESIGNS:
        raise StudyError(f"design: '{design}' is not known{meant(design, DESIGNS)}")
    repeats, seed = whole(repeats, 1, "repeats: must be"), whole(seed, 0, "seed: must be")
    known = checked(parameters)
    if design == "grid":
        if trials is not None:
            raise StudyError("trials: a grid has as many as its parameters make; leave it out")
        rows = grid(known)
    elif design == "latin":
        rows = latin(known, whole(trials, 1, "trials: a Latin hypercube needs their number,"), seed)
    else:
        if not isinstance(trials, Sequence) or isinstance(trials, str) or not trials:
            raise StudyError("trials: the design is a list; give a row of parameters for each")
        rows = listed(trials, known)
        checked(rows[0])  # its names
    repeated = [(row, repeat) for row in rows for repeat in range(repeats)]
    return [Point(n, repeat, seed_of(seed, n), row) for n, (row, repeat) in enumerate(repeated)]
