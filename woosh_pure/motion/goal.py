"""What all running goals have in common: waiting, outcome, cancelling, progress.

A handle ends exactly once. A wait that times out cancels the goal and makes sure that the robot stands still.
"""

from __future__ import annotations

import math
import queue
import threading
import time
from collections.abc import Callable, Generator, Iterator
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from rosproto.errors import ConnectionLost, LocalProtocolError, RosError
from rosproto.logs import get_logger
from rosproto.transport import Deadline
from woosh_pure.connection.timeouts import require_limit, require_timeout
from woosh_pure.errors import GoalFailed
from woosh_pure.outcome import NOT_CONFIRMED, Outcome, OutcomeKind
from woosh_pure.stopping.flag import SLICE as _SLICE
from woosh_pure.stopping.flag import Flag
from woosh_pure.stopping.keeper import Job
from woosh_pure.stopping.running import OwnGoal

if TYPE_CHECKING:
    from woosh_pure.core import Core

__all__ = ["OWN_DEFAULT", "Default", "GoalHandle"]

P = TypeVar("P")
R = TypeVar("R")
logger = get_logger("woosh_pure.goal")

_LOOK, _AGAIN = 0.02, 1.0  # seconds
_TIME_OUT_SECONDS, _CANCEL_SECONDS, _LET_GO_SECONDS = (
    15.0,
    10.0,
    6.0,
)  # time limits for steps that Ctrl-C does not interrupt

_BY_US = (OutcomeKind.CANCELLED, OutcomeKind.REPLACED)
_REPLACEABLE = (*_BY_US, OutcomeKind.FAILED)


class Default:
    """Stands for "not given" where None means "for ever"."""

    def __repr__(self) -> str:
        return "default_timeout"


OWN_DEFAULT = Default()
"""The default of `wait`'s `timeout`."""


class GoalHandle(OwnGoal, Generic[P]):
    """A goal under way. Made by the verbs of `Chassis`.

    Attributes:
        description: What was asked, in words.
        default_timeout: What `wait()` uses, s; None waits for ever.
    """

    def __init__(self, core: Core, description: str, default_timeout: float | None) -> None:
        self._core = core
        self.description = description
        self.default_timeout = require_timeout(default_timeout)
        # No lock: a signal handler's stop must see the end that comes while it has interrupted a frame in
        # here.
        self._over = Flag()
        self._unended: queue.SimpleQueue[None] = queue.SimpleQueue()  # holds one thing, which the end takes
        self._unended.put(None)
        self._outcome: Outcome | None = None
        self._started = time.monotonic()
        self._newest: P | None = None
        self._callbacks: list[Callable[[P], object]] = []
        self._calling: set[int] = set()
        self._cancelled_by_us = False
        self._why = ""  # in words, why this client cancelled it
        self._time_up = ""  # in words, that the limit of a wait has passed, which is then how it ended
        self._may_go_on = False  # ended for us, but the robot has not confirmed that it ended the goal
        self._written = -math.inf  # when its cancel was written last
        self._sending: threading.Thread | None = None

    @property
    def holds_the_base(self) -> bool:
        """Whether another motion would disturb it: it drives, and is not being cancelled by us."""
        return self.drives and not self._cancelled_by_us

    def __repr__(self) -> str:
        outcome = self._outcome  # not `if outcome`: an outcome other than arrival is falsy
        state = "running" if outcome is None else outcome.kind.value
        return f"<{type(self).__name__} {self.description}: {state}>"

    # -- as stopping sees it ---------------------------------------------------------------------------------

    @property
    def gone(self) -> bool:
        """Whether it was seen to have ended on the robot, or never was there: nothing is left to stop."""
        return self._over.is_set and not self._may_go_on

    @property
    def end_due(self) -> bool:
        """Whether this client asked for its end, and has not seen it."""
        return self._cancelled_by_us and not self.gone

    def end_now(self, why: str) -> None:
        """Mark it as cancelled and write the cancel, if there is a connection. Waits for nothing."""
        self._mark_cancelled(why)
        self._written = time.monotonic()
        self._write_cancel()

    def end_again(self) -> None:
        """Ask once more, when the last time was a while ago."""
        if time.monotonic() - self._written >= _AGAIN:
            self._written = time.monotonic()
            self._repeat_cancel()

    # -- for subclasses --------------------------------------------------------------------------------------

    def _write_cancel(self) -> None:
        """Write the cancel on a connection that stands; neither waits nor logs.

        Raises:
            RosError: There is none.
        """

    def _repeat_cancel(self) -> None:
        """Write the cancel again, or have that done elsewhere: must not wait."""
        self._write_cancel()

    def _request_cancel(self, timeout: float) -> None:
        """Ask the chassis to end this goal; must not wait longer than `timeout`."""
        raise NotImplementedError

    def _send_shielded(self, send: Callable[[], R]) -> R:
        """Run `send` so that Ctrl-C interrupts the wait for it, but never the sending itself.

        Otherwise a goal could be under way that nobody knows about: sent, but without a handle to cancel it.
        """
        result: list[R] = []
        error: list[BaseException] = []

        def work() -> None:
            try:
                result.append(send())
            except BaseException as problem:
                error.append(problem)

        self._sending = threading.Thread(target=work, name="woosh:send", daemon=True)
        self._sending.start()
        while self._sending.is_alive():
            self._sending.join(_SLICE)
        if error:
            raise error[0]
        return result[0]

    def _await_sent(self, timeout: float) -> None:
        """Wait, within a time limit, until the goal has been sent: a cancel must not overtake it."""
        sending = self._sending
        if sending is not None and sending is not threading.current_thread():
            try:
                sending.join(timeout)
            except RuntimeError:  # not started yet: it sees the cancel mark before it sends
                pass

    def _mark_cancelled(self, why: str) -> None:
        """Note that this client cancels it. The sending thread checks this before and after it sends."""
        self._why = self._why or why
        self._cancelled_by_us = True

    def _letting_go(self, *, waited_for: bool = False) -> Job[None]:
        """The keeper's job for a goal that nobody waits for, or whose handle nobody has: cancel it.

        Args:
            waited_for: Somebody has the handle, so `leave_running` leaves the goal running.
        """
        return Job(lambda: self._let_go(waited_for), _LET_GO_SECONDS)

    def _let_go(self, waited_for: bool) -> None:
        if self._outcome is not None and not self._may_go_on:
            return
        if waited_for and self._core.running.leave:
            return
        self.let_go = time.monotonic()
        try:
            self._cancel(3.0, "its wait was interrupted")
        except RosError as error:
            logger.warning("! %s: interrupted, and not cancelled: %s", self.description, error)

    def _abandon(self) -> None:
        """Cancel a goal that nobody waits for any more (asyncio), without waiting for its end."""
        self._mark_cancelled("its wait was interrupted")
        self._core.running.keeper.put(self._letting_go())

    def _cancel_confirmed(self, timeout: float) -> bool:
        """Whether the chassis confirmed a cancel without reporting the end, as with a service's reply."""
        return True

    def _check(self) -> None:
        """Check for an end that no event reports, such as a lost link."""

    def _finish(
        self,
        kind: OutcomeKind,
        text: str = "",
        code: int | None = None,
        stopped: bool | None = None,
        *,
        may_go_on: bool = False,
    ) -> None:
        try:
            self._unended.get_nowait()
        except queue.Empty:
            return  # it has ended before
        # While it may go on, `stop` and `close` must still cancel it.
        self._may_go_on = may_go_on or kind is OutcomeKind.CONNECTION_LOST
        seconds = time.monotonic() - self._started
        if self._time_up and kind is not OutcomeKind.ARRIVED:
            # The cancel ended it as "cancelled"; what the caller needs to know is that its time was up.
            kind, text, code = OutcomeKind.TIMED_OUT, text if may_go_on else self._time_up, None
        elif self._replaced_by and kind in _REPLACEABLE:
            kind, self._why, self._cancelled_by_us = (
                OutcomeKind.REPLACED,
                f"replaced by {self._replaced_by}",
                True,
            )
        ours = self._why if self._cancelled_by_us and kind in _BY_US else ""
        self._outcome = outcome = Outcome(kind, self.description, text, code, stopped, seconds, ours)
        self._over.set()
        if not self._may_go_on:
            self._core.watched.over(self)
        self._core.knowledge.note_outcome(outcome, drives=self.drives, told=bool(self.task_id))

    def _see_end(self) -> None:
        """The robot was seen to have ended it, after its outcome had to be told without that."""
        if not self._may_go_on:
            return
        self._may_go_on = False
        self._core.watched.over(self)
        outcome = self._outcome
        if outcome is not None and outcome.text == NOT_CONFIRMED:
            self._outcome = replace(outcome, text="")

    def _advance(self, progress: P) -> None:
        self._newest = progress
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

    def _in_own_callback(self) -> bool:
        """Whether more about this goal can be heard only after this thread has returned."""
        return threading.get_ident() in self._calling

    # -- for users -------------------------------------------------------------------------------------------

    @property
    def outcome(self) -> Outcome | None:
        """How it ended, None while it runs."""
        if self._outcome is None:
            self._check()
        return self._outcome

    @property
    def done(self) -> bool:
        """True when it has ended, well or badly."""
        return self.outcome is not None

    @property
    def latest_progress(self) -> P | None:
        """The newest progress, None before the first."""
        return self._newest

    def progress_line(self) -> str:
        """The newest progress in words, "" before the first."""
        newest = self.latest_progress
        return "" if newest is None else self._describe(newest)

    def _describe(self, progress: P) -> str:
        return str(progress)

    def on_progress(self, callback: Callable[[P], object]) -> None:
        """Call `callback(progress)` for each report, in a thread of the library."""
        self._callbacks.append(callback)

    def progress(self) -> Iterator[P]:
        """Reports as they come; a slow loop skips to the newest. Ends with the goal."""
        last: P | None = None
        while True:
            newest = self.latest_progress
            if newest is not None and newest is not last:
                last = newest
                yield newest
            elif self.done:
                return
            else:
                self._over.wait(_LOOK)

    def wait(
        self,
        timeout: float | Default | None = OWN_DEFAULT,
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
            LocalProtocolError: Called in a callback that must return before the end can be heard.
        """
        seconds = self.default_timeout if isinstance(timeout, Default) else require_timeout(timeout)
        if not self.done and self._in_own_callback():
            raise LocalProtocolError(
                f"{self.description}: waiting for it in a callback of its own news would wait for itself; "
                "wait in another thread"
            )
        keeper, letting_go = self._core.running.keeper, self._letting_go(waited_for=True)
        let_go = partial(keeper.put, letting_go)
        try:
            if not self._wait_until_done(seconds, meanwhile):
                keeper.do(lambda: self._time_out(seconds or 0.0), _TIME_OUT_SECONDS)
            outcome = self._confirmed()
        except BaseException:
            let_go()  # before anything else: see `keeper`
            keeper.hold(letting_go)
            raise
        if raises and not outcome.arrived:
            raise GoalFailed(outcome)
        return outcome

    def __await__(self) -> Generator[Any, None, Outcome]:
        """In asyncio: `outcome = await handle` is `wait()`; cancelling the awaiting task cancels the goal."""
        return self._awaited().__await__()

    async def _awaited(self) -> Outcome:
        import asyncio

        try:
            return await asyncio.to_thread(self.wait)
        except asyncio.CancelledError:
            self._abandon()
            raise

    def _confirmed(self) -> Outcome:
        """The outcome; unless the robot arrived, it says whether the robot was seen to stand still."""
        outcome = self._outcome
        assert outcome is not None, "a goal that is waited for has ended"
        unknown = not outcome.arrived and outcome.stopped is None
        if unknown and outcome.kind is not OutcomeKind.CONNECTION_LOST:
            self._outcome = outcome = replace(outcome, stopped=self._core.feeds.wait_standing(2.0))
        return outcome

    def _wait_until_done(self, timeout: float | None, meanwhile: Callable[[], object] | None = None) -> bool:
        deadline = Deadline(timeout)
        while not self.done:
            if deadline.expired:
                return False
            self._over.wait(deadline.at_most(_SLICE).remaining() or 0.0)
            if meanwhile is not None:
                meanwhile()
        return True

    def _time_out(self, seconds: float) -> None:
        self._time_up = text = f"not finished within {seconds:.1f} s"
        sent = True
        try:
            self._mark_cancelled("its time was up")
            self._request_cancel(3.0)
        except RosError as error:
            text, sent = f"{text}; cancelling failed: {error}", False
        standing = self._core.feeds.wait_standing(5.0)
        confirmed = sent and (self.gone or self._cancel_confirmed(0.0))
        if sent and not confirmed:
            text = f"{text}; {NOT_CONFIRMED}"
        self._finish(OutcomeKind.TIMED_OUT, text, None, standing, may_go_on=not confirmed)
        outcome = self._outcome
        if outcome is not None and outcome.kind is OutcomeKind.TIMED_OUT and outcome.stopped is None:
            self._outcome = replace(outcome, stopped=standing)  # the end came from the robot, while we looked

    def cancel(self, timeout: float = 5.0) -> Outcome:
        """End it now and wait until the chassis confirms. In a callback of this goal, only ask for the end.

        Returns:
            The outcome: usually cancelled, but arrived if the robot got there first.

        Raises:
            RosError: The cancellation could not be sent, or was not confirmed in time.
            ValueError: `timeout` is negative or NaN.
        """
        timeout = require_limit(timeout)
        return self._core.running.keeper.do(
            lambda: self._cancel(timeout, "cancel() was called"), _CANCEL_SECONDS + 2.0 * timeout
        )

    def _cancel(self, timeout: float, why: str) -> Outcome:
        if not self.done:
            self._mark_cancelled(why)
            self._request_cancel(timeout)
            if self._in_own_callback():
                seconds = time.monotonic() - self._started
                return Outcome(
                    OutcomeKind.CANCELLED, self.description, "asked for, not confirmed yet", seconds=seconds
                )
            if not self._wait_until_done(timeout):
                self._finish(
                    OutcomeKind.CANCELLED,
                    NOT_CONFIRMED,
                    None,
                    self._core.feeds.wait_standing(2.0),
                    may_go_on=not self._cancel_confirmed(0.0),
                )
        elif self._may_go_on:
            self._mark_cancelled(why)
            self._request_cancel(timeout)
            if not self._cancel_confirmed(timeout):
                raise ConnectionLost(
                    f"{self.description}: cancelled, but the chassis cannot be heard; it may go on"
                )
            told = self._outcome is not None and self._outcome.text == NOT_CONFIRMED
            self._see_end()
            if told and self._outcome is not None:
                self._outcome = replace(self._outcome, stopped=self._core.feeds.wait_standing(2.0))
        assert self._outcome is not None, "a cancelled goal has ended"
        return self._outcome
