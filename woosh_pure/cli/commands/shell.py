"""`woosh shell`: Python with `chassis` ready."""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace
from typing import Any

from rosproto.cli import unguarded
from rosproto.errors import RosError
from rosproto.sentence import say
from woosh_pure.cli.connection import connect
from woosh_pure.cli.output import Output

HELP = "open Python with `chassis` ready"
_TRY = "Try: chassis.battery.wait()   chassis.readiness()   chassis.move(0.3).wait()   chassis.stop()"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    parser.add_argument("-c", dest="code", metavar="CODE", help="run this instead of asking for input")


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    if args.json:
        raise ValueError("--json: the shell prints what you print; use json.dumps inside")
    with connect(args, out) as chassis:
        names = _names(chassis)
        try:
            with unguarded():
                if args.code is not None:
                    _execute(args.code, names)
                else:
                    banner = (
                        say("Python with `chassis` ready, connected to {uri}.", uri=chassis.master_uri),
                        _TRY,
                        "Leaving (Ctrl-D, Ctrl-Z Enter on Windows) cancels what is still running.",
                    )
                    _interact(names, "\n".join(map(out.say, banner)))
        except SystemExit as leaving:
            return _exit_code(leaving.code)
    return 0


def _exit_code(code: object) -> int:
    """Return the exit code as Python does: None is 0, a text is printed and gives 1."""
    if code is None or isinstance(code, int):
        return int(code or 0)
    print(code, file=sys.stderr)
    return 1


def _execute(text: str, names: dict[str, Any]) -> None:
    try:
        exec(compile(text, "<woosh shell>", "exec"), names)
    except (RosError, OSError):
        raise
    except Exception as error:
        raise RosError(say("your code: {name}: {error}", name=type(error).__name__, error=error)) from error


def _names(chassis: Any) -> dict[str, Any]:
    import math

    import woosh_pure
    from woosh_pure import enums

    names = {name: getattr(woosh_pure, name) for name in woosh_pure.__all__}
    names.update({name: getattr(enums, name) for name in enums.__all__})
    return {**names, "chassis": chassis, "math": math, "__name__": "__console__"}


def _interact(names: dict[str, Any], banner: str) -> None:
    import code

    if sys.platform != "win32":  # Windows' console has line editing of its own
        try:
            import readline
            import rlcompleter

            readline.set_completer(rlcompleter.Completer(names).complete)
            readline.parse_and_bind("tab: complete")
        except ImportError:
            pass  # a Python built without it
    code.interact(banner=banner, local=names, exitmsg="")
