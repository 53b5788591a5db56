"""Goals in asyncio: `Goal`, which a verb returns and `await` starts, and the handles of goals under way."""

from __future__ import annotations

import asyncio
import warnings
from collections.abc import AsyncIterator, Callable, Coroutine, Generator
from types import TracebackType
from typing import Any, Generic, TypeVar

from rosproto.aio import Mailbox, SameProperty
from rosproto.deprecation import former_attribute
from rosproto.errors import ConnectionLost, RosError
from rosproto.logs import get_logger
from rosproto.sentence import say
from woosh_pure.aio.calls import ThreadCalls, in_loop
from woosh_pure.enums import TaskState
from woosh_pure.hints import HANDLE, Hints
from woosh_pure.motion import action_goal, motion, task
from woosh_pure.motion.motion import OWN_DEFAULT, DefaultTimeout
from woosh_pure.motion.progress import Progress
from woosh_pure.motion.steps import Step
from woosh_pure.outcome import Outcome
from woosh_pure.values.state import RobotStatus

P = TypeVar("P")
logger = get_logger("woosh_pure.aio")
_LOOK_AGAIN = 0.1  # seconds; the end of a goal comes without a call


class _LoopClosed(ConnectionLost):
    """The loop was closed over a task that waits."""


class GoalHandle(Hints, Generic[P]):
    """A goal under way; as `woosh_pure.motion.motion.GoalHandle`, awaited.

    Attributes:
        handle: The threaded one underneath.
        description: The goal in words.
        default_timeout: Default time limit of `wait()`, s; None waits for ever.
        task_id, server: As those of `handle`.
    """

    _hints = HANDLE

    def __init__(self, handle: motion.GoalHandle[P], calls: ThreadCalls) -> None:
        self.handle = handle
        self.description, self.default_timeout = handle.description, handle.default_timeout
        self.task_id, self.server = handle.task_id, handle.server
        self._calls = calls

    def __repr__(self) -> str:
        return f"<aio {repr(self.handle)[1:]}"

    drives = SameProperty[bool](motion.GoalHandle.drives, "handle")
    holds_the_base = SameProperty[bool](motion.GoalHandle.holds_the_base, "handle")
    outcome = SameProperty[Outcome | None](motion.GoalHandle.outcome, "handle")
    done = SameProperty[bool](motion.GoalHandle.done, "handle")
    progress = SameProperty[Progress](motion.GoalHandle.progress, "handle")
    latest_report = SameProperty[P | None](motion.GoalHandle.latest_report, "handle")
    latest_progress = former_attribute("latest_progress", "latest_report")

    def on_progress(self, callback: Callable[[Progress], object]) -> None:
        """Call `callback(progress)` for each report of the chassis, in this loop."""
        self.handle.on_progress(in_loop(callback))

    def on_done(self, callback: Callable[[Outcome], object]) -> None:
        """Call `callback(outcome)` once, when it has ended: at once if it has.

        It is called in this loop.
        """
        self.handle.on_done(in_loop(callback))

    async def reports(self) -> AsyncIterator[P]:
        """The chassis's reports as they come; a slow loop skips to the newest. Ends with the goal."""
        newest: Mailbox[P] = Mailbox(1)

        def put(_: Progress) -> None:
            if (report := self.handle.latest_report) is not None:
                newest.put(report)

        self.handle.on_progress(put)
        known = self.handle.latest_report
        if known is not None and not len(newest):
            newest.put(known)
        try:
            while True:
                # Progress from before the end is still yielded.
                if not len(newest) and self.handle.done and not len(newest):
                    return
                try:
                    report = await newest.get(_LOOK_AGAIN)
                except asyncio.TimeoutError:
                    continue
                yield report
        finally:
            newest.close()

    async def wait(
        self, timeout: float | DefaultTimeout | None = OWN_DEFAULT, *, raises: bool = True
    ) -> Outcome:
        """Wait for the end. Cancelling the task that waits cancels the goal, and waits for the chassis to
        confirm it.

        Args:
            timeout: Seconds; then the goal is cancelled. None waits for ever; left out: `default_timeout`.
            raises: False returns an outcome that is not an arrival instead of raising it.

        Raises:
            GoalFailed: It ended in anything but an arrival; `error.outcome` says how.
            ValueError: `timeout` is negative or NaN.
        """
        loop = asyncio.get_running_loop()

        def look() -> None:
            if loop.is_closed():
                wrong = "{description}: the event loop was closed while it was waited for"
                raise _LoopClosed(say(wrong, description=self.description))

        def wait() -> Outcome:
            try:
                return self.handle.wait(timeout, raises=raises, meanwhile=look)
            except _LoopClosed:
                self._end()
                raise

        return await self._calls.or_end(wait, self._end)

    def __await__(self) -> Generator[Any, None, Outcome]:
        """`outcome = await handle` is `wait()`."""
        return self.wait().__await__()

    async def cancel(self, timeout: float = 5.0) -> Outcome:
        """End it now and wait until the chassis confirms. Begun it completes, also when this task is
        cancelled.

        Returns:
            The outcome: usually cancelled, but arrived when it got there first.

        Raises:
            RosError: The cancellation could not be sent, or was not confirmed in time.
            ValueError: `timeout` is negative or NaN.
        """
        try:
            return await self._calls.finish(lambda: self.handle.cancel(timeout))
        except RecursionError:
            return self.handle.cancel(timeout)  # which needs less stack than another thread

    def _end(self) -> None:
        """Cancel the goal of a cancelled task; a failure is logged, and `close` tries again."""
        try:
            self.handle.cancel(5.0)
        except RosError as error:
            logger.warning("! %s: its task was cancelled, and it may go on: %s", self.description, error)


class TaskHandle(GoalHandle[RobotStatus]):
    """A task under way; as `woosh_pure.motion.task.TaskHandle`, awaited."""

    handle: task.TaskHandle

    state = SameProperty[TaskState](task.TaskHandle.state, "handle")

    async def pause(self) -> None:
        """Hold it; `resume` goes on.

        Raises:
            MotionRefused: The chassis refused.
        """
        await self._calls.finish(self.handle.pause)

    async def resume(self) -> None:
        """Go on after `pause`. Cancelled meanwhile, the task is cancelled."""
        await self._calls.or_end(self.handle.resume, self._end)

    async def interrupt_wait(self) -> None:
        """End the wait the task is in (task state 5). Cancelled meanwhile, the task is cancelled."""
        await self._calls.or_end(self.handle.interrupt_wait, self._end)


class ActionHandle(GoalHandle[Any]):
    """A goal of any action server; as `woosh_pure.motion.action_goal.ActionHandle`, awaited."""

    handle: action_goal.ActionHandle

    result = SameProperty[Any](action_goal.ActionHandle.result, "handle")


class NavigationHandle(ActionHandle):
    """A goal of /move_base under way."""

    handle: action_goal.NavigationHandle


class StepHandle(ActionHandle):
    """A goal of /cmd_vel_control under way."""

    handle: action_goal.StepHandle

    def remaining(self) -> tuple[Step, ...]:
        """The remaining steps, by the last report."""
        return self.handle.remaining()

    async def pause(self) -> None:
        """Hold the move; `resume` sends what remains.

        Raises:
            MotionRefused: It has ended, maybe while the pause was on its way; or the chassis did not confirm.
        """
        await self._calls.finish(self.handle.pause)

    async def resume(self) -> None:
        """Go on after `pause` by sending the remaining steps again, as the interface prescribes.

        Cancelled meanwhile, the move is cancelled.
        """
        await self._calls.or_end(self.handle.resume, self._end)


H = TypeVar("H", bound=GoalHandle[Any])


class Goal(Coroutine[Any, Any, Outcome], Generic[H]):
    """The result of a motion verb. It is sent only when used, once, in one of three ways:

        outcome = await robot.go_to_mark("A1")           # to the end: an arrival, else GoalFailed
        async with robot.go_to_mark("A1") as handle:     # under way; leaving the block cancels it
            async for status in handle.reports(): ...
        handle = await robot.go_to_mark("A1").start()    # under way, and yours to wait for or to cancel

    It is a coroutine, too: `asyncio.create_task(robot.go_to_mark("A1"))`, `group.create_task(...)`.
    Cancelling the task that awaits it, in whichever way, cancels the goal, also one that is only being
    prepared or sent, and waits for the chassis to confirm that.
    """

    def __init__(self, name: str, calls: ThreadCalls, begin: Callable[[], Any], handle: type[H]) -> None:
        self.__name__ = self.__qualname__ = name
        self._calls = calls
        self._begin = begin
        self._kind = handle
        self._used = False
        self._running: Coroutine[Any, Any, Outcome] | None = None
        self._handle: H | None = None

    def __repr__(self) -> str:
        return f"<Goal of {self.__name__}: {self._handle or ('begun' if self._used else 'not begun')}>"

    async def start(self) -> H:
        """Begin it and return its handle. Cancelled meanwhile, nothing is left under way."""
        if self._used:
            raise RuntimeError(
                say("{name}: this goal was begun before; call the verb again", name=self.__name__)
            )
        self._used = True
        self._handle = self._kind(await self._calls.call(self._begin), self._calls)
        return self._handle

    async def _to_the_end(self) -> Outcome:
        handle = await self.start()
        return await handle.wait()

    async def __aenter__(self) -> H:
        return await self.start()

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        handle = self._handle
        if handle is None or handle.done:
            return
        if kind is GeneratorExit:  # the loop was closed over the block
            self._calls.spawn(handle._end)
        elif kind is None:
            await handle.cancel()
        else:
            await self._calls.finish(handle._end)  # the exception of the block has precedence

    # -- a coroutine, as tasks want one

    def __await__(self) -> Generator[Any, None, Outcome]:
        return self._coroutine().__await__()

    def send(self, value: Any) -> Any:
        """As of a coroutine."""
        return self._coroutine().send(value)

    def throw(self, *error: Any) -> Any:
        """As of a coroutine."""
        return self._coroutine().throw(*error)

    def close(self) -> None:
        """As of a coroutine: it is not begun any more."""
        self._used = True
        if self._running is not None:
            self._running.close()

    def _coroutine(self) -> Coroutine[Any, Any, Outcome]:
        if self._running is None:
            self._running = self._to_the_end()
        return self._running

    def __del__(self) -> None:
        if not self._used and self._running is None:
            text = f"{self.__name__} was never awaited: nothing was sent"
            warnings.warn(text, RuntimeWarning, stacklevel=2, source=self)
