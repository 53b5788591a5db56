"""`--help` by itself, the most typed of all command lines: a text, without the parser that it was made from.

Loading argparse and the commands takes several times as long as starting Python. `python -m tools.manual`
writes the text (`help.txt` beside the entry of each command) from the parser, as it looks on 80 columns.
Wider terminals show the same lines, narrower ones ask the parser.
"""

from __future__ import annotations

import os
import sys

TYPE_CHECKING = False  # as in typing, which takes longer to load than all of this
if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["COLUMNS", "FILE", "show"]

COLUMNS = 80
"""The width the text is made for."""
FILE = "help.txt"
_ALONE = (["--help"], ["-h"])
_WRONG_USE = 2


def show(module: str, words: Sequence[str]) -> int | None:
    """Show the help of the command whose entry is the module with this path; the exit code.

    None: this is the parser's to do, because the words are others, the terminal is narrow, or nothing is
    there to write to or to read from (a frozen program). Without any word the help goes to stderr, and the
    code is 2.
    """
    asked = list(words) in _ALONE
    stream = sys.stdout if asked else sys.stderr
    if (words and not asked) or sys.stdout is None or stream is None or _columns() < COLUMNS:
        return None
    try:
        with open(os.path.join(os.path.dirname(module), FILE), encoding="utf-8") as file:
            text = file.read()
    except OSError:
        return None
    try:
        stream.write(text)
    except OSError:
        pass  # nobody reads it: as argparse has it; what is still buffered fails when Python ends
    return 0 if asked else _WRONG_USE


def _columns() -> int:
    """As `shutil.get_terminal_size`, which argparse asks."""
    try:
        columns = int(os.environ["COLUMNS"])
    except (KeyError, ValueError):
        columns = 0
    if columns > 0:
        return columns
    try:
        # The stream that was there first: what a program has put in its place is no terminal.
        columns = os.get_terminal_size(sys.__stdout__.fileno()).columns  # type: ignore[union-attr]
    except (AttributeError, ValueError, OSError):
        columns = 0
    return columns or COLUMNS
