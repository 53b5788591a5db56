"""A goal of a command: wait for its end, show its progress, print its outcome, return the exit code."""

from __future__ import annotations

import sys
import time
from typing import TYPE_CHECKING, Any

from rosproto.cli import DONE, FAILED, Progress, is_terminal, never_wait_for_stdout
from rosproto.sentence import say
from woosh_pure.cli.output import Output
from woosh_pure.outcome import Outcome

if TYPE_CHECKING:
    from woosh_pure.motion.motion import GoalHandle


_LIVE, _PLAIN = 0.25, 2.0
"""Seconds between two progress lines: on a terminal, and where lines are kept."""


def follow(handle: GoalHandle[Any], out: Output, describe: str, timeout: float | None) -> Outcome:
    """Wait for a goal and show its progress, on a terminal in one live line.

    Raises GoalFailed for every outcome but an arrival.
    """
    never_wait_for_stdout()
    out.line("{what} ...", what=say(describe))
    live = not out.as_json and is_terminal(sys.stdout)
    every = _LIVE if live else _PLAIN
    # The first line comes soon, also where the others are far apart.
    due = time.monotonic() + min(every, 1.0)

    def show() -> None:
        nonlocal due
        if time.monotonic() < due:
            return
        due = time.monotonic() + every
        text = str(handle.progress)
        if live:
            progress.show(f"  {out.say(text)}")
        else:
            out.line(" ", text)

    with Progress("", stream=sys.stdout, quiet=not live) as progress:
        return handle.wait(timeout, meanwhile=show)


def report(outcome: Outcome, out: Output, **more: object) -> int:
    """Print how a goal ended, and return the exit code."""
    out.line(str(outcome))
    out.result(
        {"ok": outcome.arrived, "outcome": outcome.kind.value, "seconds": round(outcome.seconds, 2), **more}
    )
    return DONE if outcome.arrived else FAILED
