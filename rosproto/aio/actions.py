"""Action client and server for asyncio: wrappers of the threaded ones.

No thread waits for a goal: the client's thread notifies the loop of feedback and transitions. A server that
becomes silent causes no notification, so a waiting task also checks at intervals.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Generator
from typing import Any

from rosproto.action import ActionClient as ThreadedClient
from rosproto.action import ActionServer as ThreadedServer
from rosproto.action import CommState, GoalStatus
from rosproto.action import GoalHandle as ThreadedHandle
from rosproto.action.types import Part
from rosproto.aio.mailbox import Closed, Mailbox
from rosproto.aio.pool import Pool, notify
from rosproto.aio.same_property import SameProperty
from rosproto.codec import Message
from rosproto.errors import RosTimeout
from rosproto.transport.deadline import Deadline

FEEDBACK_KEPT = 100
LOOK_AGAIN = 0.25  # seconds, as in the threaded handle
SETTLE = 5.0  # seconds for the last callback of a goal to return


class ActionClient:
    """A client of one action server.

    Attributes:
        client: The wrapped threaded client: `name`, `type`.
    """

    def __init__(self, client: ThreadedClient, pool: Pool) -> None:
        self.client = client
        self._pool = pool

    async def wait_for_server(self, timeout: float | None = 5.0) -> None:
        """Wait until a server is running and every connection to it is open.

        Raises:
            RosTimeout: There is none; the text says which part is missing.
        """
        await self._pool.run(lambda: self.client.wait_for_server(timeout))

    async def send_goal(self, goal: Part) -> GoalHandle:
        """Send a goal and follow it; raises as `rosproto.ActionClient.send_goal`.

        Cancelling a task that waits for the goal does not cancel the goal: call `cancel` for that. If the
        task is cancelled during this call, no handle is returned, so the goal is cancelled as well.
        """
        loop, over = asyncio.get_running_loop(), asyncio.Event()
        feedback: Mailbox[Message] = Mailbox(FEEDBACK_KEPT)

        def changed(handle: ThreadedHandle) -> None:
            # Not `handle.done`: it may be true while earlier changes and feedback are still being delivered.
            if handle.state is CommState.DONE:
                feedback.close()
                notify(loop, over.set)

        handle = await self._pool.run(
            lambda: self.client.send_goal(
                goal, feedback=lambda _, message: feedback.put(message), transition=changed
            ),
            dispose=lambda sent: sent.cancel(),  # without a handle, nothing else can cancel it
        )
        return GoalHandle(handle, over, feedback, self._pool)

    def cancel_all(self) -> None:
        """Ask the server to cancel all its goals, also other clients' goals."""
        self.client.cancel_all()

    async def close(self) -> None:
        """Stop following goals; they continue at the server. May be called again."""
        await self._pool.run(self.client.close, always=True)


class GoalHandle:
    """One goal; made by `ActionClient.send_goal`. `await handle` waits for its result.

    Attributes:
        handle: The wrapped threaded handle.
    """

    def __init__(
        self, handle: ThreadedHandle, over: asyncio.Event, feedback: Mailbox[Message], pool: Pool
    ) -> None:
        self.handle = handle
        self._over = over
        self._feedback = feedback
        self._pool = pool

    status = SameProperty[GoalStatus](ThreadedHandle.status, "handle")
    state = SameProperty[CommState](ThreadedHandle.state, "handle")
    text = SameProperty[str](ThreadedHandle.text, "handle")
    done = SameProperty[bool](ThreadedHandle.done, "handle")
    result = SameProperty[Any](ThreadedHandle.result, "handle")

    async def wait(self, timeout: float | None = 60.0) -> Any:
        """Wait for the result, whatever the outcome; see also `status`.

        Raises:
            RosTimeout: The goal has not ended; it continues.
            ConnectionLost: The server cannot be heard any more, or no longer knows the goal.
        """
        deadline = Deadline(timeout)
        while not await self._ended(deadline):
            if deadline.expired:
                raise self._late("result", deadline, timeout)
        # It has ended, or the server is lost: the threaded handle has the result or error.
        return await self._pool.run(lambda: self.handle.wait(SETTLE))

    def __await__(self) -> Generator[object, None, Any]:
        return self.wait(None).__await__()

    async def feedback(self, timeout: float | None = 60.0) -> AsyncIterator[Any]:
        """Iterate over feedback messages until the goal ends; the last 100 are kept for a slow reader.

        Args:
            timeout: Seconds for each message; None waits for ever, though not for a silent server.

        Raises:
            RosTimeout: None came in time; the goal continues.
            ConnectionLost: The server cannot be heard any more.
        """
        deadline = Deadline(timeout)
        while True:
            left = deadline.remaining()
            try:
                message = await self._feedback.get(LOOK_AGAIN if left is None else min(left, LOOK_AGAIN))
            except Closed:
                return
            except asyncio.TimeoutError:
                if (error := self.handle.connection_error) is not None:
                    raise error from None
                if deadline.expired:
                    raise self._late("feedback", deadline, timeout) from None
                continue
            yield message
            deadline = Deadline(timeout)

    def _late(self, what: str, deadline: Deadline, timeout: float | None) -> RosTimeout:
        why = self.handle.why_unfinished(deadline)
        return RosTimeout(why, what=f"{what} of goal {self.handle.goal_id}", seconds=timeout)

    async def _ended(self, deadline: Deadline) -> bool:
        """Wait a little; True if the goal has ended or its server is lost."""
        left = deadline.remaining()
        try:
            await asyncio.wait_for(self._over.wait(), LOOK_AGAIN if left is None else min(left, LOOK_AGAIN))
        except asyncio.TimeoutError:
            return self.handle.connection_error is not None
        return True

    def cancel(self) -> bool:
        """Ask the server to cancel this goal; then wait for its end, which may still be a success."""
        return self.handle.cancel()


class ActionServer:
    """Provides an action.

    Attributes:
        server: The wrapped threaded server: `name`, `type`, `goals`.
    """

    def __init__(self, server: ThreadedServer, pool: Pool) -> None:
        self.server = server
        self._pool = pool

    async def close(self) -> None:
        """Stop providing the action. May be called again."""
        await self._pool.run(self.server.close, always=True)
