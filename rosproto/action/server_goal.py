"""ServerGoal: the handle that a server's handler has of one goal."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from rosproto.protocol.goal_server import GoalRecord, GoalStatus
from rosproto.time import Time

__all__ = ["ServerGoal"]


class ServerGoal:
    """What the handler of an `ActionServer` is called with. All methods may be called from any thread.

    Attributes:
        id: Goal id on the wire.
        stamp: When the client says it sent the goal.
        goal: The goal message.
        client: Caller id of the node that sent it.
    """

    def __init__(
        self,
        record: GoalRecord,
        goal: Any,
        stamp: Time,
        client: str,
        *,
        cancel: threading.Event,
        publish_feedback: Callable[[Any], None],
        end: Callable[[str, Any, str], None],
    ) -> None:
        self._record = record
        self._cancel = cancel
        self._publish_feedback = publish_feedback
        self._end = end
        self.id = record.goal_id
        self.stamp = stamp
        self.goal = goal
        self.client = client

    def __repr__(self) -> str:
        return f"<ServerGoal {self.id} {self.status.name}>"

    @property
    def status(self) -> GoalStatus:
        """Status of the goal."""
        return self._record.status

    @property
    def cancel_requested(self) -> bool:
        """True when work should stop: a client cancelled it, a newer goal replaces it, the server closes."""
        return self._cancel.is_set()

    def wait_for_cancel(self, timeout: float) -> bool:
        """Pause for `timeout` seconds, or until `cancel_requested`; returns that."""
        return self._cancel.wait(timeout)

    def publish_feedback(self, feedback: Any) -> None:
        """Publish the progress: a feedback message, or a dict of its fields.

        Raises:
            LocalProtocolError: The goal has ended.
            CodecError: It is not this action's feedback.
        """
        self._publish_feedback(feedback)

    def succeed(self, result: Any = None, text: str = "") -> None:
        """End the goal: done.

        Args:
            result: Result message, or a dict of its fields; None for one with default values.
            text: Sent with it, for people.

        Raises:
            LocalProtocolError: It has ended already.
        """
        self._end("succeed", result, text)

    def abort(self, result: Any = None, text: str = "") -> None:
        """End the goal: it cannot be done. Arguments and errors as for `succeed`."""
        self._end("abort", result, text)

    def preempted(self, result: Any = None, text: str = "") -> None:
        """End the goal: it was cancelled. Arguments and errors as for `succeed`."""
        self._end("cancel", result, text)
