"""The files that a scene's text names: <uri> of SDFormat, <mesh filename="..."> of URDF.

A scene that is written elsewhere names them in full. They are those that the program finds
(demos/scene/scene_paths.cpp).
"""

from __future__ import annotations

import html
import os
import pathlib
import re
from typing import Callable, Optional
from xml.sax.saxutils import escape

# filename in <mesh> alone: plugins have one, too, which is no path from here.
NAMED = re.compile(
    r"""(?P<before><uri>\s*)(?P<uri>[^<]*?)(?=\s*</uri>)"""
    r"""|(?P<tag><mesh\b[^<>]*?\sfilename\s*=\s*(?P<quote>["']))(?P<filename>[^<]*?)(?=(?P=quote))"""
)
QUOTES = {'"': "&quot;", "'": "&apos;"}


def found(name: str, folder: pathlib.Path) -> Optional[str]:
    """The file that a scene in a folder means by a name; none where the name is no path."""
    if name.startswith(("package://", "model://")):
        rest = pathlib.PurePath(name.split("://", 1)[1])
        for at in (folder, *folder.parents) if rest.parts else ():
            inside = at / pathlib.PurePath(*rest.parts[1:])
            for file in (at / rest, inside) if at.name == rest.parts[0] else (at / rest,):
                if os.path.isfile(file):
                    return os.path.normpath(file)
        return None
    name = name.removeprefix("file://")
    return os.path.normpath(folder / name) if name and "://" not in name else None


def located(text: str, folder: pathlib.Path, place: Callable[[str], str] = str) -> str:
    """The text of a scene in a folder with its files named in full; place: what to name in a file's stead."""

    def full(match: re.Match[str]) -> str:
        path = found(html.unescape(match["uri"] or match["filename"] or ""), folder)
        return match[0] if path is None else (match["before"] or match["tag"]) + escape(place(path), QUOTES)

    return NAMED.sub(full, text)


def texts_in(path: str) -> list[str]:
    """Of a model that a scene includes, a file or a folder: its texts. Their paths start from the scene's folder."""
    if os.path.isfile(os.path.join(path, "model.config")):
        return sorted(os.path.join(path, n) for n in os.listdir(path) if n.endswith((".sdf", ".config")))
    return [path] if path.endswith((".sdf", ".urdf")) and os.path.isfile(path) else []


def text_of(path: str) -> str:
    return pathlib.Path(path).read_text("utf-8", "surrogateescape")


def files_of(text: str, folder: pathlib.Path) -> list[str]:
    """The files that a scene names and that there are, each once, those of included models with them."""
    out: dict[str, None] = {}

    def note(path: str) -> str:
        texts = texts_in(path)
        for file in texts or [path]:
            if file not in out and os.path.isfile(file):
                out[file] = None
                if texts:
                    located(text_of(file), folder, note)
        return path

    located(text, folder, note)
    return list(out)


def write_elsewhere(text: str, folder: pathlib.Path, place: pathlib.Path) -> dict[str, str]:
    """Writes a scene of a folder as the file `place`, and beside it the models that it includes.

    Returns the models' files by their copies.
    """
    copies: dict[str, str] = {}

    def write(words: str, copy: str) -> None:
        pathlib.Path(copy).write_text(located(words, folder, moved), "utf-8", "surrogateescape")

    def moved(path: str) -> str:
        texts = texts_in(path)
        if texts and path not in copies:
            copies[path] = f"{place}.{len(copies)}{pathlib.Path(path).suffix}"
            if os.path.isdir(path):
                os.mkdir(copies[path])
            for file in texts:
                write(text_of(file), copies[path] + file[len(path) :])
        return copies.get(path, path)

    write(text, str(place))
    return {copy: path for path, copy in copies.items()}
