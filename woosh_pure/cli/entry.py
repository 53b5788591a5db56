"""Arguments, signals and errors of the `woosh` command."""

from __future__ import annotations

import argparse
import signal
import sys
from collections.abc import Sequence
from types import FrameType
from typing import Any, NoReturn

from rosproto.errors import RosError

from .output import Output
from .registry import COMMANDS, load

__all__ = ["Terminated", "main"]

INTERRUPTED = 130
TERMINATED = 143


class Terminated(BaseException):
    """SIGTERM, a hang-up or a closed console: like Ctrl-C it unwinds the program, so that motion is
    stopped.
    """


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command; returns the exit code: 0 done, 1 failed, 2 wrong use, 130 interrupted, 143
    terminated.
    """
    parser = _parser()
    args = parser.parse_args(argv)
    if args.command is None:
        parser.print_help()
        return 2
    _install_signals()
    try:
        return load(args.command).run(args, Output(as_json=args.json))
    except KeyboardInterrupt:
        return _say("interrupted", INTERRUPTED)
    except Terminated:
        return _say("terminated", TERMINATED)
    except BrokenPipeError:
        sys.stderr.close()  # the reader of our output has gone; nothing more can be said
        return 1
    except (RosError, ValueError, OSError, KeyError) as error:
        if args.debug:
            raise
        text = error.args[0] if isinstance(error, KeyError) and error.args else error
        return _say(f"{args.command}: {text}", 2 if isinstance(error, ValueError) else 1)


def _say(text: str, code: int) -> int:
    print(f"woosh: {text}", file=sys.stderr, flush=True)
    return code


def _install_signals() -> None:
    def terminate(number: int, frame: FrameType | None) -> NoReturn:
        raise Terminated

    # SIGBREAK is what a closed Windows console sends; SIGHUP a closed terminal elsewhere.
    for name in ("SIGTERM", "SIGHUP", "SIGBREAK"):
        number = getattr(signal, name, None)
        if number is not None:
            try:
                signal.signal(number, terminate)
            except ValueError:
                return  # not in the main thread: the program that called us owns the signals


def _parser() -> argparse.ArgumentParser:
    common = _common()
    parser = argparse.ArgumentParser(
        prog="woosh",
        description="Drive a Woosh chassis, or the simulated one.",
        parents=[_common(defaults=True)],
        epilog="Stopping by this program is no emergency stop: keep the red button in reach.",
    )
    commands = parser.add_subparsers(dest="command", metavar="COMMAND")
    for name in COMMANDS:
        command = load(name)
        sub = commands.add_parser(name, help=command.HELP, description=command.HELP, parents=[common])
        command.add_arguments(sub)
    return parser


def _common(*, defaults: bool = False) -> argparse.ArgumentParser:
    # The options are accepted before and after the command; only the first place has defaults, or the second
    # would overwrite what was given.
    none: dict[str, Any] = {"default": None if defaults else argparse.SUPPRESS}
    false: dict[str, Any] = {"default": False if defaults else argparse.SUPPRESS}
    parser = argparse.ArgumentParser(add_help=False)
    group = parser.add_argument_group("which chassis (default: $ROS_MASTER_URI)")
    group.add_argument("--chassis", metavar="HOST", help="address of the chassis, e.g. 169.254.128.2", **none)
    group.add_argument("--master", metavar="URI", help="URI of its ROS master", **none)
    group.add_argument(
        "--sim", action="store_true", help="a simulated chassis, started for this command", **false
    )
    group.add_argument("--host", metavar="ADDRESS", help="our own address, as the robot reaches it", **none)
    general = parser.add_argument_group("general")
    general.add_argument("--json", action="store_true", help="one JSON document instead of lines", **false)
    general.add_argument("--debug", action="store_true", help="show the traceback of an error", **false)
    return parser
