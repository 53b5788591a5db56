"""Entry of the `rosproto` command: picks a sub-command and turns its errors into one sentence.

Exit codes: 0 done, 1 it failed (one sentence on stderr says why), 2 wrong usage, 130 interrupted before
it was done.
"""

from __future__ import annotations

import argparse
import logging
import os
import sys
from collections.abc import Sequence

from rosproto.errors import RosError

from .commands import COMMANDS
from .streams import escape_what_cannot_be_printed

__all__ = ["main"]

INTERRUPTED = 130


def main(argv: Sequence[str] | None = None) -> int:
    """Run `rosproto` with these arguments (by default the process's own); the exit code."""
    escape_what_cannot_be_printed()
    words = list(sys.argv[1:] if argv is None else argv)
    if words[:1] == ["run"] and words[1:2] not in (["-h"], ["--help"]):
        # Not by way of all the sub-commands: a program's start should not wait for parsers it has no use for.
        from rosproto.rospy.launch import main as run_program

        return run_program(words[1:], prog="rosproto run")
    parser, name = _parser(words)
    arguments = parser.parse_args(words)
    if name is None:
        parser.print_help(sys.stderr)
        return 2
    _log_to_stderr(arguments.verbose)
    _, run = COMMANDS[name].load()
    try:
        return run(arguments)
    except (RosError, ValueError) as error:
        print(f"rosproto {name}: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        # The reader (head, less) has enough. What is still buffered must not raise again at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


def _parser(words: Sequence[str]) -> tuple[argparse.ArgumentParser, str | None]:
    """A parser that knows all commands by name and the asked one in full; and that one's name."""
    parser = argparse.ArgumentParser(prog="rosproto", description="ROS 1 without a ROS installation.")
    choices = parser.add_subparsers(title="commands", metavar="COMMAND")
    asked = next((word for word in words if word in COMMANDS), None)
    for name, command in COMMANDS.items():
        sub = choices.add_parser(name, help=command.help, description=command.help)
        if name == asked:
            sub.add_argument("-v", "--verbose", action="count", default=0, help="log; twice: log everything")
            command.load()[0](sub)
    return parser, asked


def _log_to_stderr(verbosity: int) -> None:
    level = (logging.WARNING, logging.INFO, logging.DEBUG)[min(verbosity, 2)]
    logging.basicConfig(level=level, format="%(asctime)s %(levelname)s %(message)s", stream=sys.stderr)
