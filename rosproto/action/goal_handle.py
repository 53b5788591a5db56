"""GoalHandle: a goal that was sent, while it is under way and after."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from rosproto.errors import ConnectionLost, RosTimeout
from rosproto.protocol.goal_client import CommState, GoalMachine, GoalStatus
from rosproto.time import Time
from rosproto.transport.deadline import Deadline

if TYPE_CHECKING:
    from rosproto.action.client import ActionClient

__all__ = ["GoalHandle"]

FEEDBACK_KEPT = 100
_UNHEARD_OF = (CommState.WAITING_FOR_GOAL_ACK, CommState.WAITING_FOR_CANCEL_ACK)
_LOOK_AGAIN = 0.25  # seconds between looks at how long the server has been silent


class GoalHandle:
    """One goal; made by `ActionClient.send_goal`.

    Its properties may be read from any thread at any time. A goal ends in one of three ways: the server's
    result arrives (`done`, see `status`); the server no longer knows it, or never got it (`done` with status
    LOST); or the server is not heard any more: then it is not done, but `connection_error` says so and the
    waiting methods raise it. Should the server come back, it goes on.

    Attributes:
        goal_id: Id on the wire.
        goal: The goal message.
        sent: Stamp on the wire.
        feedback_dropped: Feedback messages that nobody took in time from `feedback()` (a callback still saw
            them), or that came faster than the callback returned.
    """

    def __init__(
        self,
        client: ActionClient,
        goal_id: str,
        goal: Any,
        sent: Time,
        on_feedback: Callable[[GoalHandle, Any], object] | None,
        on_transition: Callable[[GoalHandle], object] | None,
        carriers: frozenset[str],
    ) -> None:
        self._client = client
        self._machine = GoalMachine(goal_id)
        self._sent_at = client._clock.monotonic()
        self._carriers = carriers  # caller ids that were connected to the goal topic
        self._ended_at: float | None = None  # when a status said so, while the result is still to come
        self._on_feedback = on_feedback
        self._on_transition = on_transition
        self._seen = CommState.WAITING_FOR_GOAL_ACK
        self._finished = False
        self._kept: deque[Any] = deque(maxlen=FEEDBACK_KEPT)
        self.goal_id = goal_id
        self.goal = goal
        self.sent = sent
        self.feedback_dropped = 0

    def __repr__(self) -> str:
        return f"<GoalHandle {self.goal_id} {self.state.name}, {self.status.name}>"

    @property
    def state(self) -> CommState:
        """Where the goal is, seen from here. In a transition callback: the state it was called for."""
        if self._on_transition is not None and self._client._dispatcher.is_current:
            return self._seen
        return self._machine.state

    @property
    def status(self) -> GoalStatus:
        """What the server last said of it."""
        return self._machine.status

    @property
    def text(self) -> str:
        """The server's words that came with the status."""
        return self._machine.text

    @property
    def result(self) -> Any:
        """The result message; None until it arrived, and for a lost goal."""
        return self._machine.result

    @property
    def server(self) -> str:
        """Caller id of the server that took the goal; "" until then."""
        return self._machine.server

    @property
    def acknowledged(self) -> bool:
        """True when a server has mentioned the goal, so that it has arrived; or it has ended."""
        machine = self._machine
        return bool(machine.server) or machine.state not in _UNHEARD_OF

    @property
    def done(self) -> bool:
        """True when nothing will change any more."""
        return self._machine.done

    @property
    def connection_error(self) -> ConnectionLost | None:
        """Why nothing more can be expected just now (a silent server, a closed client), or None."""
        return None if self.done else self._client._why_cut_off(self)

    def wait(self, timeout: float | None = 60.0) -> Any:
        """Wait for the result, whatever the goal's end; look at `status`, too.

        Returns after the transition callback for DONE was called (unless called from a callback).

        Args:
            timeout: Seconds; None waits for ever, though not for a silent server.

        Returns:
            The result message.

        Raises:
            RosTimeout: The goal is still under way; it goes on.
            ConnectionLost: The server is not heard any more, or no longer knows the goal (it was restarted).
        """
        deadline = Deadline(timeout, self._client._clock)
        if not self._wait_for(lambda: self._finished or self._is_over_here(), deadline):
            raise RosTimeout(self._still(deadline), what=f"result of {self._client.name}", seconds=timeout)
        if self._machine.result is None:
            raise ConnectionLost(
                f"{self._client.name}: goal {self.goal_id} is lost: {self.text}",
                peer=self.server or ", ".join(sorted(self._carriers)),
            )
        return self._machine.result

    def feedback(self, timeout: float | None = 60.0) -> Iterator[Any]:
        """Feedback messages until the goal ends. The last 100 are kept for a late or slow reader.

        Args:
            timeout: Seconds for each of them; None waits for ever, though not for a silent server.

        Raises:
            RosTimeout: None came in time; the goal goes on.
            ConnectionLost: The server is not heard any more.
        """
        while True:
            deadline = Deadline(timeout, self._client._clock)
            if not self._wait_for(lambda: bool(self._kept) or self.done, deadline):
                raise RosTimeout(
                    self._still(deadline), what=f"feedback of {self._client.name}", seconds=timeout
                )
            with self._client._changed:
                if not self._kept:
                    return
                message = self._kept.popleft()
            yield message

    def cancel(self) -> bool:
        """Ask the server to cancel this goal; then `wait` for its end, which may still be a success.

        May be called again if the request could have been lost.

        Returns:
            False when that cannot help: the goal has ended, or the server is cancelling it already.

        Raises:
            ConnectionLost: No server is connected to take the request.
        """
        return self._client._cancel(self)

    def give_up(self) -> bool:
        """Take a goal that no server has acknowledged for lost, at once.

        It is cancelled should it reach the server later, as long as the client is open.

        Returns:
            False when it is acknowledged (`cancel` it), or has ended.
        """
        return self._client._give_up(self)

    def _is_over_here(self) -> bool:
        # In a callback the end is known before the callback for it was called; a closed client calls none.
        return self.done and (self._client._dispatcher.is_current or self._client._closed)

    def _wait_for(self, what: Callable[[], bool], deadline: Deadline) -> bool:
        """True when it holds, False when time is up; raises when it cannot come to hold."""
        client = self._client
        with client._changed:
            while not what():
                error = self.connection_error
                if error is not None:
                    raise error
                left = deadline.remaining()
                if left is not None and left <= 0:
                    return False
                client._clock.wait(client._changed, _LOOK_AGAIN if left is None else min(left, _LOOK_AGAIN))
        return True

    def _still(self, deadline: Deadline) -> str:
        if self.done:
            return (
                f"{self._client.name}: goal {self.goal_id} has ended ({self.status.name}), but the "
                f"transition callback for it has not returned after {deadline.seconds:g} s"
            )
        text = f"{self._client.name}: goal {self.goal_id} is still {self.state.name}"
        text += f" after {deadline.seconds:g} s"
        if self.state is CommState.WAITING_FOR_GOAL_ACK:
            return text + "; the server has not mentioned it: it may not have received it, or reject its type"
        return (
            text + f" ({self.status.name}{': ' + self.text if self.text else ''}); cancel it, or wait longer"
        )
