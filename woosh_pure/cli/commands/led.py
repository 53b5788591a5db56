"""`woosh led STATE` and `woosh led --color RRGGBB`."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from rosproto.cli import hint, whole
from rosproto.sentence import both, say
from woosh_pure.cli.arguments import enum_words, word_of
from woosh_pure.cli.connection import connect
from woosh_pure.cli.output import Output
from woosh_pure.enums import LedState

COLOURS = {
    "red": 0xFF0000, "orange": 0xFF8000, "yellow": 0xFFFF00, "green": 0x00FF00,
    "cyan": 0x00FFFF, "blue": 0x0000FF, "purple": 0x8000FF, "white": 0xFFFFFF,
}  # fmt: skip
HELP = "set the light strips: a named state, or a colour"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    parser.add_argument(
        "state", nargs="?", help="a state of the strip, see --list; none: nothing of its own; or a colour"
    )
    parser.add_argument(
        "--color", metavar="COLOUR", help=f"three hexadecimal bytes, ff8000, or {', '.join(COLOURS)}"
    )
    parser.add_argument(
        "--strip", choices=("base", "shelf", "both"), default="base", help="which strip (base)"
    )
    parser.add_argument("--module", type=whole, default=0, metavar="N", help="0 all, 1 to 8 one module")
    parser.add_argument("--urgency", action="store_true", help='show "under maintenance"')
    parser.add_argument("--abnormal", action="store_true", help='show "fault"')
    parser.add_argument("--list", action="store_true", help="list the states; asks no chassis")


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""

    words = enum_words(LedState)
    if args.list:
        for word in words:
            out.line(word)
        out.result({word: int(LedState[word_of(word)]) for word in words})
        return 0
    if args.state is not None and args.color is None and args.state.lower() in COLOURS:
        args.state, args.color = None, args.state
    if args.state is None:
        if not (args.color or args.urgency or args.abnormal):
            raise ValueError(
                "give a state (see --list) or --color COLOUR; what the strip shows now is not told"
            )
        args.state = "none"
    if args.state not in words:
        unknown = say("state {state!r} is not known", state=args.state)
        near = hint(args.state, [*words, *COLOURS])
        raise ValueError(both(unknown, *near, say("one of: {names}", names=[*words, *COLOURS])))
    color = _color(args.color)
    with connect(args, out) as chassis, out.working("looking for the light strip"):
        chassis.light(
            LedState[word_of(args.state)],
            color=color,
            strip=args.strip,
            module=args.module,
            urgency=args.urgency,
            abnormal=args.abnormal,
        )
    shown = "{strip} strip: {state}" if color is None else "{strip} strip: {state}, colour {color:06x}"
    out.line(say(shown, strip=args.strip, state=args.state, color=color))
    out.result({"strip": args.strip, "state": args.state, "color": color, "module": args.module})
    return 0


def _color(text: str | None) -> int | None:
    if text is None:
        return None
    if text.lower() in COLOURS:
        return COLOURS[text.lower()]
    digits = text.lstrip("#")
    if len(digits) != 6 or not all(c in "0123456789abcdefABCDEF" for c in digits):
        raise ValueError(
            say(
                "--color {text}: expected six hexadecimal digits RRGGBB, or {names}",
                text=text,
                names=", ".join(COLOURS),
            )
        )
    return int(digits, 16)
