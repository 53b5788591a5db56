"""The `rosproto` command, and the parts that the `woosh` command shares.

Only `main` prints; it returns the exit code. The other names are argument types with range checks, the
parser, exit codes, and terminal output.
"""

from __future__ import annotations

from collections.abc import Sequence

from rosproto.cli.background_output import never_wait_for_stdout
from rosproto.cli.bag_progress import Progress
from rosproto.cli.bag_record import add_output_options, follow_recording, recorder_options
from rosproto.cli.completion import add_arguments as add_completion_arguments
from rosproto.cli.completion import answer as answer_completion
from rosproto.cli.console import (
    counted,
    enable_escapes,
    is_terminal,
    json_text,
    own,
    shows_unicode,
    terminal_size,
    unguarded,
)
from rosproto.cli.exit_codes import (
    DONE,
    FAILED,
    INTERRUPTED,
    TERMINATED,
    UNREACHABLE,
    WRONG_USE,
    CommandError,
    cannot_listen,
    explain,
    say,
)
from rosproto.cli.gateway import (
    ServerOptions,
    add_gateway_options,
    add_max_clients,
    add_server_options,
    announced,
    gateway_options,
    require_open_files,
    server_options,
    serving,
    serving_line,
    shown_token,
    until_interrupted,
    watchdog_if,
)
from rosproto.cli.keys import Keys, open_keys
from rosproto.cli.options import (
    NotANumber,
    add_token,
    count,
    degrees,
    finite,
    folder_exists,
    heading,
    host,
    metres,
    natural,
    number_from,
    port,
    positive,
    seconds,
    to_float,
    to_int,
    token_of,
    whole_from,
)
from rosproto.cli.output import Output
from rosproto.cli.parser import Parser, WrongUse, give_examples, near
from rosproto.cli.process import Task, exit_codes_line, run_command, words_of
from rosproto.cli.signals import (
    Terminated,
    interrupt_on_signals,
    linger_when_closed,
    signals_ignored,
    signals_unwind,
)

__all__ = [
    "DONE",
    "FAILED",
    "INTERRUPTED",
    "TERMINATED",
    "UNREACHABLE",
    "WRONG_USE",
    "CommandError",
    "Keys",
    "NotANumber",
    "Output",
    "Parser",
    "Progress",
    "ServerOptions",
    "Task",
    "Terminated",
    "WrongUse",
    "add_completion_arguments",
    "add_gateway_options",
    "add_max_clients",
    "add_output_options",
    "add_server_options",
    "add_token",
    "announced",
    "answer_completion",
    "cannot_listen",
    "count",
    "counted",
    "degrees",
    "enable_escapes",
    "exit_codes_line",
    "explain",
    "finite",
    "folder_exists",
    "follow_recording",
    "gateway_options",
    "give_examples",
    "heading",
    "host",
    "interrupt_on_signals",
    "is_terminal",
    "json_text",
    "linger_when_closed",
    "main",
    "metres",
    "natural",
    "near",
    "never_wait_for_stdout",
    "number_from",
    "open_keys",
    "own",
    "port",
    "positive",
    "recorder_options",
    "require_open_files",
    "run_command",
    "say",
    "seconds",
    "server_options",
    "serving",
    "serving_line",
    "shown_token",
    "shows_unicode",
    "signals_ignored",
    "signals_unwind",
    "terminal_size",
    "to_float",
    "to_int",
    "token_of",
    "unguarded",
    "until_interrupted",
    "watchdog_if",
    "whole_from",
    "words_of",
]


def main(argv: Sequence[str] | None = None) -> int:
    """Run `rosproto` with these arguments (default: `sys.argv`) and return the exit code."""
    from rosproto.cli.entry import main as command  # late: other packages import this one without it

    return command(argv)
