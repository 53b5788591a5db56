"""SentGoal: the client's record of one goal.

The states and their transitions are `rosproto.protocol.goal_client.GoalMachine`'s; kept beside it is what the
client needs to judge by them. No I/O, no clock and no lock: times are handed in, and `GoalTracker` does the
locking.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any

from rosproto.protocol.goal_client import CommState, GoalMachine
from rosproto.time import Time

FEEDBACK_KEPT = 100  # messages
_NOT_ARRIVED = (CommState.WAITING_FOR_GOAL_ACK, CommState.WAITING_FOR_CANCEL_ACK)


class SentGoal:
    """One goal of a client, from sending it to its end.

    Args:
        goal_id: Id on the wire.
        goal: The goal message.
        stamp: Stamp on the wire.
        sent_at: When it was sent, by the client's steady clock.
        receivers: Caller ids of the nodes that were connected to the goal topic then.

    Attributes:
        machine: Its communication states.
        ended_at: When a status first said that it has ended, while the result is still to come; else None.
        on_feedback: Called with each feedback message; None to keep the messages only.
        on_transition: Called for each state passed.
        told: The state that `on_transition` was last called for.
        finished: True when the goal has ended and `on_transition` has returned from its last call.
        feedback: The latest feedback messages that nobody has taken yet.
        feedback_dropped: How many feedback messages were lost on the way to their reader.
    """

    def __init__(
        self, goal_id: str, goal: Any, stamp: Time, sent_at: float, receivers: frozenset[str]
    ) -> None:
        self.goal_id = goal_id
        self.goal = goal
        self.stamp = stamp
        self.sent_at = sent_at
        self.receivers = receivers
        self.machine = GoalMachine(goal_id)
        self.ended_at: float | None = None
        self.on_feedback: Callable[[Any], object] | None = None
        self.on_transition: Callable[[], object] | None = None
        self.told = CommState.WAITING_FOR_GOAL_ACK
        self.finished = False
        self.feedback: deque[Any] = deque(maxlen=FEEDBACK_KEPT)
        self.feedback_dropped = 0

    @property
    def done(self) -> bool:
        """True when nothing will change any more."""
        return self.machine.done

    @property
    def acknowledged(self) -> bool:
        """True when a server has mentioned the goal, so that it has arrived; or it has ended."""
        return bool(self.machine.server) or self.machine.state not in _NOT_ARRIVED

    def keep_feedback(self, message: Any) -> bool:
        """Keep a feedback message for its reader; False when an older one was dropped for it."""
        full = len(self.feedback) == FEEDBACK_KEPT
        self.feedback.append(message)
        return not full

    def waited_for_result(self, now: float) -> float:
        """For how many seconds the result has been awaited since the status said the goal had ended."""
        if self.machine.state is not CommState.WAITING_FOR_RESULT:
            return 0.0
        if self.ended_at is None:
            self.ended_at = now
        return now - self.ended_at
