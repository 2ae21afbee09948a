"""The words of the command cloudcontact-study: its help, and what shells and `man` know of it.

Imports nothing of the package, so that the build reads it without the module (plugin/python/shell_files.py).
"""

from __future__ import annotations

import argparse
from typing import Any, Callable, Optional, Sequence, Union

ABOUT = """Runs the trials of a study that have not run yet, each in a process of its own, and writes each as a
row of a SQLite file when it ends. Run again, it goes on where it stopped."""
EXAMPLES = """examples:
  cloudcontact-study pegs.toml                              on all cores here, into pegs.sqlite
  cloudcontact-study pegs.toml --on local:4 --plots out     with 4 processes, then plots
  cloudcontact-study pegs.toml --on dask:tcp://node1:8786   on the workers of a Dask scheduler
  mpirun -n 33 cloudcontact-study pegs.toml --on mpi        on 32 MPI processes; one writes
  cloudcontact-study pegs.toml --try 7                      trial 7 alone, here, without writing it
  cloudcontact-study pegs.toml --again                      what failed, again
  cloudcontact-study pegs.toml --summary --json             what there is, without running
  cloudcontact-study --completion bash > study.bash         for `source study.bash`

exit code: 0 all trials done, 1 some failed or the run ended early, 2 bad input. docs/studies.md is the guide."""
SHELLS = ("bash", "zsh", "fish")
# What tells a text of the parser: its completion for a shell, or its manual page.
Text = Callable[[argparse.ArgumentParser, str], str]


class Print(argparse.Action):
    """An option that prints a text of the parser and ends the program, as --help does."""

    def __init__(self, option_strings: Sequence[str], dest: str, text: Text, **more: Any) -> None:
        super().__init__(option_strings, dest, default=argparse.SUPPRESS, **more)
        self.text = text

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: Union[str, Sequence[Any], None],
        option_string: Optional[str] = None,
    ) -> None:
        print(self.text(parser, values if isinstance(values, str) else ""), end="")
        parser.exit()


def parser(version: str, completion: Text, manual: Text) -> argparse.ArgumentParser:
    out = argparse.ArgumentParser(
        "cloudcontact-study", description=ABOUT, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    out.add_argument("study", metavar="STUDY.toml", help="the study: scene or trial, parameters, design, success")
    out.add_argument(
        "--on", default="local", metavar="WHERE", help="local, local:N processes, dask:ADDRESS or mpi (default: local)"
    )
    out.add_argument("--results", metavar="FILE", help="SQLite file of the results (default: STUDY.sqlite, beside it)")
    out.add_argument("--plots", metavar="FOLDER", help="writes success.png and wrenches.png there")
    out.add_argument("--again", action="store_true", help="runs trials that failed again")
    out.add_argument("--try", type=int, metavar="N", dest="number", help="runs trial N here and prints its outcomes")
    out.add_argument("--summary", action="store_true", help="runs nothing: summary and plots of what there is")
    out.add_argument("--json", action="store_true", help="the summary as JSON")
    out.add_argument("--quiet", action="store_true", help="no progress")
    out.add_argument("--version", action="version", version=f"cloudcontact-study {version}")
    out.add_argument("--completion", action=Print, text=completion, choices=SHELLS, help="prints a shell's completion")
    out.add_argument("--manual", action=Print, text=manual, nargs=0, help="prints the manual page, which `man` shows")
    return out
