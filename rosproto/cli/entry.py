"""Entry of the `rosproto` command: picks a sub-command and turns its errors into one sentence."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from contextlib import nullcontext

from rosproto.version import __version__

from .background_output import everything_is_written, hurry, in_background
from .closed_console import linger_when_closed
from .commands import COMMANDS
from .examples import EXAMPLES
from .failure import (
    DONE,
    FAILED,
    INTERRUPTED,
    TERMINATED,
    UNREACHABLE,
    WRONG_USE,
    Terminated,
    explain,
    output_is_gone,
    say,
    signals_unwind,
)
from .parser import Parser, give_examples, leaves, options_of
from .streams import as_typed, escape_what_cannot_be_printed, guarded

__all__ = ["EXIT_CODES", "add_general_options", "main", "parser_for"]

EXIT_CODES = {
    DONE: "done",
    FAILED: "it failed, or the answer is no; one sentence on stderr says why and what to do",
    WRONG_USE: "wrong use: an argument is missing, unknown or out of range",
    UNREACHABLE: "the master or a node cannot be reached, or the connection was lost",
    INTERRUPTED: "interrupted by Ctrl-C before it was done",
    TERMINATED: "ended by SIGTERM, a hang-up or a closed console",
}
"""What the exit codes mean."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run `rosproto` with these arguments (by default the process's own); the exit code."""
    escape_what_cannot_be_printed()
    words = behind_the_verb(as_typed(sys.argv[1:] if argv is None else argv))
    if words[:1] == ["run"] and words[1:2] not in (["-h"], ["--help"]):
        # Not by way of all the sub-commands: a program's start should not wait for parsers it has no use for.
        from rosproto.rospy.launch import main as run_program

        return run_program(words[1:], prog="rosproto run")
    with in_background() if argv is None else nullcontext(), guarded():
        return _command(words, until_exit=argv is None)


def _command(words: list[str], *, until_exit: bool) -> int:
    try:
        parser, name = parser_for(words)
        arguments = parser.parse_args(words)
    except KeyboardInterrupt:
        return INTERRUPTED
    if name is None:
        parser.print_help(sys.stderr)
        return WRONG_USE
    return _run(name, arguments, until_exit=until_exit)


_WITHOUT_VERBS = ("graph", "doctor", "bridge", "foxglove", "run", "master", "completion")


def behind_the_verb(words: Sequence[str]) -> list[str]:
    """Move leading options behind the verb: `--master URI topic list` is `topic list --master URI`."""
    early: list[str] = []
    rest = list(words)
    while rest and rest[0].partition("=")[0] in (
        "--master",
        "--msg-path",
        "--resolve",
        "--json",
        "--no-learned",
    ):
        takes_value = rest[0] in ("--master", "--msg-path", "--resolve")
        early += rest[: 1 + takes_value]
        del rest[: 1 + takes_value]
    verb = rest[1:2] if rest[:1] and rest[0] not in _WITHOUT_VERBS else []
    at = 1 + sum(not word.startswith("-") for word in verb)
    return [*rest[:at], *early, *rest[at:]] if early else list(words)


def _run(name: str, arguments: argparse.Namespace, *, until_exit: bool) -> int:
    try:
        with signals_unwind(until_exit=until_exit), linger_when_closed():
            _log_to_stderr(arguments.verbose)
            code: int = arguments.run(arguments)
            everything_is_written()  # a full disk or a closed pipe shows here, not at exit
            # What was read from a damaged bag may not be all; see `bag_opening.opened`.
            return code or (FAILED if getattr(arguments, "incomplete", False) else DONE)
    except KeyboardInterrupt:
        hurry()
        return INTERRUPTED
    except Terminated:
        hurry()
        return TERMINATED
    except BrokenPipeError:
        output_is_gone()
        return DONE
    except Exception as error:
        if arguments.debug:
            raise
        text, code = explain(error)
        hint = "; try: rosproto doctor" if code == UNREACHABLE and name != "doctor" else ""
        say(f"rosproto {name}: {text}{hint}")
        return code


def parser_for(words: Sequence[str]) -> tuple[Parser, str | None]:
    """A parser that knows all commands by name and the asked one in full; and that one's name."""
    parser = Parser(
        prog="rosproto",
        description="ROS 1 without a ROS installation.",
        epilog="Exit codes: "
        + "; ".join(f"{code} {text.partition(';')[0].partition(':')[0]}" for code, text in EXIT_CODES.items())
        + ".",
    )
    add_general_options(parser, 0, False)
    parser.add_argument("--version", action="version", version=f"rosproto {__version__}")
    choices = parser.add_subparsers(title="commands", metavar="COMMAND")
    asked = next((word for word in words if word in COMMANDS), None)
    for name, command in COMMANDS.items():
        sub = choices.add_parser(name, help=command.help, description=command.help)
        if name == asked:
            command.add_arguments(sub)
            give_examples(sub, EXAMPLES)
            for place in {id(p): p for p in (sub, *leaves(sub))}.values():
                add_general_options(place, argparse.SUPPRESS, argparse.SUPPRESS)
    return parser, asked


def add_general_options(parser: argparse.ArgumentParser, count: object, debug: object) -> None:
    """--debug and --verbose, before and after the command; `topic list -v` keeps rostopic's meaning."""
    taken = options_of(parser)
    names = [name for name in ("-v", "--verbose") if name not in taken]
    if names:
        parser.add_argument(
            *names, dest="verbose", action="count", default=count, help="log; twice: everything"
        )
    if "--debug" not in taken:
        parser.add_argument(
            "--debug", action="store_true", default=debug, help="show the traceback of an error"
        )


def _log_to_stderr(verbosity: int) -> None:
    import logging

    level = (logging.WARNING, logging.INFO, logging.DEBUG)[min(verbosity, 2)]
    logging.basicConfig(level=level, format="%(asctime)s %(levelname)s %(message)s", stream=sys.stderr)
