"""Studies as TOML files."""

from __future__ import annotations

import importlib
import os
import pathlib
import sys
from typing import Any, Mapping, Union

from .design import Parameter, Range
from .errors import StudyError, meant
from .study import Study

KINDS: dict[str, tuple[type, ...]] = {
    "name": (str,),
    "scene": (str,),
    "trial": (str,),
    "design": (str,),
    "trials": (int, list),
    "repeats": (int,),
    "seed": (int,),
    "success": (str,),
    "watch": (list,),
    "timeout": (int, float),
    "parameters": (dict,),
    "units": (dict,),
}
WORDS = {str: "a text", int: "a whole number", float: "a number", list: "a list", dict: "a table"}
RANGE = ("from", "to", "count", "log")


def toml_reader() -> Any:
    name = "tomllib" if sys.version_info >= (3, 11) else "tomli"
    try:
        return importlib.import_module(name)
    except ImportError:
        raise StudyError("studies in files need tomli before Python 3.11: pip install tomli") from None


def parameter_of(given: Any, where: str) -> Parameter:
    if not isinstance(given, dict):
        return given  # type: ignore[no-any-return]
    for key in given:
        if key not in RANGE:
            raise StudyError(f"{where}.{key}: is not known{meant(key, RANGE)}")
    if "from" not in given or "to" not in given:
        raise StudyError(f"{where}: a range needs from and to")
    if not isinstance(given.get("log", False), bool):
        raise StudyError(f"{where}.log: must be true or false")
    return Range(given["from"], given["to"], given.get("count"), given.get("log", False))


def checked(content: Mapping[str, Any]) -> None:
    for key, value in content.items():
        if key not in KINDS:
            raise StudyError(f"{key}: is not known{meant(key, KINDS)}")
        if not isinstance(value, KINDS[key]) or isinstance(value, bool):
            raise StudyError(f"{key}: must be {' or '.join(WORDS[kind] for kind in KINDS[key])}")
    if not content.get("parameters"):
        raise StudyError("parameters: is missing; name what changes from trial to trial")


def load(file: Union[str, "os.PathLike[str]"]) -> Study:
    """The study of a TOML file; its paths are seen from the file's folder.

    Keys are those of Study, with [parameters] as a table: a value, a list, or {from, to, count, log}.
    Raises StudyError that names the file and the field.
    """
    path = pathlib.Path(file)
    try:
        content: dict[str, Any] = toml_reader().loads(path.read_text("utf-8"))
    except OSError as bad:
        raise StudyError(f"{file}: {bad.strerror}") from None
    except ValueError as bad:  # text or TOML
        raise StudyError(f"{file}: {bad}") from None
    try:
        checked(content)
        content["parameters"] = {
            name: parameter_of(given, f"parameters.{name}") for name, given in content["parameters"].items()
        }
        words: dict[str, Any] = {"name": path.stem, **content}
        return Study(**words, folder=path.parent)
    except StudyError as bad:
        raise StudyError(f"{file}: {bad}") from None
