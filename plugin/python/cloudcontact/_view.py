"""Replays and live views in notebooks."""

from __future__ import annotations

import html
import importlib
import os
import pathlib
import sys
from typing import Union

from ._progress import in_notebook

HEIGHT = 640  # of the frame in a notebook [px]


class Replay:
    """A replay's page, as World.run(replay="run.html") and `cloudcontact simulate --replay` write it.

    A notebook shows it, with all that it needs inside: it is there when the notebook is opened
    again, also without the file and without a network.
    """

    def __init__(self, path: Union[str, "os.PathLike[str]"], height: int = HEIGHT) -> None:
        """path: the .html file. height: of the frame in a notebook [px]. Raises ValueError for another kind of file."""
        self.path = pathlib.Path(path)
        self.height = height
        if self.path.suffix != ".html":
            raise ValueError(f"{self.path}: is no page; write the replay to a file that ends in .html")

    def __fspath__(self) -> str:
        return str(self.path)

    def __repr__(self) -> str:
        return f"Replay({str(self.path)!r})"

    def _repr_html_(self) -> str:
        # The page in its own origin: it cannot reach the notebook.
        page = html.escape(self.path.read_text(encoding="utf-8"))
        return (
            f'<iframe srcdoc="{page}" sandbox="allow-scripts" style="width: 100%; height: {self.height}px; '
            'border: 1px solid #dfe2e8" title="replay"></iframe>'
        )


def announce(url: str) -> None:
    """Shows a live view in a notebook; elsewhere says where it is."""
    if in_notebook():
        shown = importlib.import_module("IPython.display")
        shown.display(shown.IFrame(url, "100%", HEIGHT))
    else:
        print(f"cloudcontact: open {url} in a browser; Ctrl-C ends the view", file=sys.stderr, flush=True)
