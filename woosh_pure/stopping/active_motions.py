"""The goals and velocity blocks of one `Chassis` that are under way, and how all of them are ended.

Every motion is added here before it is sent, so `stop` can always find it. A stop reads a tuple without a
lock: the tuple is replaced, never changed. `add_goal` writes the tuple first and reads `stops` afterwards; a
stop increments `stops` first and reads the tuple afterwards. So at least one of them sees the other.

`stops` is compared with its value at the time when the motion was asked for (`since`), which is before its
thread began, before the chassis was connected, and before anything was waited for: what was asked for before
a stop does not begin after it.
"""

from __future__ import annotations

import atexit
import itertools
import logging
import os
import threading
import time
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from rosproto.codec import decoder
from rosproto.errors import ConnectionLost, RosError
from rosproto.logs import get_logger
from rosproto.sentence import advice, say
from woosh_pure.connection.call_scope import CallScope, current
from woosh_pure.connection.velocity_topics import VelocityTopics
from woosh_pure.errors import MotionRefused
from woosh_pure.interface.table import row
from woosh_pure.outcome import ENDED_EARLY, NOT_CONFIRMED, Outcome, OutcomeKind
from woosh_pure.stopping.immediate_stop import ImmediateStop, Stoppable, StopRequest
from woosh_pure.stopping.report import StopReport
from woosh_pure.stopping.stop_executor import Job, StopExecutor, begin
from woosh_pure.values.messages import message_type, service_type

if TYPE_CHECKING:
    from woosh_pure.motion.motion import Motion
    from woosh_pure.velocity.drive import Drive

    OwnMotion = Motion[Any]  # whatever its progress is

logger = get_logger("woosh_pure.components")
_JUST_CANCELLED_SECONDS = 5.0
_WRITTEN = 0.5  # seconds for the first round, before the slow steps
_EXIT_SECONDS, _CHORE_SECONDS, _CANCEL_SECONDS = 8.0, 3.0, 10.0
_EXIT_CALLS = 32
"""How often `_at_exit` is registered: when an interrupt ends one call, the next one goes on waiting."""


class ActiveMotions:
    """Goals and drives of one `Chassis`. Safe from any thread.

    Attributes:
        leave: Whether goals continue when the program ends.
        moved: Whether a motion was ever started.
        over: Why no motion can begin any more; "" while one can. `close` sets it first, without a call.
        stop_mark: `stop` sets it first, without a call: see `immediate_stop`. True while this stop is not
            carried out, and its arguments.
        marked_report: The report for that caller. It is filled in later.
        carry_out: Called with the arguments of such a stop, in a thread; returns the report.
        executor: The threads that stop motions; Ctrl-C does not reach them.

    Args:
        leave: See the attribute.
        velocity: Zeros of ended drives that have not arrived yet are sent there.
    """

    def __init__(self, velocity: VelocityTopics, *, leave: bool) -> None:
        self.leave = leave
        self.moved = False
        self.over = ""
        self.stop_mark: list[Any] = [False]
        self.marked_report = _report_ahead()
        self.carry_out: Callable[..., StopReport] = lambda *arguments: StopReport()
        self.executor = StopExecutor()
        self._stops = 0
        self._end_noted = False
        self._immediate_stop = ImmediateStop(self._under_way, self._chores, self._take_marks)
        self._velocity = velocity
        self._sending_zeros: Job[None] | None = None
        self._count = itertools.count(1)
        self._exit = Job(self._end_at_exit, _EXIT_SECONDS)
        self._pid = os.getpid()
        self._lock = threading.RLock()
        self._goals: tuple[OwnMotion, ...] = ()
        self._ended_early: list[OwnMotion] = []
        self._drives: tuple[Drive, ...] = ()

    @property
    def goals(self) -> list[OwnMotion]:
        """The goals under way."""
        return [goal for goal in self._goals if not goal.gone]

    def own_tasks(self) -> set[int]:
        """Ids of the tasks under way."""
        return {goal.task_id for goal in self.goals if goal.task_id}

    @property
    def drives(self) -> list[Drive]:
        """The velocity blocks that are open or have not sent their last zeros yet."""
        return list(self._drives)

    def request(self) -> CallScope:
        """Return the scope of a call that is asked for now, to be carried out in any thread later: within
        it, a motion is refused if `stop` was called meanwhile. Does not wait.
        """
        scope = current()
        own_stops = scope.own_stops if scope is not None and scope.motions is self else None
        return CallScope(self, self.since, own_stops)

    @property
    def since(self) -> int:
        """`stops` when what this thread carries out was asked for: now, except in the scope of a `request`.

        Verbs read it first of all.
        """
        stops, scope = self.stops, current()
        if scope is not None and scope.motions is self and scope.overtaken_at(stops):
            return scope.stops
        return stops

    def _under_way(self, goals: bool) -> Iterable[Stoppable]:
        return (*self._drives, *self.goals) if goals else self._drives

    def _chores(self) -> bool:
        """Start sending zeros if some are due; return whether they are. Does not wait."""
        if not self._velocity.zeros_due:
            return False
        if self._sending_zeros is None or self._sending_zeros.over:
            self._sending_zeros = Job(self._velocity.send_due_zeros, _CHORE_SECONDS)
            self.executor.put(self._sending_zeros)
        return True

    @property
    def stops(self) -> int:
        """Number of stops. A motion that was asked for before one and has not begun must not begin."""
        if self.stop_mark[0]:
            self._take_marks()
        return self._stops

    def _take_marks(self) -> None:
        """Carry out the stop or the end that a caller without stack has marked. Does not wait."""
        mark = self.stop_mark
        if mark[0]:
            self._note_stop("stop() was called", None)  # whoever looks here is not who stops
            if self.moved:  # else there are no threads, and nothing of ours moves
                report, self.marked_report = self.marked_report, _report_ahead()
                self.executor.put(Job(partial(self._fill_in, report, *mark[1:]), _EXIT_SECONDS))
        if self.over and not self._end_noted:
            self.note_end(self.over)

    def _fill_in(self, report: StopReport, *arguments: Any) -> None:
        done = self.carry_out(*arguments)
        report.standing, report.looked = done.standing, done.looked
        report.cancelled, report.problems, report.pending = done.cancelled, done.problems, done.pending

    def note_stop(self, why: str = "stop() was called") -> StopRequest:
        """Prevent motions that are being prepared from beginning, and ask those under way to end.

        Returns immediately and works over any interrupted frame; see `immediate_stop`.

        Args:
            why: The reason, for outcomes and errors.
        """
        return self._note_stop(why, current())

    def _note_stop(self, why: str, scope: CallScope | None) -> StopRequest:
        mark = self.stop_mark  # read before the request: a mark that is made later stays
        number = next(self._count)
        if scope is not None and scope.motions is self:
            scope.own_stops.add(number)  # before others see the number
        self._stops = number
        request = self._immediate_stop.ask(StopRequest(why))
        mark[0] = False
        return request

    def note_end(self, why: str) -> StopRequest:
        """Let no motion begin any more, and ask those under way to end (goals continue with `leave`).

        Args:
            why: The reason, for the outcomes and for the error of later attempts.
        """
        self.over = self.over or why
        self._stops = next(self._count)
        self._ended_early = self._ended_early or self.goals  # when `end_all` looks they may have ended
        request = self._immediate_stop.ask(StopRequest(why, goals=not self.leave))
        self._end_noted = True
        return request

    def require_not_over(self) -> None:
        """Check that motions can still begin.

        Raises:
            ConnectionLost: The Chassis is being closed, or its node is shut down.
        """
        if self.over:
            wrong = "{why}: nothing begins any more, and nothing was sent; open a new one"
            raise ConnectionLost(say(wrong, why=say(self.over)))

    def end_all(self, why: str, seconds: float = 3.0) -> list[str]:
        """End drives and goals (goals continue with `leave`), and wait for the confirmation.

        Args:
            why: The reason, for outcomes and errors.
            seconds: Time limit for cancelling all goals; they are cancelled at the same time.

        Returns:
            A sentence for each thing that failed.
        """
        drives, report = self.drives, StopReport()
        self._immediate_stop.ask(StopRequest(why, goals=not self.leave)).written.wait(_WRITTEN)
        for drive in drives:
            drive.halt(why)
        for drive in drives:
            drive.finish()
        if not self.leave:
            goals = self.take_goals()
            cancel_goals(goals, report, seconds, why)
            early, self._ended_early = self._ended_early, []
            for goal in dict.fromkeys([*early, *goals]):
                logging.getLogger(ENDED_EARLY).info("%s: cancelled, because %s", goal, why)
        return report.problems

    def end_with_node(self, reason: str, elsewhere: Job[list[str]] | None = None) -> None:
        """End all motions while the node, which is about to close, still works (`Node.before_close`).

        Args:
            reason: Why the node closes; "" if this program closes it.
            elsewhere: Says the same from another node meanwhile: a cancel of ours may seem sent and be lost
                with its link, which is known only when no reply has come.
        """
        why = say("the node was shut down ({reason})", reason=reason) if reason else "the node was closed"
        self.note_end(why)
        if elsewhere is not None:
            begin(elsewhere, "woosh:stop")
        for problem in self.end_all(why):
            logger.warning("! %s; the robot may still be driving: %s", why, problem)

    def require_free_base(self, what: str) -> None:
        """Check that no velocity block of this Chassis is open: it and a goal would both command the base.

        Raises:
            MotionRefused: A velocity block is open.
        """
        if any(not drive.finished for drive in self.drives):
            raise MotionRefused(
                advice(
                    "{what} refused, nothing was sent: a velocity block is open; leave it first",
                    key="block-open",
                    what=what,
                )
            )

    def require_alone(self, goal: OwnMotion) -> None:
        """Check that nothing else of this Chassis moves the base, before a goal continues.

        Raises:
            MotionRefused: Another motion does.
        """
        self.require_free_base(goal.description)
        self._make_way(goal, self._others(goal), check=True, replace=False)

    def add_goal(self, goal: OwnMotion, since: int, *, check: bool = True, replace: bool = False) -> None:
        """Add a goal that is about to be sent.

        Args:
            goal: The goal.
            since: The `since` of its verb.
            check: False allows it beside a velocity block or another motion.
            replace: True ends another goal that moves the base; its outcome is "replaced".

        Raises:
            MotionRefused: `stop` was called since then, a velocity block is open, or another goal moves.
            ConnectionLost: The Chassis is being closed.
        """
        self._prepare()
        drives = goal.drives
        if drives:
            if check:  # before another goal is ended for it
                self.require_free_base(goal.description)
            self._make_way(goal, self._others(goal), check=check, replace=replace)
        ended = [other for other in self.goals if other.done]  # `done` may use the network
        with self._lock:
            self._require_no_stop(goal.description, since)
            if check and drives:
                self.require_free_base(goal.description)
                # Those that another thread has begun since the look above.
                late = [o for o in self.goals if o.holds_the_base and o not in ended and not o.replaced_by]
                self._make_way(goal, late, check=True, replace=False)
            if (scope := current()) is not None:
                scope.add(goal, goal.description, lambda: self.end(goal, 5.0))
            self._will_move()
            before = self._goals
            self._goals = (*(other for other in before if not other.gone or _just_cancelled(other)), goal)
            try:
                self._require_no_stop(goal.description, since)
            except BaseException:
                self._goals = before
                raise
        self._immediate_stop.start()  # from now on it checks every second

    def _others(self, goal: OwnMotion) -> list[OwnMotion]:
        return [o for o in self.goals if o is not goal and not o.done and o.holds_the_base]

    def _make_way(self, goal: OwnMotion, others: list[OwnMotion], *, check: bool, replace: bool) -> None:
        """Refuse a goal while others of ours move the base, or end those."""
        if others and check and not replace:
            raise MotionRefused(
                advice(
                    "{what} refused, nothing was sent: {goals} is under way and would be lost; wait for it "
                    "or cancel it, or replace it with replace=True",
                    key="replace",
                    what=goal.description,
                    goals=[each.description for each in others],
                )
            )
        for other in others:
            other.replaced_by = goal.description
            # One server passes smoothly from a goal to the next; between two servers nothing is documented.
            if replace and not (other.server and other.server == goal.server):
                self._end_replaced(other)

    def end(self, goal: OwnMotion, timeout: float, why: str = "cancel() was called") -> Outcome:
        """End one goal. Ctrl-C does not interrupt this; KeyboardInterrupt is raised afterwards.

        Raises:
            RosError: The cancellation could not be sent, or was not confirmed in time.
        """
        return self.executor.do(lambda: goal.end(timeout, why), _CANCEL_SECONDS + 2.0 * timeout)

    def _end_replaced(self, other: OwnMotion) -> None:
        try:
            self.executor.do(lambda: other.end(3.0, "replaced"), 10.0)
        except RosError as error:
            other.replaced_by = ""
            wrong = "{goal} could not be ended, so nothing else was sent: {error}"
            raise MotionRefused(say(wrong, goal=other.description, error=error)) from error

    def forget_replacing(self, goal: OwnMotion) -> None:
        """Undo `replaced_by` when the replacing goal was not sent: the others continue."""
        for other in self.goals:
            if other.replaced_by == goal.description:
                other.replaced_by = ""

    def take_goals(self) -> list[OwnMotion]:
        """Return the goals to cancel: those under way, and, once, those that were just let go."""
        taken = [goal for goal in self._goals if not goal.gone or _just_cancelled(goal)]
        for goal in taken:
            goal.cancelled_at = None
        return taken

    @property
    def just_cancelled(self) -> bool:
        """Whether a goal was cancelled in the last seconds because its wait was interrupted."""
        return any(map(_just_cancelled, self._goals))

    def add_drive(self, drive: Drive, since: int, *, check: bool = True) -> None:
        """Add a drive that is about to open; only one can be open.

        Args:
            drive: The drive.
            since: The `since` of its verb.
            check: False allows it beside a goal of ours.

        Raises:
            MotionRefused: Another one is open, a goal of ours moves the base, or `stop` was called meanwhile.
            ConnectionLost: The Chassis is being closed.
        """
        self._prepare()
        under_way = [goal for goal in self.goals if not goal.done]  # `done` may use the network
        with self._lock:
            self._require_no_stop(say("velocity"), since)
            driving = [goal.description for goal in self.goals if goal in under_way and goal.drives]
            if check and driving:
                raise MotionRefused(
                    say(
                        "velocity refused: {what} is under way and would be disturbed; wait for it, pause or "
                        "cancel it first",
                        what=", ".join(driving),
                    )
                )
            if any(not other.finished for other in self._drives):
                raise MotionRefused("another velocity block is open on this Chassis; leave it first")
            if (scope := current()) is not None:
                scope.add(drive, "velocity", drive.abandon)
            self._will_move()
            self._drives = (drive,)
            try:
                self._require_no_stop(say("velocity"), since)
            except BaseException:
                self._drives = ()
                raise
        self._immediate_stop.start()

    def remove_drive(self, drive: Drive) -> None:
        """Remove an ended drive."""
        if drive in self._drives:
            self._drives = ()

    def close(self) -> None:
        """Remove everything and end the threads; all motions must have ended."""
        atexit.unregister(self._at_exit)
        self._immediate_stop.end()
        self.executor.end()
        self._goals = ()

    def _prepare(self) -> None:
        """Start the threads that stopping needs, and read its definitions, before anything moves.

        Raises:
            RuntimeError: No thread can be started; the motion must not begin.
        """
        if not self.moved:
            service_type(row("/exec_task").type)
            for name in ("GoalID", "GoalStatusArray"):
                decoder(message_type(f"actionlib_msgs/{name}"))
        self.executor.start()
        self._immediate_stop.start()

    def _require_no_stop(self, what: str, since: int) -> None:
        self.require_not_over()
        if self.stops != since:
            raise MotionRefused(
                advice(
                    "{what}: stop() was called while it was being prepared; nothing was sent",
                    key="stopped",
                    what=what,
                )
            )

    def _will_move(self) -> None:
        if not self.moved:
            for _ in range(_EXIT_CALLS):
                atexit.register(self._at_exit)
        self.moved = True

    def _at_exit(self) -> None:
        """End motions of a program that did not use `with`, or was interrupted repeatedly while leaving it.

        Registered after the node's own exit function, so it is called before it: the node still works.
        """
        if os.getpid() == self._pid:  # in a forked child the motions are the parent's
            self.executor.put(self._exit)
            self._exit.join()

    def _end_at_exit(self) -> None:
        self.note_end("the program ended")
        for problem in self.end_all("the program ended"):
            logger.warning("! not done when the program ended, the robot may still be driving: %s", problem)


def _report_ahead() -> StopReport:
    text = say("looking after it (the program has reached its recursion limit; it goes on in a thread)")
    return StopReport(problems=[text])


def _just_cancelled(goal: OwnMotion) -> bool:
    return goal.cancelled_at is not None and time.monotonic() - goal.cancelled_at < _JUST_CANCELLED_SECONDS


def cancel_goals(goals: Sequence[OwnMotion], report: StopReport, timeout: float, why: str) -> None:
    """Cancel goals that this client started, all at the same time.

    Args:
        goals: The goals.
        report: Successes and failures are added to it.
        timeout: Seconds for the chassis to confirm.
        why: The reason, for the outcomes.
    """
    jobs = []
    for goal in goals:
        job = Job(partial(_cancel, goal, report, timeout, why), timeout + 1.0)
        begin(job, "woosh:cancel")
        jobs.append((job, goal))
    for job, goal in jobs:
        job.join()
        if not job.over:
            report.problems.append(say("cancelling {goal} (no answer yet)", goal=goal.description))


def _cancel(goal: OwnMotion, report: StopReport, timeout: float, why: str) -> None:
    try:
        outcome = goal.end(timeout, why)
        if outcome.kind is OutcomeKind.CANCELLED and outcome.text == NOT_CONFIRMED and not outcome.stopped:
            report.problems.append(
                say("cancelling {goal} ({error})", goal=goal.description, error=say(NOT_CONFIRMED))
            )
        else:
            report.cancelled.append(say("{goal} ({kind})", goal=say(goal.description), kind=outcome.kind))
    except (RosError, OSError, RuntimeError) as error:
        report.problems.append(say("cancelling {goal} ({error})", goal=goal.description, error=error))
