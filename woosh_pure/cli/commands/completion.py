"""`woosh completion SHELL`."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from rosproto.cli import add_completion_arguments, answer_completion
from woosh_pure.cli import config
from woosh_pure.cli.output import Output
from woosh_pure.enums import LedState
from woosh_pure.maps.marks import MarkFile

HELP = "print what a shell needs to complete this command (bash, zsh, fish, powershell)"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    add_completion_arguments(parser)


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    from woosh_pure.cli.entry import parser_for

    return answer_completion("woosh", args, parser_for, {"mark": _marks, "state": _states, "color": _colours})


def _states() -> list[str]:
    from woosh_pure.cli.arguments import enum_words

    return enum_words(LedState)


def _colours() -> list[str]:
    from woosh_pure.cli.commands.led import COLOURS

    return list(COLOURS)


def _marks() -> list[str]:
    """Return the marks of the user's list; the chassis cannot list its own."""

    return MarkFile(config.mark_file()).names
