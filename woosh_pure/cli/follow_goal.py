"""A goal of a command: wait for its end, show its progress, print its outcome, return the exit code."""

from __future__ import annotations

import functools
import sys
import time
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rosproto.cli import DONE, FAILED, Progress, is_terminal, never_wait_for_stdout
from rosproto.sentence import Sentence, say
from woosh_pure.cli.output import Output
from woosh_pure.geometry import Pose2D
from woosh_pure.outcome import Outcome

if TYPE_CHECKING:
    from woosh_pure.chassis import Chassis
    from woosh_pure.motion.motion import GoalHandle


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
    never_wait_for_stdout()
    out.line("{what} ...", what=say(describe))
    live = not out.as_json and is_terminal(sys.stdout)
    every = _LIVE if live else _PLAIN
    # The first line comes soon, also where the others are far apart.
    due, shown = time.monotonic() + min(every, 1.0), ""

    def show() -> None:
        nonlocal due, shown
        if time.monotonic() < due:
            return
        due = time.monotonic() + every
        text = handle.progress_line()
        if line is not None:
            percent = getattr(handle.latest_report, "percent", None)  # of steps
            text = line.text(text, percent, handle.progress.metres_left)
        if live:
            progress.show(f"  {out.say(text)}")
        elif text and text != shown:
            shown = text
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


_WINDOW = 4.0
"""Seconds over which the speed of getting there is taken."""


class DriveLine:
    """The state of a running drive.

    Args:
        chassis: The driving chassis.
        target: The target, if known.
        clock: A monotonic clock, s.
    """

    def __init__(
        self, chassis: Chassis, target: Pose2D | None = None, *, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._chassis = chassis
        self._target = target
        self._clock = clock
        self._began = clock()
        self._lefts: deque[tuple[float, float]] = deque(maxlen=200)
        chassis.pose.open()

    def text(self, progress: str, percent: float | None = None, metres_left: float | None = None) -> str:
        """Return the line with all known values.

        Args:
            progress: The goal's own progress text, or "".
            percent: Of steps, if it is one.
            metres_left: The rest of the way, m; without it the distance to the target is shown.
        """
        seconds = self._clock() - self._began
        here = self._chassis.pose.latest
        left = metres_left
        if left is None and here is not None and self._target is not None:
            left = here.distance_to(self._target)
        parts = [say("{seconds:.0f} s", seconds=seconds)]
        if percent is not None:
            # The rest takes as long as the part that is done, once that part is large enough to tell.
            seconds_left = seconds * (100.0 - percent) / percent if percent > 2.0 else None
            parts.append(_about(say(progress), seconds_left))
        elif left is not None:
            parts.append(_about(say("{metres:.1f} m left", metres=left), self._seconds_left(left)))
        if here is not None:
            where = say("x {x:.2f} m, y {y:.2f} m, {yaw:.0f}°", x=here.x, y=here.y, yaw=here.yaw_degrees)
            parts.append(say("at {where}", where=where))
        if percent is None and left is None and progress:
            parts.append(say(progress))
        return functools.reduce(lambda a, b: say("{first}   {second}", first=a, second=b), parts)

    def _seconds_left(self, left: float) -> float | None:
        """Estimate from the progress of the last seconds; None without progress."""
        now = self._clock()
        self._lefts.append((now, left))
        while now - self._lefts[0][0] > _WINDOW:
            self._lefts.popleft()
        since, before = self._lefts[0]
        gained = before - left
        if now - since < 0.8 or gained <= 0.05:
            return None
        return left * (now - since) / gained


def _about(text: Sentence, seconds: float | None) -> Sentence:
    return text if seconds is None else say("{text}, about {seconds:.0f} s", text=text, seconds=seconds)
