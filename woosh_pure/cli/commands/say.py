"""`woosh say TEXT`."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from rosproto import sentence
from woosh_pure.cli.connection import connect
from woosh_pure.cli.output import Output

HELP = "let the chassis speak (where it has a voice)"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    parser.add_argument("text", nargs="+", help="what to say")


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    text = " ".join(args.text)
    if not text.strip():
        raise ValueError("the text is empty; give the words to say")
    with connect(args, out) as chassis, out.working("speaking"):
        chassis.say(text)
    out.line(sentence.say("said: {text}", text=text))
    out.result({"said": text})
    return 0
