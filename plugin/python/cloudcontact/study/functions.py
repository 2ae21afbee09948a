"""Functions of users on their way to workers: the text of a file, the name of a module, or cloudpickle's bytes."""

from __future__ import annotations

import importlib
import inspect
import pathlib
import pickle
import sys
import tokenize
import types
from dataclasses import dataclass
from typing import Any, Callable, Iterable, Mapping, Optional, Union

from .errors import StudyError, meant

Function = Callable[..., Any]
LOADED = "cloudcontact_study_"


@dataclass(frozen=True)
class Shipped:
    """A function that another process, on another machine, can load."""

    name: str
    file: str = ""
    source: str = ""
    module: str = ""
    pickled: bytes = b""

    @property
    def label(self) -> str:
        """How messages call it: pegs.py:peg()."""
        place = pathlib.Path(self.file).name or self.module
        return f"{place}:{self.name}()" if place else f"{self.name}()"

    def load(self) -> Function:
        if self.pickled:
            return pickle.loads(self.pickled)  # type: ignore[no-any-return]
        if self.module:
            return member(importlib.import_module(self.module), self)
        return member(module_of(self.file, self.source), self)


def module_of(file: str, source: str) -> types.ModuleType:
    """The text of a file as a module; not as __main__, so what stands behind that does not run."""
    path = pathlib.Path(file)
    module = types.ModuleType(LOADED + path.stem)
    module.__file__ = file
    sys.modules[module.__name__] = module
    sys.path[:] = [str(path.parent), *(p for p in sys.path if p != str(path.parent))]  # before another study's folder
    exec(compile(source, file, "exec"), module.__dict__)
    return module


def member(module: types.ModuleType, shipped: Shipped) -> Function:
    found = getattr(module, shipped.name, None)
    if not callable(found):
        functions = [n for n, v in vars(module).items() if inspect.isfunction(v) and v.__module__ == module.__name__]
        raise StudyError(f"{shipped.label}: there is no such function{meant(shipped.name, functions)}")
    return found  # type: ignore[no-any-return]


def source_of(file: pathlib.Path, where: str) -> str:
    """The text of a file of Python, in the encoding that it states."""
    try:
        with tokenize.open(file) as text:
            return text.read()
    except (OSError, SyntaxError, UnicodeDecodeError) as bad:
        raise StudyError(f"{where}: cannot read '{file}': {bad}") from None


def ship_named(text: str, folder: pathlib.Path, where: str) -> Shipped:
    """Of "FILE.py:NAME", seen from a folder, or "MODULE:NAME"."""
    place, _, name = text.rpartition(":")
    if not place or not name.isidentifier():
        raise StudyError(f"{where}: '{text}': give FILE.py:FUNCTION or MODULE:FUNCTION")
    if not place.endswith(".py"):
        return Shipped(name, module=place)
    file = (folder / place).resolve()
    if not file.is_file():
        raise StudyError(f"{where}: no file '{file}'")
    return Shipped(name, str(file), source_of(file, where))


def ship_callable(function: Function, where: str) -> Shipped:
    """Of a function of the running program."""
    name, module = getattr(function, "__qualname__", ""), sys.modules.get(getattr(function, "__module__", ""))
    spec, file = getattr(module, "__spec__", None), getattr(module, "__file__", None)
    if name.isidentifier() and module is not None and getattr(module, name, None) is function:
        if spec is not None and (module.__name__ == "__main__" or "." in spec.name):
            return Shipped(name, module=spec.name)  # python -m, or a part of a package
        if file and pathlib.Path(file).is_file():
            file = pathlib.Path(file).resolve()
            return Shipped(name, str(file), source_of(file, where))
    try:
        cloudpickle = importlib.import_module("cloudpickle")
    except ImportError:
        raise StudyError(
            f"{where}: '{name or function}' is not at the top of a file, so workers cannot find it; move it there, "
            "or install cloudpickle"
        ) from None
    return Shipped(name or "function", pickled=cloudpickle.dumps(function))


def ship(function: Union[str, Function], folder: pathlib.Path, where: str) -> Shipped:
    return ship_named(function, folder, where) if isinstance(function, str) else ship_callable(function, where)


def loaded(shipped: Shipped, where: str) -> Function:
    """The function, with what its file raises as an error of the study."""
    try:
        return shipped.load()
    except StudyError as bad:
        raise StudyError(f"{where}: {bad}") from None
    except Exception as bad:
        raise StudyError(f"{where}: {shipped.label}: {type(bad).__name__}: {bad}") from bad


def check_call(function: Function, label: str, names: Iterable[str]) -> None:
    """That the function takes these parameters, and needs no others but `seed`."""
    takes = inspect.signature(function).parameters.values()
    words = [p for p in takes if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)]
    anything = any(p.kind == p.VAR_KEYWORD for p in takes)
    given = set(names)
    for name in sorted(given - {p.name for p in words}):
        if not anything:
            raise StudyError(f"parameters.{name}: {label} does not take it{meant(name, [p.name for p in words])}")
    for p in words:
        if p.default is p.empty and p.name not in given and p.name != "seed":
            raise StudyError(f"parameters: {label} needs '{p.name}'; add it")


def words_of(function: Function, parameters: Mapping[str, Any]) -> dict[str, Any]:
    """The parameters that the function takes."""
    takes = inspect.signature(function).parameters
    anything = any(p.kind == p.VAR_KEYWORD for p in takes.values())
    return {name: value for name, value in parameters.items() if anything or name in takes}


def call(function: Function, parameters: Mapping[str, Any], seed: int) -> Any:
    takes: Optional[inspect.Parameter] = inspect.signature(function).parameters.get("seed")
    return function(**parameters, **({"seed": seed} if takes is not None else {}))
