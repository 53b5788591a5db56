"""Runs a command in its process, from the arguments to the exit code; `rosproto` and `woosh` use it."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext, suppress
from typing import NamedTuple

from rosproto.cli.background_output import everything_is_written, in_background, never_wait_for_stdout
from rosproto.cli.console import TerminalGone, as_typed, escape_what_cannot_be_printed, guarded
from rosproto.cli.exit_codes import DONE, INTERRUPTED, TERMINATED, WRONG_USE, explain, output_is_gone
from rosproto.cli.signals import Terminated, linger_when_closed, signals_unwind
from rosproto.sentence import both, say


class Task(NamedTuple):
    """A parsed command line.

    Attributes:
        run: Runs the command and returns the exit code.
        failed: Reports an error, given the sentence and the exit code.
        debug: Whether errors are raised instead of reported.
    """

    run: Callable[[], int]
    failed: Callable[[str, int], None]
    debug: bool


def words_of(argv: Sequence[str] | None) -> list[str]:
    """Return the words of a command line (default: `sys.argv`), and make all text printable."""
    escape_what_cannot_be_printed()
    return as_typed(sys.argv[1:] if argv is None else argv)


def run_command(
    words: Sequence[str],
    parser_for: Callable[[Sequence[str]], argparse.ArgumentParser],
    task_of: Callable[[argparse.Namespace], Task],
    *,
    until_exit: bool,
) -> int:
    """Parse and run a command line.

    Args:
        words: The command line.
        parser_for: Returns its parser, whose `command` is the name of the sub-command.
        task_of: Returns the task for the parsed arguments.
        until_exit: Whether the process ends with the command.

    Returns:
        The exit code.
    """
    with in_background() if until_exit else nullcontext(), guarded():
        parser = parser_for(words)
        try:
            arguments = parser.parse_args(words)
        except BrokenPipeError:  # of --help: older versions of argparse raise it
            output_is_gone()
            return DONE
        if arguments.command is None:
            with suppress(BrokenPipeError):
                parser.print_help(sys.stderr)
            return WRONG_USE
        with signals_unwind(until_exit=until_exit), linger_when_closed():
            return _ended(task_of(arguments))


def _ended(task: Task) -> int:
    try:
        return _outcome(task)
    except KeyboardInterrupt:
        text, code = "interrupted", INTERRUPTED
    except (Terminated, TerminalGone):
        text, code = "terminated", TERMINATED
    never_wait_for_stdout()
    with suppress(KeyboardInterrupt, Terminated):  # once more, while this is written
        task.failed(text, code)
    return code


def _outcome(task: Task) -> int:
    """Run the task; an error of its own becomes a sentence and an exit code."""
    try:
        code = task.run()
        everything_is_written()  # a full disk or a closed pipe shows here, not at exit
    except TerminalGone:
        raise
    except BrokenPipeError:
        output_is_gone()
        return DONE
    except Exception as error:
        if task.debug:
            raise
        text, code = explain(error)
        task.failed(text, code)
    return code


def exit_codes_line(meanings: Mapping[int, str]) -> str:
    """Return the meanings of the exit codes, each up to its first semicolon, for the end of a help."""
    codes = (
        say("{code} {meaning}", code=code, meaning=say(text.partition(";")[0]))
        for code, text in meanings.items()
    )
    return say("Exit codes: {codes}.", codes=both(*codes))
