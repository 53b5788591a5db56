"""The client's records of its goals: of each that is under way, and of those that it gave up.

A goal is sent once, over one connection. If the server has dropped that connection and the network did not
report it, the goal is lost without any sign: status arrays keep coming without it. actionlib (rospy's and
roscpp's) then waits for ever, because an array may be older than the goal. Here the goal is LOST once a
server has been heard for a while without mentioning it.

Such a goal may still arrive if the connection is alive and TCP retransmits. It must not run without a waiting
client: once a status array lists it, it is cancelled, every second until the server reacts.

The states of a goal and their transitions are `rosproto.protocol.goal_client.GoalMachine`'s. No I/O, no clock
and no lock here: `GoalTracker` passes the times and does the locking.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from rosproto.codec import DynamicMessage
from rosproto.protocol.goal_client import CommState, GoalMachine
from rosproto.protocol.goal_status import GoalStatus

FEEDBACK_KEPT = 100  # messages
_NOT_ARRIVED = (CommState.WAITING_FOR_GOAL_ACK, CommState.WAITING_FOR_CANCEL_ACK)


@dataclass(eq=False, slots=True)
class SentGoal:
    """One goal of a client, from sending it to its end.

    Attributes:
        goal_id: Id on the wire.
        goal: The goal message.
        sent_at: When it was sent, by the client's steady clock.
        receivers: Caller ids of the nodes that were connected to the goal topic then.
        machine: Its communication states.
        ended_at: When a status first said that it has ended, while the result is still to come; else None.
        on_feedback: Called with each feedback message; None to keep the messages only.
        on_transition: Called for each state passed.
        reported: The state that `on_transition` was last called for.
        finished: True when the goal has ended and `on_transition` has returned from its last call.
        feedback: The latest feedback messages that nobody has taken yet.
        feedback_dropped: How many feedback messages were lost on the way to their reader.
    """

    goal_id: str
    goal: DynamicMessage
    sent_at: float
    receivers: frozenset[str]
    machine: GoalMachine = field(init=False)
    ended_at: float | None = None
    on_feedback: Callable[[DynamicMessage], object] | None = None
    on_transition: Callable[[], object] | None = None
    reported: CommState = CommState.WAITING_FOR_GOAL_ACK
    finished: bool = False
    feedback: deque[DynamicMessage] = field(default_factory=lambda: deque(maxlen=FEEDBACK_KEPT))
    feedback_dropped: int = 0

    def __post_init__(self) -> None:
        self.machine = GoalMachine(self.goal_id)

    @property
    def done(self) -> bool:
        """True when nothing will change any more."""
        return self.machine.done

    @property
    def acknowledged(self) -> bool:
        """True when a server has mentioned the goal, so that it has arrived; or it has ended."""
        return bool(self.machine.server) or self.machine.state not in _NOT_ARRIVED

    def keep_feedback(self, message: DynamicMessage) -> bool:
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


AGAIN = 1.0  # seconds between two cancels of a goal that arrived too late
KEEP = 120.0  # seconds; by then every system has given up retransmitting
MAX_GIVEN_UP = 1000

_RUNNING = (GoalStatus.PENDING, GoalStatus.ACTIVE)


class GivenUpGoals:
    """The goals that were given up."""

    def __init__(self) -> None:
        self._given_up: dict[str, tuple[float, float]] = {}  # goal id: forgotten at, cancelled again from

    def give_up(self, goal_id: str, now: float) -> None:
        """Have the goal cancelled if it appears in a status array."""
        if len(self._given_up) >= MAX_GIVEN_UP:
            del self._given_up[next(iter(self._given_up))]
        self._given_up[goal_id] = (now + KEEP, now)

    def too_late(self, mentioned: Mapping[str, DynamicMessage], now: float) -> list[str]:
        """Goals that were given up but run after all, and have to be cancelled now.

        Args:
            mentioned: The actionlib_msgs/GoalStatus entries of a status array, by goal id.
        """
        due = []
        for goal_id, (forget, again) in list(self._given_up.items()):
            status = mentioned.get(goal_id)
            if now >= forget or (status is not None and status.status not in _RUNNING):
                del self._given_up[goal_id]
            elif status is not None and now >= again:
                self._given_up[goal_id] = (forget, now + AGAIN)
                due.append(goal_id)
        return due
