"""Entry of the `rosproto` command: picks a sub-command and turns its errors into one sentence."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from rosproto.version import __version__

from .commands import COMMANDS
from .examples import EXAMPLES
from .failure import DONE, FAILED, INTERRUPTED, TERMINATED, UNREACHABLE, WRONG_USE, say
from .parser import Parser, give_examples, leaves, options_of
from .process import Task, exit_codes_line, run_command, words_of

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
    words = behind_the_verb(words_of(argv))
    if words[:1] == ["run"] and words[1:2] not in (["-h"], ["--help"]):
        # Not by way of all the sub-commands: a program's start should not wait for parsers it has no use for.
        from rosproto.rospy.launch import main as run_program

        return run_program(words[1:], prog="rosproto run")
    return run_command(words, parser_for, _task, until_exit=argv is None)


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


def _task(arguments: argparse.Namespace) -> Task:
    def run() -> int:
        _log_to_stderr(arguments.verbose)
        code: int = arguments.run(arguments)
        # What was read from a damaged bag may not be all; see `bag_opening.opened`.
        return code or (FAILED if getattr(arguments, "incomplete", False) else DONE)

    def failed(text: str, code: int) -> None:
        hint = "; try: rosproto doctor" if code == UNREACHABLE and arguments.command != "doctor" else ""
        if code not in (INTERRUPTED, TERMINATED):
            say(f"rosproto {arguments.command}: {text}{hint}")

    return Task(run, failed, arguments.debug)


def parser_for(words: Sequence[str]) -> Parser:
    """A parser that knows all commands by name, and the asked one in full."""
    parser = Parser(
        prog="rosproto",
        description="ROS 1 without a ROS installation.",
        epilog=exit_codes_line(EXIT_CODES),
    )
    add_general_options(parser, 0, False)
    parser.add_argument("--version", action="version", version=f"rosproto {__version__}")
    choices = parser.add_subparsers(title="commands", metavar="COMMAND", dest="command")
    asked = next((word for word in words if word in COMMANDS), None)
    for name, command in COMMANDS.items():
        sub = choices.add_parser(name, help=command.help, description=command.help)
        if name == asked:
            command.add_arguments(sub)
            give_examples(sub, EXAMPLES)
            for place in {id(p): p for p in (sub, *leaves(sub))}.values():
                add_general_options(place, argparse.SUPPRESS, argparse.SUPPRESS)
    return parser


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
