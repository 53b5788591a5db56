"""GoalHandle: a goal that was sent, while it is under way and after."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from rosproto.action.goal_tracker import GoalTracker
from rosproto.action.sent_goal import SentGoal
from rosproto.errors import ConnectionLost, RosTimeout
from rosproto.protocol.goal_client import CommState
from rosproto.protocol.goal_status import GoalStatus
from rosproto.sentence import led, say
from rosproto.transport.deadline import Deadline


class GoalHandle:
    """One goal; made by `ActionClient.send_goal`.

    Its properties may be read from any thread at any time. A goal ends in one of three ways: the server's
    result arrives (`done`, see `status`); the server no longer knows it, or never got it (`done` with status
    LOST); or the server is not heard any more: then it is not done, but `connection_error` says so and the
    waiting methods raise it. If the server comes back, it goes on.

    Attributes:
        goal_id: Id on the wire.
        goal: The goal message.
    """

    def __init__(self, sent: SentGoal, tracker: GoalTracker, write_cancel: Callable[[], None]) -> None:
        self._write_cancel = write_cancel
        self._sent = sent
        self._machine = sent.machine
        self._tracker = tracker
        self.goal_id = sent.goal_id
        self.goal = sent.goal

    def __repr__(self) -> str:
        return f"<GoalHandle {self.goal_id} {self.state.name}, {self.status.name}>"

    @property
    def state(self) -> CommState:
        """The communication state. In a transition callback: the state it was called for."""
        return self._tracker.state(self._sent)

    @property
    def status(self) -> GoalStatus:
        """The status that the server reported last."""
        return self._machine.status

    @property
    def text(self) -> str:
        """The server's text that came with the status."""
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
        return self._sent.acknowledged

    @property
    def done(self) -> bool:
        """True when nothing will change any more."""
        return self._machine.done

    @property
    def connection_error(self) -> ConnectionLost | None:
        """Why the goal cannot progress at present (a silent server, a closed client), or None."""
        return self._tracker.connection_error(self._sent)

    @property
    def feedback_dropped(self) -> int:
        """Number of feedback messages that were not read in time from `feedback()` (the callback still got
        them), or that arrived faster than the callback returned.
        """
        return self._sent.feedback_dropped

    def wait(self, timeout: float | None = 60.0) -> Any:
        """Wait for the result, however the goal ends; check `status`, too.

        Returns after the transition callback for DONE was called (unless called from a callback).

        Args:
            timeout: Seconds; None waits for ever, though not for a silent server.

        Returns:
            The result message.

        Raises:
            RosTimeout: The goal is still under way; it goes on.
            ConnectionLost: The server is not heard any more, or no longer knows the goal (it was restarted).
        """
        deadline = self._tracker.deadline(timeout)
        if not self._tracker.wait_for(self._sent, self._is_over, deadline):
            raise RosTimeout(
                self.why_unfinished(deadline), what=f"result of {self._tracker.name}", seconds=timeout
            )
        if self._machine.result is None:
            raise ConnectionLost(
                led(self._tracker.name, say("goal {id} is lost: {why}", id=self.goal_id, why=say(self.text))),
                peer=self.server or ", ".join(sorted(self._sent.receivers)),
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
        sent, tracker = self._sent, self._tracker
        while True:
            deadline = tracker.deadline(timeout)
            if not tracker.wait_for(sent, lambda: bool(sent.feedback) or sent.done, deadline):
                raise RosTimeout(
                    self.why_unfinished(deadline), what=f"feedback of {tracker.name}", seconds=timeout
                )
            message = tracker.take_feedback(sent)
            if message is None:
                return
            yield message

    def cancel(self) -> bool:
        """Ask the server to cancel this goal; then `wait` for its end, which may still be a success.

        May be called again if the request could have been lost.

        Returns:
            False when that cannot help: the goal has ended, or the server is cancelling it already.

        Raises:
            ConnectionLost: No server is connected to take the request.
        """
        return self._tracker.cancel(self._sent)

    def cancel_at_once(self) -> None:
        """As `cancel`, without waiting, locks or allocations of new resources.

        The goal's state is not checked, and `state` changes only when the server reacts.

        Raises:
            ConnectionLost: No server is connected to take the request.
        """
        self._write_cancel()

    def give_up(self) -> bool:
        """Consider a goal that no server has acknowledged as lost, at once.

        If it reaches the server later, it is cancelled, as long as the client is open.

        Returns:
            False when it is acknowledged (`cancel` it), or has ended.
        """
        return self._tracker.give_up(self._sent)

    def _is_over(self) -> bool:
        # Within a callback the end is known before the callback for DONE has run; a closed client runs none.
        no_more_calls = self._tracker.in_callback or self._tracker.closed
        return self._sent.finished or (self.done and no_more_calls)

    def why_unfinished(self, deadline: Deadline) -> str:
        """Text for a timeout: the event that did not happen before the deadline."""
        if self.done:
            return (
                f"{self._tracker.name}: goal {self.goal_id} has ended ({self.status.name}), but the "
                f"transition callback for it has not returned after {deadline.seconds:g} s"
            )
        text = f"{self._tracker.name}: goal {self.goal_id} is still {self.state.name}"
        text += f" after {deadline.seconds:g} s"
        if self.state is CommState.WAITING_FOR_GOAL_ACK:
            return text + "; the server has not mentioned it: it may not have received it, or reject its type"
        return (
            text + f" ({self.status.name}{': ' + self.text if self.text else ''}); cancel it, or wait longer"
        )
