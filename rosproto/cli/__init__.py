"""The `rosproto` command, and the parts that another command is built of: `woosh` stands on these names.

`main` owns its process: it alone prints, and its result is the exit code. The other names are options that
refuse what is out of range, the parser, how a command ends, and what a terminal is given.
"""

from __future__ import annotations

from collections.abc import Sequence

from rosproto.cli.background_output import everything_is_written, hurry, in_background
from rosproto.cli.bag_progress import Progress
from rosproto.cli.bag_record import add_output_options, follow_recording, recorder_options
from rosproto.cli.bag_signals import interrupt_on_signals
from rosproto.cli.closed_console import linger_when_closed
from rosproto.cli.completion import add_arguments as add_completion_arguments
from rosproto.cli.completion import answer as answer_completion
from rosproto.cli.console import enable_escapes, is_terminal, shows_unicode, terminal_size
from rosproto.cli.counts import counted
from rosproto.cli.failure import (
    DONE,
    FAILED,
    INTERRUPTED,
    TERMINATED,
    UNREACHABLE,
    WRONG_USE,
    CommandError,
    Terminated,
    cannot_listen,
    explain,
    output_is_gone,
    say,
    signals_unwind,
)
from rosproto.cli.foxglove import (
    add_server_options,
    announced,
    serve,
    server_options,
)
from rosproto.cli.gateway_options import gateway_watchdog, until_interrupted
from rosproto.cli.json_output import json_text
from rosproto.cli.keys import Keys, open_keys
from rosproto.cli.option_types import (
    count,
    finite,
    folder_exists,
    host,
    natural,
    port,
    positive,
    seconds,
    to_float,
    to_int,
    whole,
)
from rosproto.cli.parser import Parser, WrongUse, give_examples, near
from rosproto.cli.streams import as_typed, escape_what_cannot_be_printed, guarded, own, unguarded

__all__ = [
    "DONE",
    "FAILED",
    "INTERRUPTED",
    "TERMINATED",
    "UNREACHABLE",
    "WRONG_USE",
    "CommandError",
    "Keys",
    "Parser",
    "Progress",
    "Terminated",
    "WrongUse",
    "add_completion_arguments",
    "add_output_options",
    "add_server_options",
    "announced",
    "answer_completion",
    "as_typed",
    "cannot_listen",
    "count",
    "counted",
    "enable_escapes",
    "escape_what_cannot_be_printed",
    "everything_is_written",
    "explain",
    "finite",
    "folder_exists",
    "follow_recording",
    "gateway_watchdog",
    "give_examples",
    "guarded",
    "host",
    "hurry",
    "in_background",
    "interrupt_on_signals",
    "is_terminal",
    "json_text",
    "linger_when_closed",
    "main",
    "natural",
    "near",
    "open_keys",
    "output_is_gone",
    "own",
    "port",
    "positive",
    "recorder_options",
    "say",
    "seconds",
    "serve",
    "server_options",
    "shows_unicode",
    "signals_unwind",
    "terminal_size",
    "to_float",
    "to_int",
    "unguarded",
    "until_interrupted",
    "whole",
]


def main(argv: Sequence[str] | None = None) -> int:
    """Run `rosproto` with these arguments (by default the process's own); the exit code."""
    try:
        from .entry import main as command  # late: Ctrl-C while it loads is no traceback either
    except KeyboardInterrupt:
        return 130
    return command(argv)
