"""Exit codes of `woosh`: those of `rosproto`, and two more for a refusal and for an unknown answer.

An exception has its own code: `exit_code` in `rosproto/errors.py` and `woosh_pure/errors.py`. A command
without an exception returns a code from here.
"""

from __future__ import annotations

from rosproto.cli import DONE, FAILED, INTERRUPTED, TERMINATED, UNREACHABLE, WRONG_USE

REFUSED, NOT_KNOWN = 3, 5
EXIT_CODES = {
    DONE: "done",
    FAILED: "it failed, or the answer is no; one sentence on stderr says why and what to do",
    WRONG_USE: "wrong use: an argument is missing, unknown or out of range; nothing was sent",
    REFUSED: "the chassis is not ready, or refused to move",
    UNREACHABLE: "the chassis cannot be reached, or the connection was lost",
    NOT_KNOWN: "the answer is not known: the chassis has not told it (`ready`, `faults`)",
    INTERRUPTED: "interrupted by Ctrl-C; a motion of this command was stopped",
    TERMINATED: "ended by SIGTERM, a hang-up or a closed console; a motion of this command was stopped",
}
"""What the exit codes mean."""
READY = {"yes": DONE, "no": REFUSED, "not known": NOT_KNOWN}
"""Exit codes of `woosh ready`, by its answer."""
