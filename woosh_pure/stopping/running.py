"""What this client has started and still runs: goals and velocity blocks, for `stop`, `close` and the end of
the program.

Every motion is added here before it is sent, so that nothing moves that could not be stopped.
"""

from __future__ import annotations

import atexit
import os
import threading
import time
from collections.abc import Sequence
from functools import partial
from typing import Protocol

from rosproto.errors import ConnectionLost, RosError
from rosproto.logs import get_logger
from woosh_pure.connection.call_scope import current
from woosh_pure.errors import MotionRefused
from woosh_pure.outcome import NOT_CONFIRMED, Outcome, OutcomeKind
from woosh_pure.stopping.keeper import Job, Keeper, begin
from woosh_pure.stopping.report import StopReport

__all__ = ["OwnDrive", "OwnGoal", "Running", "cancel_goals"]

logger = get_logger("woosh_pure.core")
_JUST = 5.0  # seconds
_EXIT_SECONDS = 8.0
_EXIT_CALLS = 32
"""How often `_at_exit` is registered: when an interrupt ends one call, the next one goes on waiting."""


class OwnGoal:
    """A goal of this client as stopping sees it; `woosh_pure.motion.goal.GoalHandle` is one.

    Attributes:
        description: What was asked, in words.
    """

    description: str
    _replaced_by = ""  # in words, the goal of this client that takes its place

    @property
    def task_id(self) -> int:
        """The id of a task; 0 for a goal of another kind."""
        return 0

    @property
    def server(self) -> str:
        """Which of the chassis's action servers has it: a second goal replaces it there; "" for a task."""
        return ""

    @property
    def drives(self) -> bool:
        """True while this goal may move the base."""
        return False

    @property
    def holds_the_base(self) -> bool:
        """Whether another motion would disturb it: it drives, and is not being cancelled by us."""
        raise NotImplementedError

    @property
    def done(self) -> bool:
        """True when it has ended, well or badly."""
        raise NotImplementedError

    def cancel(self, timeout: float = 5.0) -> Outcome:
        """End it now and wait until the chassis confirms; Ctrl-C does not end that halfway."""
        raise NotImplementedError

    def _cancel(self, timeout: float, why: str) -> Outcome:
        """As `cancel`, in this thread."""
        raise NotImplementedError


class OwnDrive(Protocol):
    """A velocity block of this client as stopping sees it."""

    @property
    def finished(self) -> bool:
        """True when it is over and its zeros have been sent."""

    def halt(self, why: str) -> None:
        """End it; zero follows at once."""

    def finish(self) -> None:
        """Wait, with a bound, until the zeros have been sent."""

    def abandon(self) -> None:
        """Both, for a caller who has gone."""


class Running:
    """Goals and drives of one `Chassis`. Safe from any thread.

    Attributes:
        leave: Whether goals go on when the program ends.
        moved: Whether a motion was ever started.
        stops: How often `stop` was called: what was being prepared then must not begin afterwards.
        over: Why nothing begins any more; "" while something may.
        keeper: Where motion is stopped, out of reach of Ctrl-C.
    """

    def __init__(self, *, leave: bool) -> None:
        self.leave = leave
        self.moved = False
        self.stops = 0
        self.over = ""
        self.keeper = Keeper()
        self._exit = Job(self._end_at_exit, _EXIT_SECONDS)
        self._pid = os.getpid()
        self._lock = threading.RLock()
        self._goals: list[OwnGoal] = []
        self._drives: list[OwnDrive] = []
        self._abandoned: list[tuple[float, OwnGoal]] = []

    @property
    def goals(self) -> list[OwnGoal]:
        """Goals under way."""
        with self._lock:
            return list(self._goals)

    @property
    def drives(self) -> list[OwnDrive]:
        """Open velocity blocks."""
        with self._lock:
            return list(self._drives)

    def note_stop(self) -> None:
        """From now on nothing begins that is being prepared now."""
        with self._lock:
            self.stops += 1

    def note_end(self, why: str) -> None:
        """From now on nothing begins.

        Args:
            why: In words, for the error that later attempts get.
        """
        with self._lock:
            self.stops += 1
            self.over = self.over or why

    def require_not_over(self) -> None:
        """Refuse to prepare a motion that could not begin.

        Raises:
            ConnectionLost: The Chassis is being closed, or its node is shut down.
        """
        if self.over:
            raise ConnectionLost(
                f"{self.over}: nothing begins any more, and nothing was sent; open a new one"
            )

    def end_all(self, why: str, seconds: float = 3.0) -> list[str]:
        """End drives and goals (`leave` leaves goals), and wait until that is confirmed.

        Args:
            why: In words, for outcomes and errors.
            seconds: For the goals to be cancelled; all at once.

        Returns:
            What could not be done, in words.
        """
        drives, report = self.drives, StopReport()
        for drive in drives:
            drive.halt(why)
        for drive in drives:
            drive.finish()
        if not self.leave:
            cancel_goals(self.take_goals(), report, seconds, why)
        return report.problems

    def end_with_node(self, reason: str) -> None:
        """The node is about to close, and still works: `Node.before_close`."""
        why = f"the node was shut down ({reason})" if reason else "the node was closed"
        self.note_end(why)
        for problem in self.end_all(why):
            logger.warning("! %s; the robot may still be driving: %s", why, problem)

    def require_free_base(self, what: str) -> None:
        """Refuse a goal while a velocity block of this Chassis is open: both would command the base.

        Raises:
            MotionRefused: One is.
        """
        if any(not drive.finished for drive in self.drives):
            raise MotionRefused(f"{what} refused, nothing was sent: a velocity block is open; leave it first")

    def require_alone(self, goal: OwnGoal) -> None:
        """Refuse to go on with a goal while something else of this Chassis moves the base.

        Raises:
            MotionRefused: Something does.
        """
        self.require_free_base(goal.description)
        self._make_way(goal, self._others(goal), check=True, replace=False)

    def add_goal(self, goal: OwnGoal, since: int, *, check: bool = True, replace: bool = False) -> None:
        """Add a goal that is about to be sent.

        Args:
            goal: The goal.
            since: `stops` when its verb began.
            check: False adds it beside a velocity block or another motion, too.
            replace: True ends another goal that moves the base, as replaced.

        Raises:
            MotionRefused: `stop` was called since then, a velocity block is open, or another goal moves.
            ConnectionLost: The Chassis is being closed.
        """
        self.keeper.start()
        if goal.drives:
            self._make_way(goal, self._others(goal), check=check, replace=replace)
        ended = [other for other in self.goals if other.done]  # which may look at the network
        with self._lock:
            self._require_no_stop(goal.description, since)
            if check and goal.drives:
                self.require_free_base(goal.description)
                late = [o for o in self._goals if o.holds_the_base and o not in ended and not o._replaced_by]
                self._make_way(goal, late, check=True, replace=False)
            if (scope := current()) is not None:
                scope.add(goal, goal.description, lambda: goal.cancel(5.0))
            self._will_move()
            self._goals.append(goal)

    def _others(self, goal: OwnGoal) -> list[OwnGoal]:
        return [o for o in self.goals if o is not goal and not o.done and o.holds_the_base]

    def _make_way(self, goal: OwnGoal, others: list[OwnGoal], *, check: bool, replace: bool) -> None:
        """Refuse a goal beside others of ours, or end those: two of them would fight for the base."""
        if others and check and not replace:
            names = ", ".join(each.description for each in others)
            raise MotionRefused(
                f"{goal.description} refused, nothing was sent: {names} is under way "
                "and would be lost; wait for it or cancel it, or replace it with replace=True"
            )
        for other in others:
            other._replaced_by = goal.description
            # One server passes smoothly from a goal to the next; between two servers nothing is documented.
            if replace and not (other.server and other.server == goal.server):
                self._end_replaced(other)

    def _end_replaced(self, other: OwnGoal) -> None:
        try:
            self.keeper.do(lambda: other._cancel(3.0, "replaced"), 10.0)
        except RosError as error:
            other._replaced_by = ""
            raise MotionRefused(
                f"{other.description} could not be ended, so that nothing else was sent: {error}"
            ) from error

    def forget_replacing(self, goal: OwnGoal) -> None:
        """A goal was not sent after all: those it should have replaced go on."""
        for other in self.goals:
            if other._replaced_by == goal.description:
                other._replaced_by = ""

    def note_abandoned(self, goal: OwnGoal) -> None:
        """A goal is cancelled whose caller no longer waits; the next `stop` reports how it ended."""
        with self._lock:
            self._abandoned = [*self._just_abandoned(), (time.monotonic(), goal)]

    def take_goals(self) -> list[OwnGoal]:
        """Goals to cancel: those under way, and those just abandoned, which may have ended already."""
        with self._lock:
            abandoned, self._abandoned = self._just_abandoned(), []
            return [*self._goals, *(goal for _, goal in abandoned if goal not in self._goals)]

    @property
    def just_let_go(self) -> bool:
        """Whether a goal was cancelled just now because its wait was interrupted."""
        with self._lock:
            return bool(self._just_abandoned())

    def _just_abandoned(self) -> list[tuple[float, OwnGoal]]:
        return [each for each in self._abandoned if time.monotonic() - each[0] < _JUST]

    def remove_goal(self, goal: OwnGoal) -> None:
        """Take off an ended goal."""
        with self._lock:
            if goal in self._goals:
                self._goals.remove(goal)

    def add_drive(self, drive: OwnDrive, since: int, *, check: bool = True) -> None:
        """Add a drive that is about to be opened; there is one at a time.

        Args:
            drive: The drive.
            since: `stops` when its opening began.
            check: False opens it beside a goal of ours, too.

        Raises:
            MotionRefused: Another one is open, a goal of ours moves the base, or `stop` was called meanwhile.
            ConnectionLost: The Chassis is being closed.
        """
        self.keeper.start()
        under_way = [goal for goal in self.goals if not goal.done]  # `done` may look at the network
        with self._lock:
            self._require_no_stop("velocity", since)
            driving = [goal.description for goal in self._goals if goal in under_way and goal.drives]
            if check and driving:
                raise MotionRefused(
                    f"velocity refused: {', '.join(driving)} is under way and would be disturbed; wait for "
                    "it, pause or cancel it first"
                )
            if any(not other.finished for other in self._drives):
                raise MotionRefused("another velocity block is open on this Chassis; leave it first")
            if (scope := current()) is not None:
                scope.add(drive, "velocity", drive.abandon)
            self._will_move()
            self._drives = [drive]

    def remove_drive(self, drive: OwnDrive) -> None:
        """Take off an ended drive."""
        with self._lock:
            if drive in self._drives:
                self._drives.remove(drive)

    def close(self) -> None:
        """Forget everything; it must have ended before."""
        atexit.unregister(self._at_exit)
        self.keeper.end()
        with self._lock:
            self._goals.clear()

    def _require_no_stop(self, what: str, since: int) -> None:
        self.require_not_over()
        if self.stops != since:
            raise MotionRefused(f"{what}: stop() was called while it was being prepared; nothing was sent")

    def _will_move(self) -> None:
        if not self.moved:
            for _ in range(_EXIT_CALLS):
                atexit.register(self._at_exit)
        self.moved = True

    def _at_exit(self) -> None:
        """For a program that did not use `with`, or was interrupted again and again while leaving it.

        Registered after the node's own end, so called before it: the node still works.
        """
        if os.getpid() == self._pid:  # in a forked child the motions are the parent's
            self.keeper.put(self._exit)
            self._exit.join()

    def _end_at_exit(self) -> None:
        self.note_end("the program ended")
        for problem in self.end_all("the program ended"):
            logger.warning("! not done when the program ended, the robot may still be driving: %s", problem)


def cancel_goals(goals: Sequence[OwnGoal], report: StopReport, timeout: float, why: str) -> None:
    """Ask for the end of goals that this client started; all at once, not one after the other.

    Args:
        goals: What was started.
        report: Takes what was done, and what was not.
        timeout: Seconds for the chassis to confirm.
        why: In words, for the outcomes.
    """
    jobs = []
    for goal in goals:
        job = Job(partial(_cancel, goal, report, timeout, why), timeout + 1.0)
        begin(job, "woosh:cancel")
        jobs.append((job, goal))
    for job, goal in jobs:
        job.join()
        if not job.over:
            report.problems.append(f"cancelling {goal.description} (no answer yet)")


def _cancel(goal: OwnGoal, report: StopReport, timeout: float, why: str) -> None:
    try:
        outcome = goal._cancel(timeout, why)
        if outcome.kind is OutcomeKind.CANCELLED and outcome.text == NOT_CONFIRMED and not outcome.stopped:
            report.problems.append(f"cancelling {goal.description} ({NOT_CONFIRMED})")
        else:
            report.cancelled.append(f"{goal.description} ({outcome.kind.value})")
    except RosError as error:
        report.problems.append(f"cancelling {goal.description} ({error})")
