"""`Motion`: one task or action goal inside this client, from before it is sent until its end is seen.

It has the state (see `State`) and the outcome, sends the goal without being interrupted by Ctrl-C, and asks
for its end. Stopping works with it (`woosh_pure.stopping.active_motions`). Tasks and action goals are
subclasses (`task.TaskMotion`, `action_goal.ActionMotion`). Users hold a `GoalHandle` instead, which has the
public methods: a wait that times out cancels the goal and checks that the robot stands still.
"""

from __future__ import annotations

import math
import queue
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Iterable, Iterator
from dataclasses import replace
from enum import Enum
from functools import partial
from typing import Any, Generic, TypeVar

from rosproto.coercion import require_callback
from rosproto.deprecation import former_attribute
from rosproto.errors import ConnectionLost, LocalProtocolError, RosError
from rosproto.logs import get_logger
from rosproto.sentence import both, say
from rosproto.transport import Deadline
from woosh_pure.components import Components
from woosh_pure.connection.arguments import require_limit, require_timeout
from woosh_pure.connection.connection import FinalMessage
from woosh_pure.errors import GoalFailed
from woosh_pure.feed.feed import call_back
from woosh_pure.geometry import Pose2D
from woosh_pure.hints import HANDLE, Hints
from woosh_pure.motion.progress import PlannedWay, Progress
from woosh_pure.outcome import NOT_CONFIRMED, Outcome, OutcomeKind
from woosh_pure.stopping.stop_executor import SLICE, Flag, Job

P = TypeVar("P")
R = TypeVar("R")
logger = get_logger("woosh_pure.goal")
_AGAIN = 1.0  # seconds between two cancels
_CANCEL_SECONDS = 6.0

_BY_US = (OutcomeKind.CANCELLED, OutcomeKind.REPLACED)
_REPLACEABLE = (*_BY_US, OutcomeKind.FAILED)


class State(Enum):
    """The state of a motion, as this client knows it.

        running     sent, or about to be sent; this client has not asked for its end
        asked       this client has asked for its end, which was not seen yet
        lost        the link is lost; this client has not asked for its end
        not known   the caller was told that the end is not confirmed; the cancel is still due
        ended       its end on the robot was seen, or it was never sent

    The outcome is reported once, on entering one of the last three states. A motion that has not *ended* is
    under way for `stop` and `close`. A cancel is due in *asked* and in *not known*: it is written again every
    second. A motion that is only *lost* is not cancelled when the robot is heard again (a goal continues
    without us, as documented) until this client asks.

    Events of several threads are appended to a list in the order in which they came, and the state is
    computed from it. Nothing is changed in place, so no lock is needed, and an interrupted frame loses no
    event.
    """

    RUNNING = "running"
    ASKED = "asked"
    LOST = "lost"
    NOT_KNOWN = "not known"
    ENDED = "ended"

    @property
    def may_go_on(self) -> bool:
        """Whether the outcome was reported although the robot may still be moving."""
        return self in (State.LOST, State.NOT_KNOWN)

    @property
    def end_due(self) -> bool:
        """Whether this client asked for its end and has not seen it."""
        return self in (State.ASKED, State.NOT_KNOWN)


class Event(Enum):
    """An event of a motion.

    *ask*: this client asks for its end; *end*: the robot reports it, or the motion cannot be there; *silent*:
    the link is lost; *give up*: the time limit for the confirmation has passed.
    """

    ASK = "ask"
    END = "end"
    SILENT = "silent"
    GIVE_UP = "give up"


# What an event leads to; one that is not listed changes nothing.
_AFTER = {
    State.RUNNING: {
        Event.ASK: State.ASKED,
        Event.END: State.ENDED,
        Event.SILENT: State.LOST,
        Event.GIVE_UP: State.NOT_KNOWN,
    },
    State.ASKED: {Event.END: State.ENDED, Event.SILENT: State.NOT_KNOWN, Event.GIVE_UP: State.NOT_KNOWN},
    State.LOST: {Event.ASK: State.NOT_KNOWN, Event.END: State.ENDED},
    State.NOT_KNOWN: {Event.END: State.ENDED},
    State.ENDED: {},
}


def state_after(events: Iterable[Event]) -> State:
    """The state that events lead to, in the order in which they came."""
    state = State.RUNNING
    for event in events:
        state = _AFTER[state].get(event, state)
    return state


class Motion(ABC, Generic[P]):
    """One task or action goal. Safe from any thread and over any interrupted frame: it has no lock.

    Args:
        components: The parts of the chassis.
        description: The goal in words.
        task_id: The id of a task; 0 for an action goal.
        server: The action server that has the goal, where a second goal replaces it; "" for a task.

    Attributes:
        components, description, task_id, server: As given.
        newest: The newest report, None before the first.
        way: The path of a drive; None if it has none.
        over: Set with the outcome.
        reported: The outcome, None before it is reported; `outcome` looks for an end first.
        why: The reason why this client asked for its end; "" while it has not.
        replaced_by: The description of our motion that replaces it; "" for none.
        marked: Whether a caller without stack has asked for its end, see `immediate_stop`.
        cancelled_at: Time (monotonic clock) of the cancel because its caller no longer waits; None if there
            was none, or a stop has reported it since.
    """

    def __init__(
        self, components: Components, description: str, *, task_id: int = 0, server: str = ""
    ) -> None:
        self.components = components
        self.description = description
        self.task_id, self.server = task_id, server
        self.newest: P | None = None
        self.way: PlannedWay | None = None
        self.over = Flag()
        self.reported: Outcome | None = None
        self.why = ""
        self.replaced_by = ""
        self.marked = False
        self.cancelled_at: float | None = None
        self._callbacks: list[Callable[[Progress], object]] = []
        self._calling: set[int] = set()
        self._events: list[Event] = []
        # Holds one item; taking it permits reporting the outcome.
        self._permit_to_report: queue.SimpleQueue[None] = queue.SimpleQueue()
        self._permit_to_report.put(None)
        self._time_up = ""  # text of the outcome when the limit of a wait has passed
        self._began = time.monotonic()
        self._written = -math.inf  # when its cancel was written last
        self._sending: threading.Thread | None = None

    # -- what tasks and action goals do differently ----------------------------------------------------------

    @property
    @abstractmethod
    def drives(self) -> bool:
        """Whether it may move the base now."""

    @abstractmethod
    def write_cancel(self) -> None:
        """Write the cancel on an open connection; does not wait or log.

        Raises:
            RosError: It could not be written.
        """

    def repeat_cancel(self) -> None:
        """Write it again, or let another thread do so; must not wait."""
        self.write_cancel()

    @abstractmethod
    def request_cancel(self, timeout: float) -> None:
        """Ask the chassis to end it, within the given seconds.

        Raises:
            RosError: It could not be asked.
        """

    def cancel_confirmed(self, timeout: float) -> bool:
        """Whether the chassis confirmed a cancel within the given seconds without reporting the end, as by a
        service's reply.
        """
        return True

    @abstractmethod
    def check(self) -> None:
        """Look for an end that no event reports, such as a lost link."""

    @property
    def final_message(self) -> FinalMessage | None:
        """The message that cancels it from another node; None if there is none."""
        return None

    # -- progress --------------------------------------------------------------------------------------------

    @property
    def progress(self) -> Progress:
        """How far it is; never waits."""
        outcome, pose = self.reported, self.components.feeds.get("pose").known
        here = None if pose is None else pose.value
        percent, metres = self._come(here)
        if outcome is not None and outcome.arrived:
            percent, metres = 100.0, 0.0 if self.drives else None
        return Progress(percent, metres, self.seconds if outcome is None else outcome.seconds, here)

    def _come(self, here: Pose2D | None) -> tuple[float | None, float | None]:
        """Percent done and metres left."""
        return (None, None) if self.way is None else self.way.left(here)

    def on_progress(self, callback: Callable[[Progress], object]) -> None:
        """Call `callback(progress)` for each report."""
        self._callbacks.append(require_callback(callback))

    def _advance(self, report: P) -> None:
        self.newest = report
        callbacks = list(self._callbacks)
        if not callbacks:
            return
        progress = self.progress
        me = threading.get_ident()
        self._calling.add(me)
        try:
            for callback in callbacks:
                call_back(callback, progress, self.description)
        finally:
            self._calling.discard(me)

    @property
    def in_own_callback(self) -> bool:
        """Whether this thread is in a callback that must return before the next message is received."""
        return threading.get_ident() in self._calling

    def __str__(self) -> str:
        return self.description

    # -- state -----------------------------------------------------------------------------------------------

    @property
    def state(self) -> State:
        """Its state."""
        return state_after(self._events)

    def _note(self, event: Event) -> None:
        self._events.append(event)

    @property
    def asked(self) -> bool:
        """Whether this client has asked for its end."""
        return Event.ASK in self._events

    @property
    def gone(self) -> bool:
        """Whether it has ended on the robot or was never sent, so that it need not be stopped."""
        return self.over.is_set and self.state is State.ENDED

    @property
    def may_go_on(self) -> bool:
        """Whether its outcome was reported although the robot may still be moving."""
        return self.over.is_set and self.state.may_go_on

    @property
    def holds_the_base(self) -> bool:
        """Whether another motion would disturb it: it drives, and is not being cancelled by us."""
        return self.drives and not self.asked

    @property
    def outcome(self) -> Outcome | None:
        """The outcome, None while it runs."""
        if self.reported is None:
            self.check()
        return self.reported

    @property
    def done(self) -> bool:
        """True when it has ended, with any outcome."""
        return self.outcome is not None

    @property
    def seconds(self) -> float:
        """Seconds since it began."""
        return time.monotonic() - self._began

    # -- as stopping sees it ---------------------------------------------------------------------------------

    @property
    def end_due(self) -> bool:
        """Whether this client asked for its end and has not seen it."""
        return self.state.end_due or (self.marked and not self.asked)

    def ask_end(self, why: str) -> None:
        """Mark that this client asks for its end; the sending thread checks this before and after sending."""
        self.why = self.why or why
        self._written = time.monotonic()
        self._note(Event.ASK)

    def end_now(self, why: str) -> None:
        """Ask for its end and write the cancel, if there is a connection. Does not wait."""
        self.ask_end(why)
        self.write_cancel()

    def end_again(self) -> None:
        """Write the cancel once more, unless it was written recently."""
        if not self.asked:
            self.end_now("cancel() was called")
        elif time.monotonic() - self._written >= _AGAIN:
            self._written = time.monotonic()
            self.repeat_cancel()

    # -- sending ---------------------------------------------------------------------------------------------

    def send(self, send: Callable[[], R]) -> R:
        """Run `send` so that Ctrl-C interrupts the wait for it, but never the sending itself.

        Otherwise a goal could be under way without a handle to cancel it.
        """
        job = Job(send, math.inf)
        self._sending = threading.Thread(target=job.run, name="woosh:send", daemon=True)
        self._sending.start()
        while self._sending.is_alive():
            self._sending.join(SLICE)
        return job.result()

    @property
    def being_sent(self) -> bool:
        """Whether the sending thread is running."""
        return self._sending is not None and self._sending.is_alive()

    def await_sent(self, timeout: float) -> None:
        """Wait, within a time limit, until the goal has been sent: a cancel must not overtake it."""
        sending = self._sending
        if sending is not None and sending is not threading.current_thread():
            try:
                sending.join(timeout)
            except RuntimeError:  # not started yet: it checks `asked` before it sends
                pass

    # -- its end ---------------------------------------------------------------------------------------------

    def finish(
        self,
        kind: OutcomeKind,
        text: str = "",
        code: int | None = None,
        stopped: bool | None = None,
        *,
        may_go_on: bool = False,
    ) -> None:
        """Report the outcome, once. Later events change only whether the robot has ended it."""
        may_go_on = may_go_on or kind is OutcomeKind.CONNECTION_LOST
        try:
            self._permit_to_report.get_nowait()
        except queue.Empty:
            return
        if not may_go_on:
            self._note(Event.END)
        else:  # `stop` and `close` must still cancel it
            self._note(Event.SILENT if kind is OutcomeKind.CONNECTION_LOST else Event.GIVE_UP)
        if self._time_up and kind is not OutcomeKind.ARRIVED:
            # The cancel ended it as "cancelled", but the cause was the timeout.
            kind, text, code = OutcomeKind.TIMED_OUT, text if may_go_on else self._time_up, None
        elif self.replaced_by and kind in _REPLACEABLE:
            kind, self.why = OutcomeKind.REPLACED, say("replaced by {goal}", goal=self.replaced_by)
        ours = self.why if kind in _BY_US else ""
        self.reported = outcome = Outcome(kind, self.description, text, code, stopped, self.seconds, ours)
        self.over.set()
        if self.way is not None:
            self.way.end()
        if not may_go_on:
            self.components.watchdog_client.over(self)
        self.components.readiness_state.note_outcome(outcome, drives=self.drives, reported=bool(self.task_id))

    def see_end(self) -> None:
        """Mark that the robot has ended it, after the outcome was reported without that."""
        if not self.may_go_on:
            return
        self._note(Event.END)
        self.components.watchdog_client.over(self)
        if self.reported is not None and self.reported.text == NOT_CONFIRMED:
            self.reported = replace(self.reported, text="")

    def wait(self, timeout: float | None, meanwhile: Callable[[], object] | None = None) -> bool:
        """Wait for the outcome; False when time is up."""
        deadline = Deadline(timeout)
        while not self.done:
            if deadline.expired:
                return False
            self.over.wait(deadline.at_most(SLICE).remaining() or 0.0)
            if meanwhile is not None:
                meanwhile()
        return True

    def time_out(self, seconds: float) -> None:
        """End it because a wait timed out, and check whether the robot stands still."""
        self._time_up = text = say("not finished within {seconds:.1f} s", seconds=seconds)
        sent = True
        try:
            self.ask_end("its timeout expired")
            self.request_cancel(3.0)
        except RosError as error:
            text, sent = both(text, say("cancelling failed: {error}", error=error)), False
        standing = self.components.feeds.wait_standing(5.0)
        confirmed = sent and (self.gone or self.cancel_confirmed(0.0))
        if sent and not confirmed:
            text = both(text, NOT_CONFIRMED)
        self.finish(OutcomeKind.TIMED_OUT, text, None, standing, may_go_on=not confirmed)
        outcome = self.reported  # another one than ours, if the robot reported the end meanwhile
        if outcome is not None and outcome.kind is OutcomeKind.TIMED_OUT and outcome.stopped is None:
            self.reported = replace(outcome, stopped=standing)

    def confirmed(self) -> Outcome:
        """The outcome; unless the robot arrived, it says whether the robot was seen to stand still."""
        outcome = self.reported
        assert outcome is not None, "a goal that is waited for has ended"
        unknown = not outcome.arrived and outcome.stopped is None
        if unknown and outcome.kind is not OutcomeKind.CONNECTION_LOST:
            self.reported = outcome = replace(outcome, stopped=self.components.feeds.wait_standing(2.0))
        return outcome

    def end(self, timeout: float, why: str) -> Outcome:
        """End it now, and wait, within a limit, until the chassis confirms; in this thread.

        Raises:
            RosError: The cancel could not be sent, or the chassis cannot be heard.
        """
        if not self.done:
            self.ask_end(why)
            self.request_cancel(timeout)
            if self.in_own_callback:
                return Outcome(
                    OutcomeKind.CANCELLED,
                    self.description,
                    "requested, but not confirmed yet",
                    seconds=self.seconds,
                )
            if not self.wait(timeout):
                standing = self.components.feeds.wait_standing(2.0)
                sure = self.cancel_confirmed(0.0)
                self.finish(OutcomeKind.CANCELLED, NOT_CONFIRMED, None, standing, may_go_on=not sure)
        elif self.may_go_on:
            self._end_late(timeout, why)
        assert self.reported is not None, "a cancelled goal has ended"
        return self.reported

    def _end_late(self, timeout: float, why: str) -> None:
        self.ask_end(why)
        self.request_cancel(timeout)
        if not self.cancel_confirmed(timeout):
            wrong = "{goal}: cancelled, but nothing is received from the chassis; it may keep moving"
            raise ConnectionLost(say(wrong, goal=self))
        unconfirmed = self.reported is not None and self.reported.text == NOT_CONFIRMED
        self.see_end()
        if unconfirmed and self.reported is not None:
            self.reported = replace(self.reported, stopped=self.components.feeds.wait_standing(2.0))

    def cancel_job(self, *, waited_for: bool = False) -> Job[None]:
        """Make the executor's job that cancels a goal whose wait was interrupted or handle was lost.

        Args:
            waited_for: The caller has the handle, so `leave_running` leaves the goal running.
        """
        return Job(lambda: self._cancel_unwaited(waited_for), _CANCEL_SECONDS)

    def _cancel_unwaited(self, waited_for: bool) -> None:
        if self.gone or (waited_for and self.components.motions.leave):
            return
        self.cancelled_at = time.monotonic()
        try:
            self.end(3.0, "its wait was interrupted")
        except RosError as error:
            logger.warning("! %s: interrupted, and not cancelled: %s", self.description, error)

    def abandon(self) -> None:
        """Cancel the goal of a cancelled asyncio task, without waiting for its end."""
        self.ask_end("its wait was interrupted")
        self.components.motions.executor.put(self.cancel_job())


_LOOK = 0.02  # seconds
_TIME_OUT_SECONDS = 15.0  # for the steps that Ctrl-C does not interrupt


class DefaultTimeout:
    """Type of the default argument where None means "for ever"."""

    def __repr__(self) -> str:
        return "default_timeout"


OWN_DEFAULT = DefaultTimeout()
"""The default of `wait`'s `timeout`."""


class GoalHandle(Hints, Generic[P]):
    """A goal under way. Made by the verbs of `Chassis`.

    Attributes:
        description: The goal in words.
        default_timeout: Default time limit of `wait()`, s; None waits for ever.
        task_id: The id of a task; 0 for a goal of another kind.
        server: The action server that has the goal, where a later one replaces it; "" for a task.
    """

    _hints = HANDLE

    def __init__(self, motion: Motion[P], default_timeout: float | None) -> None:
        self._motion = motion
        self.description, self.task_id, self.server = motion.description, motion.task_id, motion.server
        self.default_timeout = require_timeout(default_timeout)

    @property
    def drives(self) -> bool:
        """True while this goal may move the base."""
        return self._motion.drives

    @property
    def holds_the_base(self) -> bool:
        """Whether another motion would disturb it: it drives, and is not being cancelled by us."""
        return self._motion.holds_the_base

    def __repr__(self) -> str:
        outcome = self._motion.reported  # not `if outcome`: an outcome other than arrival is falsy
        state = "running" if outcome is None else outcome.kind.value
        return f"<{type(self).__name__} {self.description}: {state}>"

    @property
    def outcome(self) -> Outcome | None:
        """The outcome, None while it runs."""
        return self._motion.outcome

    @property
    def done(self) -> bool:
        """True when it has ended, with any outcome."""
        return self._motion.done

    @property
    def progress(self) -> Progress:
        """How far it has come: percent, metres left, seconds and pose; `str()` is a line. Never waits."""
        return self._motion.progress

    @property
    def latest_report(self) -> P | None:
        """The chassis's newest report, None before the first."""
        return self._motion.newest

    latest_progress = former_attribute("latest_progress", "latest_report")

    def on_progress(self, callback: Callable[[Progress], object]) -> None:
        """Call `callback(progress)` for each report of the chassis, in a thread of the library."""
        self._motion.on_progress(callback)

    def reports(self) -> Iterator[P]:
        """The chassis's reports as they come; a slow loop skips to the newest. Ends with the goal."""
        last: P | None = None
        while True:
            newest = self.latest_report
            if newest is not None and newest is not last:
                last = newest
                yield newest
            elif self.done:
                return
            else:
                self._motion.over.wait(_LOOK)

    def on_done(self, callback: Callable[[Outcome], object]) -> None:
        """Call `callback(outcome)` once, when it has ended: at once if it has.

        It is called in a thread of its own, named `woosh:done`, where it may take its time and call any verb.
        An exception in it is logged with its traceback. It does not end the goal after `default_timeout`, as
        `wait` does.
        """
        require_callback(callback)

        def run() -> None:
            self._motion.wait(None)
            call_back(callback, self._motion.confirmed(), self.description)

        threading.Thread(target=run, name="woosh:done", daemon=True).start()

    def wait(
        self,
        timeout: float | DefaultTimeout | None = OWN_DEFAULT,
        *,
        raises: bool = True,
        meanwhile: Callable[[], object] | None = None,
    ) -> Outcome:
        """Wait for the end.

        When `timeout` passes, the goal is cancelled and the stop is confirmed before this returns. Anything
        else that ends the wait cancels the goal, too, unless the Chassis has `leave_running`: an exception
        raised by `meanwhile`, or Ctrl-C, even where it leaves no `with` block (in a notebook). The first
        Ctrl-C starts the cancel, and further ones do not interrupt it.

        Args:
            timeout: Seconds; None waits for ever. The default is `default_timeout`.
            raises: False returns an outcome other than arrival instead of raising it.
            meanwhile: Called in this thread about ten times a second, to show the progress. An exception it
                raises ends the wait and the goal.

        Raises:
            GoalFailed: It did not arrive; `error.outcome` says how it ended.
            ValueError: `timeout` is negative or NaN.
            LocalProtocolError: Called in a callback that must return before the end can be received.
        """
        try:
            given = self.default_timeout if isinstance(timeout, DefaultTimeout) else timeout
            seconds = require_timeout(given)
            if not self.done and self._motion.in_own_callback:
                wrong = "{goal}: waiting for it in its own callback would never end; wait in another thread"
                raise LocalProtocolError(say(wrong, goal=self.description))
            executor = self._motion.components.motions.executor
            cancel_job = self._motion.cancel_job(waited_for=True)
            start_cancel = partial(executor.put, cancel_job)
            try:
                if not self._motion.wait(seconds, meanwhile):
                    executor.do(lambda: self._motion.time_out(seconds or 0.0), _TIME_OUT_SECONDS)
                outcome = self._motion.confirmed()
            except BaseException:
                start_cancel()  # must be first: see `stop_executor`
                executor.hold(cancel_job)
                raise
            if raises and not outcome.arrived:
                raise GoalFailed(outcome)
            return outcome
        except RecursionError:
            self._motion.marked = not self._motion.components.motions.leave  # without a call, as in `cancel`
            raise

    def __await__(self) -> Generator[Any, None, Outcome]:
        """In asyncio: `outcome = await handle` is `wait()`; cancelling the awaiting task cancels the goal."""
        return self._awaited().__await__()

    async def _awaited(self) -> Outcome:
        import asyncio

        try:
            return await asyncio.to_thread(self.wait)
        except asyncio.CancelledError:
            self._motion.abandon()
            raise

    def cancel(self, timeout: float = 5.0) -> Outcome:
        """End it now and wait until the chassis confirms. In a callback of this goal, only ask for the end.

        Returns:
            The outcome: usually cancelled, but arrived if the robot got there first.

        Raises:
            RosError: The cancellation could not be sent, or was not confirmed in time.
            ValueError: `timeout` is negative or NaN.
        """
        try:
            seconds = require_limit(timeout)
        except RecursionError:
            seconds = timeout
        self._motion.marked = True  # without a call: no stack may be left, see `immediate_stop`
        return self._motion.components.motions.end(self._motion, seconds)
