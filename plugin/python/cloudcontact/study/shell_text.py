"""What shells and `man` know of a command, from its parser: the place that --help comes from.

Imports nothing of the package, as command_line.py.
"""

from __future__ import annotations

import argparse
import re
import shlex
from typing import List, NamedTuple, Tuple


class Option(NamedTuple):
    names: List[str]
    word: str  # what it takes; empty for a flag
    choices: Tuple[str, ...]  # of that
    help: str


def options_of(parser: argparse.ArgumentParser) -> List[Option]:
    """All options, in the order of the help."""
    out = []
    for action in parser._actions:
        if action.option_strings:
            choices = tuple(map(str, action.choices or ()))
            word = str(action.metavar or "|".join(choices) or action.dest.upper()) if action.nargs != 0 else ""
            out.append(Option(list(action.option_strings), word, choices, action.help or ""))
    return out


def bash(parser: argparse.ArgumentParser) -> str:
    function = "_" + re.sub(r"\W", "_", parser.prog)
    options = options_of(parser)
    names = " ".join(name for option in options for name in option.names)
    cases = "".join(
        f"    {'|'.join(option.names)}) words='{' '.join(option.choices)}' ;;\n" for option in options if option.choices
    )
    return f"""# bash completion of {parser.prog}
{function}() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} words=
  COMPREPLY=()
  case ${{COMP_WORDS[COMP_CWORD-1]}} in
{cases}  esac
  if [ -z "$words" ] && [ "${{word#-}}" != "$word" ]; then
    words='{names}'
  fi
  if [ -n "$words" ]; then
    COMPREPLY=($(compgen -W "$words" -- "$word"))
  else
    COMPREPLY=($(compgen -f -- "$word"))
  fi
}}
complete -o filenames -F {function} {parser.prog}
"""


def zsh(parser: argparse.ArgumentParser) -> str:
    lines = []
    for option in options_of(parser):
        what = re.sub(r"([\[\]:\\])", r"\\\1", option.help)  # _arguments' own
        values = f":value:({' '.join(option.choices)})" if option.choices else f":{option.word.lower()}:_files"
        lines += [shlex.quote(f"{name}[{what}]{values if option.word else ''}") for name in option.names]
    arguments = "".join(f" \\\n  {line}" for line in lines)
    return f"#compdef {parser.prog}\n_arguments -S{arguments} \\\n  '*:file:_files'\n"


def fish(parser: argparse.ArgumentParser) -> str:
    out = f"# fish completion of {parser.prog}\n"
    for option in options_of(parser):
        line = f"complete -c {parser.prog}"
        line += "".join(f" -l {name[2:]}" if name.startswith("--") else f" -s {name[1:]}" for name in option.names)
        line += " -r" if option.word else ""
        line += f" -f -a '{' '.join(option.choices)}'" if option.choices else ""
        quoted = option.help.replace("\\", "\\\\").replace("'", "\\'")
        out += f"{line} -d '{quoted}'\n"
    return out


def completion(parser: argparse.ArgumentParser, shell: str) -> str:
    """The completion of bash, zsh or fish."""
    return {"bash": bash, "zsh": zsh, "fish": fish}[shell](parser)


def roff(text: str) -> str:
    """Plain text of roff: backslashes, hyphens and a line's first dot or quote are its own."""
    return re.sub(r"^(?=[.'])", r"\\&", text.replace("\\", "\\e").replace("-", "\\-"), flags=re.M)


def manual(parser: argparse.ArgumentParser, _: str = "") -> str:
    """The manual page in roff."""
    version = next((str(action.version) for action in parser._actions if hasattr(action, "version")), parser.prog)
    name = roff(parser.prog)
    words = " ".join(str(a.metavar or a.dest) for a in parser._actions if not a.option_strings)
    about = parser.description or ""
    examples, _, end = (parser.epilog or "").partition("\n\n")
    lines = "\n".join(line.strip() for line in examples.split("\n")[1:])
    text = f""".TH {parser.prog.upper()} 1 "" "{version}"
.SH NAME
{name} \\- studies of contact: trials of a scene over its parameters
.SH SYNOPSIS
\\fB{name}\\fR \\fI{roff(words)}\\fR [\\fIoptions\\fR]
.SH DESCRIPTION
{roff(about)}
.SH OPTIONS
"""
    for action in parser._actions:
        if not action.option_strings:
            text += f".TP\n\\fI{roff(str(action.metavar or action.dest))}\\fR\n{roff(action.help or '')}\n"
    for option in options_of(parser):
        names = ", ".join(f"\\fB{roff(one)}\\fR" for one in option.names)
        word = f" \\fI{roff(option.word)}\\fR" if option.word else ""
        text += f".TP\n{names}{word}\n{roff(option.help)}\n"
    text += f".SH EXAMPLES\n.nf\n{roff(lines)}\n.fi\n.SH EXIT STATUS\n{roff(end.partition(': ')[2])}\n"
    return text + ".SH SEE ALSO\n\\fBcloudcontact\\fR(1)\n"
