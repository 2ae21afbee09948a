"""Writes the completion scripts and the manual page of cloudcontact-study: shell_files.py VERSION FOLDER.

Needs neither the module nor numpy, so that a build can run it.
"""

import pathlib
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).parent / "cloudcontact/study"))
import command_line  # noqa: E402
import shell_text  # noqa: E402

version, folder = sys.argv[1], pathlib.Path(sys.argv[2])
parser = command_line.parser(version, shell_text.completion, shell_text.manual)
for shell in command_line.SHELLS:
    (folder / f"study.{shell}").write_text(shell_text.completion(parser, shell))
(folder / "study.1").write_text(shell_text.manual(parser))
