"""`GoalHandle`, which users hold: the base of the handles of tasks and action goals.

It has the public methods (wait, cancel, progress, outcome); all else is in its `motion.Motion`.
A wait that times out cancels the goal and checks that the robot stands still.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from functools import partial
from typing import Any, Generic, TypeVar

from rosproto.errors import LocalProtocolError
from rosproto.logs import get_logger
from rosproto.sentence import say
from woosh_pure.connection.arguments import require_limit, require_timeout
from woosh_pure.errors import GoalFailed
from woosh_pure.motion.motion import Motion
from woosh_pure.outcome import Outcome

P = TypeVar("P")
logger = get_logger("woosh_pure.goal")

_LOOK = 0.02  # seconds
_TIME_OUT_SECONDS = 15.0  # for the steps that Ctrl-C does not interrupt


class DefaultTimeout:
    """Type of the default argument where None means "for ever"."""

    def __repr__(self) -> str:
        return "default_timeout"


OWN_DEFAULT = DefaultTimeout()
"""The default of `wait`'s `timeout`."""


class GoalHandle(Generic[P]):
    """A goal under way. Made by the verbs of `Chassis`.

    Attributes:
        description: The goal in words.
        default_timeout: Default time limit of `wait()`, s; None waits for ever.
    """

    def __init__(self, motion: Motion[P], default_timeout: float | None) -> None:
        self._motion = motion
        self.description = motion.description
        self.default_timeout = require_timeout(default_timeout)

    @property
    def task_id(self) -> int:
        """The id of a task; 0 for a goal of another kind."""
        return self._motion.task_id

    @property
    def server(self) -> str:
        """The action server that has the goal, where a later one replaces it; "" for a task."""
        return self._motion.server

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
    def latest_progress(self) -> P | None:
        """The newest progress, None before the first."""
        return self._motion.newest

    def progress_line(self) -> str:
        """The newest progress in words, "" before the first."""
        newest = self.latest_progress
        return "" if newest is None else self._describe(newest)

    def _describe(self, progress: P) -> str:
        return str(progress)

    def on_progress(self, callback: Callable[[P], object]) -> None:
        """Call `callback(progress)` for each report, in a thread of the library."""
        self._motion.on_progress(callback)

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
                self._motion.over.wait(_LOOK)

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
                raise LocalProtocolError(
                    say(
                        "{goal}: waiting for it in its own callback would never end; wait in another thread",
                        goal=self.description,
                    )
                )
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
