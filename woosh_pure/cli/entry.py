"""Arguments, signals and errors of the `woosh` command."""

from __future__ import annotations

import argparse
import signal
import sys
from collections.abc import Sequence
from types import FrameType
from typing import Any, NoReturn

from rosproto.cli.streams import escape_what_cannot_be_printed
from rosproto.errors import ConnectionLost, RosError

from .console import linger_when_closed
from .output import Output
from .registry import COMMANDS, Command, load

__all__ = ["EXIT_CODES", "Terminated", "main", "parser_for"]

DONE, FAILED, WRONG_USE, REFUSED, UNREACHABLE = 0, 1, 2, 3, 4
INTERRUPTED, TERMINATED = 130, 143
EXIT_CODES = {
    DONE: "done",
    FAILED: "it failed; one sentence on stderr says why and what to do",
    WRONG_USE: "wrong use: an argument is missing, unknown or out of range; nothing was sent",
    REFUSED: "the chassis is not ready, or refused to move",
    UNREACHABLE: "the chassis cannot be reached, or the connection was lost",
    INTERRUPTED: "interrupted by Ctrl-C; a motion of this command was stopped",
    TERMINATED: "ended by SIGTERM, a hang-up or a closed console; a motion of this command was stopped",
}
"""What the exit codes mean."""


class Terminated(BaseException):
    """SIGTERM, a hang-up or a closed console: like Ctrl-C it unwinds the program, so that motion is
    stopped.
    """


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command; returns the exit code, see `EXIT_CODES`."""
    escape_what_cannot_be_printed()
    words = list(sys.argv[1:] if argv is None else argv)
    parser = parser_for(words)
    args = parser.parse_args(words)
    if args.command is None:
        parser.print_help()
        return WRONG_USE
    _install_signals()
    out = Output(as_json=args.json)
    with linger_when_closed(_raise_terminated):
        return _run(load(args.command), args, out)


def _run(command: Command, args: argparse.Namespace, out: Output) -> int:
    try:
        return command.run(args, out)
    except KeyboardInterrupt:
        return _say("interrupted", INTERRUPTED)
    except Terminated:
        return _say("terminated", TERMINATED)
    except BrokenPipeError:
        sys.stderr.close()  # the reader of our output has gone; nothing more can be said
        return FAILED
    except Exception as error:
        if args.debug:
            raise
        text, code = _explain(error)
        out.failure(text, code)
        return _say(f"{args.command}: {text}", code)


def _explain(error: Exception) -> tuple[str, int]:
    """One sentence and the exit code."""
    text = str(error.args[0] if isinstance(error, KeyError) and error.args else error)
    if isinstance(error, ConnectionLost):
        return text, UNREACHABLE
    if type(error).__name__ == "MotionRefused":  # by name: importing it would load the chassis for --help
        return text, REFUSED
    if isinstance(error, ValueError) and not isinstance(error, RosError):
        return text, WRONG_USE
    if isinstance(error, (RosError, ValueError, OSError, KeyError)):
        return text, FAILED
    return f"{type(error).__name__}: {text}; this is a mistake of ours, please report it with --debug", FAILED


def _say(text: str, code: int) -> int:
    try:
        print(f"woosh: {text}", file=sys.stderr, flush=True)
    except OSError:
        pass  # the terminal has gone: the exit code is all that is left to say
    return code


def _raise_terminated(number: int, frame: FrameType | None) -> NoReturn:
    raise Terminated


def _install_signals() -> None:
    # SIGBREAK is Ctrl-Break, and what a closed Windows console sends; SIGHUP a closed terminal elsewhere.
    for name in ("SIGTERM", "SIGHUP", "SIGBREAK"):
        number = getattr(signal, name, None)
        if number is not None:
            try:
                signal.signal(number, _raise_terminated)
            except ValueError:
                return  # not in the main thread: the program that called us owns the signals


def parser_for(words: Sequence[str]) -> argparse.ArgumentParser:
    """A parser that knows the command named in `words` in full and the others by their help line."""
    common = _common()
    parser = argparse.ArgumentParser(
        prog="woosh",
        description="Drive a Woosh chassis, or the simulated one.",
        parents=[_common(defaults=True)],
        epilog="Stopping by this program is no emergency stop: keep the red button in reach. "
        "Exit codes: "
        + "; ".join(f"{code} {text.partition(';')[0].partition(':')[0]}" for code, text in EXIT_CODES.items())
        + ".",
    )
    commands = parser.add_subparsers(dest="command", metavar="COMMAND")
    asked = _asked(words)
    for name in COMMANDS if asked is None else (asked,):
        command = load(name)
        sub = commands.add_parser(name, help=command.HELP, description=command.HELP, parents=[common])
        if asked is not None:
            command.add_arguments(sub)
            _add_below(sub, common)
    return parser


def _add_below(parser: argparse.ArgumentParser, common: argparse.ArgumentParser) -> None:
    """Let the verbs of a command understand the common options too."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for verb in action.choices.values():
                verb._add_container_actions(common)


def _asked(words: Sequence[str]) -> str | None:
    """The command among the words; what follows an option of ours that takes a value is no command."""
    takes_value = {text for a in _common()._actions if a.nargs != 0 for text in a.option_strings}
    for before, word in zip(["", *words], words, strict=False):
        if before not in takes_value and not word.startswith("-"):
            return word if word in COMMANDS else None
    return None


def _common(*, defaults: bool = False) -> argparse.ArgumentParser:
    # The options are accepted before and after the command; only the first place has defaults, or the second
    # would overwrite what was given.
    none: dict[str, Any] = {"default": None if defaults else argparse.SUPPRESS}
    false: dict[str, Any] = {"default": False if defaults else argparse.SUPPRESS}
    parser = argparse.ArgumentParser(add_help=False)
    group = parser.add_argument_group("which chassis (default: $ROS_MASTER_URI, then `woosh connect`'s)")
    group.add_argument("--chassis", metavar="HOST", help="address of the chassis, e.g. 169.254.128.2", **none)
    group.add_argument("--master", metavar="URI", help="URI of its ROS master", **none)
    group.add_argument(
        "--sim", action="store_true", help="a simulated chassis, started for this command", **false
    )
    group.add_argument(
        "--sim-speed", type=float, metavar="X", help="simulated seconds per second, with --sim", **none
    )
    group.add_argument("--host", metavar="ADDRESS", help="our own address, as the robot reaches it", **none)
    group.add_argument(
        "--msg-path",
        action="append",
        metavar="FOLDER",
        help="a folder of .msg, .srv and .action files: further revisions for robots that have them",
        **none,
    )
    group.add_argument(
        "--no-learned", action="store_true", help="do without what `woosh learn` has kept", **false
    )
    general = parser.add_argument_group("general")
    general.add_argument("--json", action="store_true", help="JSON for programs instead of lines", **false)
    general.add_argument("--debug", action="store_true", help="show the traceback of an error", **false)
    return parser
