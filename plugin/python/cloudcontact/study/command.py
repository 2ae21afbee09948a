"""The command cloudcontact-study."""

from __future__ import annotations

import argparse
import contextlib
import json
import pathlib
import sys
from typing import Iterator, Optional, Sequence

from .._core import __version__
from . import shell_text
from .command_line import parser
from .errors import StudyError, StudyStopped
from .executors import On, open_executor
from .results import Results
from .study import Study
from .study_file import load
from .study_plots import new_figure, plot_success, plot_wrenches, wrench_names
from .summary import summarize

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130


class Tenths:
    """Progress for logs: a line at each tenth of the trials to run."""

    def __init__(self, name: str) -> None:
        self.name, self.told = name, 0

    def __call__(self, share: float) -> None:
        if int(10 * share) > self.told:
            self.told = int(10 * share)
            print(f"{self.name}: {10 * self.told} % of the trials that were to run", file=sys.stderr, flush=True)


def try_one(study: Study, number: int) -> int:
    """Prints a trial's parameters and outcomes."""
    if not 0 <= number < len(study):
        raise StudyError(f"--try: there are trials 0 to {len(study) - 1}")
    point = study.points[number]
    try:
        outcomes = study.once(number)
    except Exception as bad:
        print(f"trial {number} {point.parameters}: {type(bad).__name__}: {bad}", file=sys.stderr)
        return FAILED
    print(json.dumps({"number": number, "seed": point.seed, **point.parameters, **outcomes}, indent=2))
    return DONE


def make_folder(plots: str) -> None:
    try:
        pathlib.Path(plots).mkdir(parents=True, exist_ok=True)
    except OSError as bad:
        raise StudyError(f"--plots: no folder '{plots}' can be made: {bad.strerror}") from None


def show(results: Results, words: argparse.Namespace) -> int:
    """Summary and plots; the exit code."""
    summary = summarize(results)
    print(json.dumps(summary.json(), indent=2) if words.json else summary)
    for status in ("failed", "crashed", "timeout"):
        for row in results.rows(status)[:1]:
            first = f"the first, trial {row['number']}: {row['error']}"
            print(f"cloudcontact-study: {summary.counts[status]} {status}; {first}", file=sys.stderr)
    if words.plots:
        folder = pathlib.Path(words.plots)
        if summary.success is not None:
            plot_success(results, file=folder / "success.png")
        if summary.counts.get("done") and wrench_names(results):
            plot_wrenches(results, file=folder / "wrenches.png")
    return DONE if set(summary.counts) == {"done"} else FAILED


def run(words: argparse.Namespace, on: On) -> int:
    """The command where it writes: the only process, or MPI's first."""
    file = pathlib.Path(words.study)
    path = pathlib.Path(words.results) if words.results else file.with_suffix(".sqlite")
    study = load(file)
    if words.plots:  # what is missing ends the study here, not after a thousand trials
        new_figure(1, 1)
    if words.number is not None:
        return try_one(study, words.number)
    if words.plots:
        make_folder(words.plots)
    if not words.summary:
        seen = None if sys.stderr.isatty() else Tenths(study.name)
        study.run(path, on, again=words.again, progress=False if words.quiet else seen).close()
    with Results(path) as results:
        return show(results, words)


@contextlib.contextmanager
def where(on: str) -> Iterator[Optional[On]]:
    """MPI's executor, which all ranks enter before anything can go wrong in one of them; else `on`."""
    if on != "mpi":
        yield on
        return
    with open_executor(on) as executor:
        yield executor


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """The command; its exit code."""
    words = parser(__version__, shell_text.completion, shell_text.manual).parse_args(arguments)
    try:
        with where(words.on) as on:
            return DONE if on is None else run(words, on)
    except StudyError as bad:
        print(f"cloudcontact-study: {bad}", file=sys.stderr)
        return BAD_INPUT
    except (StudyStopped, OSError) as bad:
        print(f"cloudcontact-study: {bad}", file=sys.stderr)
        return FAILED
    except KeyboardInterrupt:
        print("cloudcontact-study: stopped; run it again to go on", file=sys.stderr)
        return INTERRUPTED
