"""Entry of the `woosh` command: the arguments of all its commands, its errors and its examples."""

from __future__ import annotations

import argparse
import logging
import sys
from collections.abc import Sequence
from functools import partial

from rosproto import sentence
from rosproto.cli import (
    INTERRUPTED,
    TERMINATED,
    WRONG_USE,
    Parser,
    Task,
    Terminated,
    WrongUse,
    exit_codes_line,
    explain,
    give_examples,
    host,
    linger_when_closed,
    positive,
    run_command,
    say,
    signals_unwind,
    words_of,
)
from rosproto.errors import RosError
from rosproto.version import __version__
from woosh_pure.cli.arguments import EachChassis
from woosh_pure.cli.commands import COMMANDS, add_arguments, run
from woosh_pure.cli.output import EXIT_CODES, LogLines, Output
from woosh_pure.hints import COMMANDS as GUESSED_COMMANDS
from woosh_pure.hints import meant
from woosh_pure.language import LANGUAGES, language_of, translated

COMMON_LINE = (
    "Which chassis (--chassis, --master, --sim), --json, --lang and the other options of every command: "
    "woosh --help"
)
_NOT_THERE = "a node of the chassis is down, or this chassis does not have it; try `woosh doctor`"
ADVICE = {
    "readiness-and-faults": "see `woosh ready` and `woosh faults`",
    "readiness": "see `woosh ready` for what is in the way",
    "far": "for longer distances: woosh goto --pose X Y DEGREES",
    "start": "the pose is not known ({topic} is silent); give --start X Y DEGREES",
    "not-there": _NOT_THERE,
}
"""What a command says in place of advice of the API: by its key, a template."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command; returns the exit code, see `EXIT_CODES`."""
    words = words_of(argv)
    language = language_of(words, stream=sys.stdout)
    if logging.lastResort is not None:
        logging.lastResort.setFormatter(LogLines(language))
    try:
        if _asked(words) == "run" and not parser_for(words, language).parse_args(words).watch:
            return _run_program(words, language)
        return run_command(
            words,
            lambda words: parser_for(words, language),
            lambda args: _task(args, Output(as_json=args.json, language=language)),
            until_exit=argv is None,
        )
    except WrongUse as error:
        Output(as_json="--json" in words).failure(error.text, WRONG_USE)
        raise


def _run_program(words: Sequence[str], language: str) -> int:
    """Run a program of the user: it owns the process, with its output and exit code.

    A signal that ends other commands ends it as Ctrl-C does, so that what it has begun is stopped; a program
    may have handlers of its own.
    """
    args = parser_for(words, language).parse_args(words)
    task = _task(args, Output(as_json=args.json, language=language))
    try:
        with signals_unwind(until_exit=True, interrupt=False), linger_when_closed():
            return task.run()
    except Terminated:
        task.failed("terminated", TERMINATED)
        return TERMINATED
    except (RosError, ValueError, OSError) as error:
        if args.debug:
            raise
        text, code = explain(error)
        task.failed(text, code)
        return code


def _task(args: argparse.Namespace, out: Output) -> Task:
    def failed(text: str, code: int) -> None:
        text = text.advised(ADVICE) if isinstance(text, sentence.Sentence) else text
        try:
            out.failure(text, code)
        except (OSError, ValueError):
            pass  # stdout itself failed
        where = "" if code in (INTERRUPTED, TERMINATED) else f"{args.command}: "
        say(f"woosh: {where}{out.say(text)}")

    return Task(lambda: run(args.command, args, out), failed, args.debug)


def _speaking(language: str) -> type[Parser]:
    """Return a parser class with errors in `language`; argparse uses it for the verbs, too."""

    class Speaking(Parser):
        def spoken(self, text: str) -> str:
            return translated(text, language)

    return Speaking


def parser_for(words: Sequence[str], language: str = "en") -> Parser:
    """Return a parser with the full command of `words`, and only the help lines of the others."""
    common = _common()
    parser = _speaking(language)(
        prog="woosh",
        description="Drive a Woosh chassis, or the simulated one.",
        parents=[_common(defaults=True)],
        epilog=sentence.say(
            "Stopping by this program is not an emergency stop: keep the red button within reach. {codes}",
            codes=exit_codes_line(EXIT_CODES),
        ),
    )
    parser.meant = partial(meant, GUESSED_COMMANDS)
    parser.add_argument("--version", action="version", version=f"woosh {__version__}")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND")
    asked = _asked(words)
    for name in COMMANDS if asked is None else (asked,):
        text = COMMANDS[name]
        sub = commands.add_parser(name, help=text, description=text, shared=common, epilog=COMMON_LINE)
        if asked is not None:
            add_arguments(name, sub)
            give_examples(sub, EXAMPLES)
    return parser


def _asked(words: Sequence[str]) -> str | None:
    """Return the command among the words; the value of an option is not a command."""
    takes_value = _common().options_with_value()
    for before, word in zip(["", *words], words, strict=False):
        if before not in takes_value and not word.startswith("-"):
            return word if word in COMMANDS else None
    return None


def _common(*, defaults: bool = False) -> Parser:
    # The options are accepted before and after the command; only the first place has defaults, or the second
    # would overwrite what was given.
    parser = Parser(add_help=False, argument_default=None if defaults else argparse.SUPPRESS)
    group = parser.add_argument_group("which chassis (default: $ROS_MASTER_URI, then `woosh connect`'s)")
    group.add_argument(
        "--chassis",
        metavar="HOST",
        action=EachChassis,
        gathered_in="chassis_before" if defaults else "chassis_after",
        help="address of the chassis, e.g. 169.254.128.2, or NAME=HOST; `woosh web` takes several",
    )
    group.add_argument("--master", metavar="URI", help="URI of its ROS master")
    group.add_argument("--sim", action="store_true", help="a simulated chassis, started for this command")
    group.add_argument(
        "--sim-speed", type=positive, metavar="X", help="simulated seconds per second, with --sim"
    )
    group.add_argument(
        "--host", type=host, metavar="ADDRESS", help="address of this computer, as the robot reaches it"
    )
    group.add_argument(
        "--msg-path",
        action="append",
        metavar="FOLDER",
        help="a folder of .msg, .srv and .action files: further revisions for robots that have them",
    )
    group.add_argument(
        "--no-learned", action="store_true", help="ignore the definitions that `woosh learn` has saved"
    )
    group.add_argument(
        "--resolve",
        action="append",
        metavar="NAME=IP",
        help="address of a host name of the robot that is not known here (also $ROSPROTO_RESOLVE)",
    )
    group.add_argument(
        "--api-address",
        metavar="ADDRESS",
        help="its Robot API: HOST:PORT, USER:PASSWORD@HOST:PORT or off (default: port 5480 of the chassis)",
    )
    general = parser.add_argument_group("general")
    general.add_argument("--json", action="store_true", help="JSON for programs instead of lines")
    general.add_argument(
        "--lang", choices=LANGUAGES, help="language of the output (default: from $LC_ALL or $LANG)"
    )
    general.add_argument("--debug", action="store_true", help="show the traceback of an error")
    return parser


EXAMPLES: dict[str, tuple[str, ...]] = {
    "sim": (
        "woosh sim --speed 4",
        "woosh sim --port 0 --at 10=estop --at 20=release",
        "woosh sim --robots 12",
    ),
    "connect": ("woosh connect 169.254.128.2", "woosh connect --show"),
    "doctor": ("woosh --chassis 169.254.128.2 doctor",),
    "selftest": ("woosh selftest",),
    "ready": ("woosh ready --wait 120",),
    "faults": ("woosh faults", "woosh faults 110201000013", "woosh faults --find localization --chinese"),
    "scan": ("woosh scan --png scan.png",),
    "camera": ("woosh camera", "woosh camera -o now.png", "woosh camera --depth --png depth.png"),
    "goto": ("woosh goto A1", "woosh goto --pose 1 -1.5 90 --timeout 60", "woosh --sim goto B1"),
    "task": ("woosh task carry P1 --load",),
    "task pause": ("woosh task pause",),
    "charge": ("woosh charge C1",),
    "mission": ("woosh --sim mission run round.mission.toml", "woosh mission check round.mission.toml"),
    "move": ("woosh move 0.5", "woosh move -0.3 --speed 0.1"),
    "rotate": ("woosh rotate 90", "woosh rotate -45"),
    "map save": ("woosh map save hall",),
    "plan": ("woosh plan 3 1 0 --png way.png", "woosh --sim plan A1"),
    "localization pose": ("woosh localization pose 0.2 -0.1 10",),
    "footprint": ("woosh footprint --rectangle 0.8 0.6",),
    "mode": ("woosh mode wait-then-avoid --waiting-timeout 10 --max-speed 0.5",),
    "marks add": ("woosh marks add 仓库 --note 'east door'", "woosh marks add A1 --on-chassis --pose 3 1 90"),
    "api": ("woosh api", "woosh api Battery", """woosh api SceneData '{"name": "hall"}'"""),
    "led": ("woosh led idle", "woosh led red", "woosh led --color ff8000 --strip both"),
    "say": ("woosh say 你好",),
    "record": ("woosh record -O drive.bag --duration 10m",),
    "web": ("woosh --sim web", "woosh web --bind 0.0.0.0 --token Kd83-hsa2-Pq"),
    "run": ("woosh run --sim program.py _speed:=0.2", "woosh run --sim --watch program.py"),
    "shell": ("woosh --sim shell",),
    "completion": ('eval "$(woosh completion bash)"',),
}
"""By command and verb."""
