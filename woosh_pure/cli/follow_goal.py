"""A goal of a command: wait for its end, show its progress, print its outcome, return the exit code."""

from __future__ import annotations

import sys
import time
from typing import TYPE_CHECKING, Any

from rosproto.cli import DONE, FAILED, Progress, hurry, is_terminal
from rosproto.sentence import say
from woosh_pure.cli.output import Output
from woosh_pure.outcome import Outcome

if TYPE_CHECKING:
    from woosh_pure.cli.drive_line import DriveLine
    from woosh_pure.motion.goal_handle import GoalHandle


_LIVE, _PLAIN = 0.25, 2.0
"""Seconds between two progress lines: on a terminal, and where lines are kept."""


def follow(
    handle: GoalHandle[Any],
    out: Output,
    describe: str,
    timeout: float | None,
    line: DriveLine | None = None,
) -> Outcome:
    """Wait for a goal and show its progress, on a terminal in one live line.

    Raises GoalFailed for every outcome but an arrival. `line` shows the way left; without it the goal's own
    progress is shown.
    """
    hurry()
    out.line(say("{what} ...", what=say(describe)))
    live = not out.as_json and is_terminal(sys.stdout)
    every = _LIVE if live else _PLAIN
    due, said = time.monotonic() + min(every, 1.0), ""

    def show() -> None:
        nonlocal due, said
        if time.monotonic() < due:
            return
        due = time.monotonic() + every
        text = handle.progress_line()
        if line is not None:
            text = line.text(text, getattr(handle.latest_progress, "percent", None))
        if live:
            progress.show(f"  {out.say(text)}")
        elif text and text != said:
            said = text
            out.line(" ", text)

    with Progress("", stream=sys.stdout, quiet=not live) as progress:
        return handle.wait(timeout, meanwhile=show)


def report(outcome: Outcome, out: Output, **more: Any) -> int:
    """Print how a goal ended, and return the exit code."""
    out.line(outcome.sentence())
    out.result(
        {"ok": outcome.arrived, "outcome": outcome.kind.value, "seconds": round(outcome.seconds, 2), **more}
    )
    return DONE if outcome.arrived else FAILED
