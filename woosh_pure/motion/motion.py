"""`Motion`: one task or action goal inside this client, from before it is sent until its end is seen.

It has the state (by the table of `motion_states`) and the outcome, sends the goal without being interrupted
by Ctrl-C, and asks for its end. Stopping works with it (`woosh_pure.stopping.active_motions`). Tasks and
action goals are subclasses (`task.TaskMotion`, `action_goal.ActionMotion`). Users hold a
`goal_handle.GoalHandle` instead.
"""

from __future__ import annotations

import math
import queue
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import replace
from typing import Generic, TypeVar

from rosproto.errors import ConnectionLost, RosError
from rosproto.logs import get_logger
from rosproto.sentence import both, say
from rosproto.transport import Deadline
from woosh_pure.components import Components
from woosh_pure.connection.connection import FinalMessage
from woosh_pure.motion.motion_states import Event, State, state_after
from woosh_pure.outcome import NOT_CONFIRMED, Outcome, OutcomeKind
from woosh_pure.stopping.stop_executor import SLICE, Flag, Job

P = TypeVar("P")
R = TypeVar("R")
logger = get_logger("woosh_pure.goal")
_AGAIN = 1.0  # seconds between two cancels
_CANCEL_SECONDS = 6.0

_BY_US = (OutcomeKind.CANCELLED, OutcomeKind.REPLACED)
_REPLACEABLE = (*_BY_US, OutcomeKind.FAILED)


class Motion(ABC, Generic[P]):
    """One task or action goal. Safe from any thread and over any interrupted frame: it has no lock.

    Args:
        components: The parts of the chassis.
        description: The goal in words.
        task_id: The id of a task; 0 for an action goal.
        server: The action server that has the goal, where a second goal replaces it; "" for a task.

    Attributes:
        components, description, task_id, server: As given.
        newest: The newest progress, None before the first.
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
        self.over = Flag()
        self.reported: Outcome | None = None
        self.why = ""
        self.replaced_by = ""
        self.marked = False
        self.cancelled_at: float | None = None
        self._callbacks: list[Callable[[P], object]] = []
        self._calling: set[int] = set()
        self._events: list[Event] = []
        # Holds one item; taking it permits reporting the outcome.
        self._untold: queue.SimpleQueue[None] = queue.SimpleQueue()
        self._untold.put(None)
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

    def on_progress(self, callback: Callable[[P], object]) -> None:
        """Call `callback(progress)` for each report."""
        self._callbacks.append(callback)

    def _advance(self, progress: P) -> None:
        self.newest = progress
        callbacks = list(self._callbacks)
        me = threading.get_ident()
        self._calling.add(me)
        try:
            for callback in callbacks:
                self._call(callback, progress)
        finally:
            self._calling.discard(me)

    def _call(self, callback: Callable[[P], object], progress: P) -> None:
        try:
            callback(progress)
        except Exception:
            logger.exception("%s: a progress callback failed", self.description)

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
            self._untold.get_nowait()
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
                    "asked for, not confirmed yet",
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
            raise ConnectionLost(
                say("{goal}: cancelled, but the chassis cannot be heard; it may go on", goal=self)
            )
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
