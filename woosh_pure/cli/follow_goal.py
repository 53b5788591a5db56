"""A goal of a command: wait for its end, show its progress, print its outcome, return the exit code."""

from __future__ import annotations

import functools
import itertools
import math
import sys
import time
from collections import deque
from collections.abc import Callable, Sequence
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
            text = line.text(text, getattr(handle.latest_report, "percent", None))
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


def length_left(path: Sequence[Pose2D], here: Pose2D) -> float | None:
    """Return the distance in m to the nearest path point and on to its end; None without a path.

    If a path passes a place twice, the nearest point may belong to the other pass.
    """
    if len(path) < 2:
        return here.distance_to(path[0]) if path else None
    best = math.inf, 0.0  # (distance from the path, path left behind that point)
    behind = 0.0  # length of the segments that were looked at
    for a, b in reversed(list(itertools.pairwise(path))):
        length = a.distance_to(b)
        # The point of the segment that is nearest to `here` is `along` metres from its begin.
        along = ((here.x - a.x) * (b.x - a.x) + (here.y - a.y) * (b.y - a.y)) / length if length else 0.0
        along = min(max(along, 0.0), length)
        share = along / length if length else 0.0
        away = math.hypot(a.x + share * (b.x - a.x) - here.x, a.y + share * (b.y - a.y) - here.y)
        best = min(best, (away, behind + length - along))
        behind += length
    return sum(best)


class DriveLine:
    """The state of a running drive; create it before the goal is sent, so that no plan is missed.

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
        chassis.feed("plan").open()

    def text(self, progress: str, percent: float | None = None) -> str:
        """Return the line with all known values.

        Args:
            progress: The goal's own progress text, or "".
            percent: The goal's progress, if known.
        """
        seconds = self._clock() - self._began
        here = self._chassis.pose.latest
        left = None if here is None else self._left(here)
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

    def _left(self, here: Pose2D) -> float | None:
        from woosh_pure.readings import known_path

        reading: Any = self._chassis.feed("plan").reading
        fresh = reading is not None and reading.received >= self._began
        if fresh:
            return length_left(known_path(self._chassis), here)
        return None if self._target is None else here.distance_to(self._target)

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
