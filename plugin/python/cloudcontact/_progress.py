"""Progress of long work: a callback, or a line of text, which works in terminals and notebooks."""

from __future__ import annotations

import sys
import time
from typing import Callable, Optional, TextIO, Union

Progress = Union[None, bool, Callable[[float], object]]

FIRST = 1.0  # seconds of work before the line appears
REDRAW = 0.2  # least seconds between two drawings
CELLS = 24


def in_notebook() -> bool:
    """Whether a Jupyter kernel runs this."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    return type(shell).__name__ == "ZMQInteractiveShell"


class TextLine:
    """Draws a line and overwrites it: label, bar, percentage, time left."""

    def __init__(self, label: str, out: TextIO, first: float = FIRST) -> None:
        self.label, self.out = label, out
        self.start = time.monotonic()
        self.due = self.start + first
        self.drawn = False

    def __call__(self, share: float) -> None:
        now = time.monotonic()
        if share >= 1:
            if self.drawn:
                self.out.write("\r" + " " * (len(self.label) + CELLS + 24) + "\r")
                self.out.flush()
            self.drawn = False
        elif now >= self.due:
            self.due = now + REDRAW
            self.drawn = True
            full = int(CELLS * share)
            left = (now - self.start) * (1 - share) / share if share > 0 else 0.0
            bar = "#" * full + "-" * (CELLS - full)
            tail = f"{left:6.0f} s left" if left else " " * 13
            self.out.write(f"\r{self.label} [{bar}] {100 * share:3.0f} %{tail}")
            self.out.flush()


def reporter(progress: Progress, label: str) -> Optional[Callable[[float], object]]:
    """What receives 0..1 as work goes on.

    progress: a callback; True: a line of text on stderr; False: nothing; None: the line after a
    second of work, where stderr is a terminal or a notebook's.
    """
    if callable(progress):
        return progress
    if progress is True:
        return TextLine(label, sys.stderr, 0)
    if progress is None and (sys.stderr is not None) and (sys.stderr.isatty() or in_notebook()):
        return TextLine(label, sys.stderr)
    return None
