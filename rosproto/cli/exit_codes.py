"""Exit codes of `rosproto`, and the sentence and exit code for an exception.

`woosh` uses the same codes and adds two: `woosh_pure/cli/output.py`.
"""

from __future__ import annotations

import os
import sys

from rosproto import sentence, startup
from rosproto.cli.console import OutputError
from rosproto.errors import ConnectionLost, RosError
from rosproto.sentence import led, sentence_of
from rosproto.text import printable

DONE, FAILED, WRONG_USE, UNREACHABLE = 0, 1, 2, 4
INTERRUPTED, TERMINATED = startup.INTERRUPTED, 143
EXIT_CODES = {
    DONE: "done",
    FAILED: "it failed, or the answer is no; one sentence on stderr says why and what to do",
    WRONG_USE: "wrong use; an argument is missing, unknown or out of range",
    UNREACHABLE: "the master or a node cannot be reached, or the connection was lost",
    INTERRUPTED: "interrupted by Ctrl-C before it was done",
    TERMINATED: "ended by SIGTERM, a hang-up or a closed console",
}
"""What the exit codes of `rosproto` mean."""


class CommandError(RosError):
    """A command failed; the text is the only sentence for the user."""


def explain(error: Exception) -> tuple[str, int]:
    """Return one sentence and the exit code.

    For a lost connection the sentence has the address and the reason, but not the node's name and the method.
    """
    text = _one_line(sentence_of(error))
    if isinstance(error, ConnectionLost):
        return (_one_line(led(error.peer, error.why)) if error.peer and error.why else text), UNREACHABLE
    if isinstance(error, RosError):
        return text, error.exit_code
    if isinstance(error, ValueError):
        return text, WRONG_USE
    if isinstance(error, OutputError):
        output_is_gone()
        return led(sentence.say("cannot write the output"), error.strerror or text), FAILED
    if isinstance(error, OSError) and error.strerror:
        return led(error.filename, error.strerror) if error.filename else error.strerror, FAILED
    missing_extra = isinstance(error, ImportError) and isinstance(error.__cause__, ImportError)
    if missing_extra or isinstance(error, (OSError, KeyError)):  # see `optional_module`
        return text, FAILED
    ours = "{error}: {text}; this is a bug; please report it with the output of --debug"
    return sentence.say(ours, error=type(error).__name__, text=text), FAILED


def _one_line(text: str) -> str:
    plain = " ".join(text.split())
    return text if text == plain else plain  # equal, but a Sentence


def cannot_listen(error: ConnectionLost, option: str, port: str = "--port") -> str:
    """Return the error of a listening socket, with the option of the address or port to change."""
    from rosproto.transport.os_errors import address_is_not_ours, port_is_taken

    if port_is_taken(error.__cause__):
        return sentence.say(
            "listen on {address}: the port is taken (or not allowed); "
            "end what runs there, or choose another {port} (0: a free one)",
            address=error.peer,
            port=port,
        )
    if address_is_not_ours(error.__cause__):
        return sentence.say(
            "listen on {address}: this computer has no such address; "
            "give one of its own with {option}, 0.0.0.0 for all of them",
            address=error.peer,
            option=option,
        )
    return str(error)


def say(text: str) -> None:
    """Print a line on stderr, if it is open."""
    try:
        print(printable(text), file=sys.stderr, flush=True)
    except (OSError, ValueError):
        pass  # the terminal has gone: only the exit code remains


def output_is_gone() -> None:
    """Suppress the error of buffered output at exit, after a reader (head, less) closed stdout."""
    if sys.stdout is not None:
        try:
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        except (OSError, ValueError):
            pass  # no descriptor: no flush
