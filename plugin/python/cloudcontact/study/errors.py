"""What goes wrong in a study."""

from __future__ import annotations

import difflib
from typing import Iterable


class StudyError(ValueError):
    """A study that cannot run as it is stated: the message names the field and says what to do."""


class StudyStopped(RuntimeError):
    """A study that ended early: its executor broke. What is done is kept; run it again to go on."""


def meant(word: str, known: Iterable[str]) -> str:
    """ "; did you mean 'offset'?", or the names that are known."""
    names = sorted(known)
    near = difflib.get_close_matches(word, names, 1)
    if near:
        return f"; did you mean '{near[0]}'?"
    return f"; give one of {', '.join(names)}" if names else "; none is known"
