"""Collects the facts for and against moving: faults, refusals, other clients' goals. Thread-safe."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Collection
from functools import partial
from typing import Any

import rosproto
from rosproto.codec import DynamicMessage
from rosproto.sentence import say
from woosh_pure.connection.call_scope import current
from woosh_pure.connection.connection import Connection
from woosh_pure.errors import MotionRefused
from woosh_pure.faults import ActiveFaults, Faults, StatusCode
from woosh_pure.feed.feed import Feed
from woosh_pure.feed.feeds import Feeds
from woosh_pure.outcome import Outcome, OutcomeKind
from woosh_pure.readiness.assessment import Refusals, assess, lacks_code, status_shows_fitness, triggered_keys
from woosh_pure.reasons import Readiness
from woosh_pure.values import RobotStatus
from woosh_pure.values.messages import message_type

_ACTIONS = ("/move_base", "/cmd_vel_control")
_UNDER_WAY = (0, 1, 6, 7)  # actionlib_msgs/GoalStatus: pending, active, preempting, recalling
_FIRST_STATUS = 0.5  # seconds: a server sends its status 5 times a second
_STATUS_STALE = 3.0


class OtherGoals:
    """Goals of other clients on the action servers that move the base, read from the servers' own status.

    A goal's id begins with the name of the node that sent it; roscpp, rospy and rosproto all form ids this
    way. Subscribes on first use; safe from any thread.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._own_name = ""
        self._heard: dict[str, tuple[float, tuple[str, ...]]] = {}
        self._opened = False

    def listen(self, node: rosproto.Node) -> None:
        """Subscribe to the status of the servers; the first call waits briefly for the first status."""
        with self._lock:
            opened, self._opened = self._opened, True
        if opened:
            return
        from rosproto.transport import Deadline  # lazy: this module must be importable without sockets

        self._own_name = node.name
        status = message_type("actionlib_msgs/GoalStatusArray")
        subscribers = [
            node.subscriber(f"{name}/status", status, callback=partial(self.receive, name), queue_size=1)
            for name in _ACTIONS
        ]
        deadline = Deadline(_FIRST_STATUS)
        while not deadline.expired and not all(
            name in self._heard or all(link.last_error for link in subscriber.stats())
            for name, subscriber in zip(_ACTIONS, subscribers, strict=True)
        ):
            time.sleep(0.01)

    def receive(self, action: str, message: DynamicMessage) -> None:
        """Take in one actionlib_msgs/GoalStatusArray."""
        active = tuple(s.goal_id.id for s in message.status_list if s.status in _UNDER_WAY)
        with self._lock:
            self._heard[action] = (time.monotonic(), active)

    def active(self) -> list[tuple[str, str]]:
        """(client, action) of every goal under way that is not ours; `ROBOT_ITSELF` for the robot's tasks."""
        now = time.monotonic()
        with self._lock:
            heard = [(action, ids) for action, (at, ids) in self._heard.items() if now - at < _STATUS_STALE]
        owners = [(_client_of(goal_id), action) for action, ids in heard for goal_id in ids]
        return [(who, what) for who, what in owners if who != self._own_name]


def _client_of(goal_id: str) -> str:
    """The node in an id "<node>-<number>-<time>"; the id itself when it has another form."""
    name, _, rest = goal_id.partition("-")
    return name if rest else goal_id


_CODE_FOLLOWS = 0.3  # seconds after /robot_status within which the /status_code of the same fault comes
_STALE = 30.0  # seconds after which /battery may be out of date


class ReadinessState:
    """Collects the facts for the `Readiness` of one `Chassis`.

    Args:
        connection: Its node listens to the goals of other clients.
        feeds: The source of states and status codes.
        own_tasks: Return the ids of our own tasks, which do not speak against moving.
        require_not_over: Raise if no motion can begin any more.

    Attributes:
        other_goals: Known goals of other clients.
        refusals: The last refusal of the chassis, until its cause is shown to be over.
    """

    def __init__(
        self,
        connection: Connection,
        feeds: Feeds,
        *,
        own_tasks: Callable[[], Collection[int]],
        require_not_over: Callable[[], object],
    ) -> None:
        self._connection = connection
        self._battery, self._status, self._status_code, self._inputs, self._velocity = (
            feeds.get(name) for name in ("battery", "status", "status_code", "inputs", "velocity")
        )
        self._own_tasks = own_tasks
        self._require_not_over = require_not_over
        self._lock = threading.Lock()
        self._faults = ActiveFaults()
        self._fault_lock = threading.Lock()
        self._watching = False
        self._has_moved = False
        self._links: frozenset[object] = frozenset()  # of /robot_status, when it was looked at last
        self.other_goals = OtherGoals()
        self.refusals = Refusals()

    def _on_status_code(self, code: StatusCode) -> None:
        feed = self._status_code
        reported = next((one for one in reversed(feed.known_history) if one.value is code), None)
        header = {} if reported is None else reported.message._connection_header or {}
        links = frozenset(link for link in feed.links if link.node == header.get("callerid"))
        with self._fault_lock:
            self._faults.receive(code.code, links or feed.links)
        self.refusals.receive(code)

    def active_faults(self) -> Faults:
        """The active faults received since this Chassis began to listen, and whether there are no others."""
        self._listen(self._status, self._status_code)
        status, outdated = self._status_known()
        faults, _ = self._known_faults(status, outdated)
        return Faults(faults, None if status is None or outdated else status.robot_state)

    def readiness(self) -> Readiness:
        """The known reasons against moving; the first call waits until its links are connected."""
        if (scope := current()) is not None:
            scope.require_wanted("readiness")  # `wait_until_ready` calls this repeatedly
        self._listen(self._battery, self._status, self._status_code, self._inputs)
        self.other_goals.listen(self._connection.open_node())
        return self.explained_readiness()

    def explained_readiness(self) -> Readiness:
        """As `known_readiness`, after the code of a fault that /robot_status has only just reported.

        The chassis sends both at once, on two links, in either order. Without the code the reason would be
        "the robot reports a fault" in place of, say, "the emergency stop is pressed". Waits 0.3 s at most.
        """
        while self.awaits_code(readiness := self.known_readiness()):
            time.sleep(0.01)
        return readiness

    def awaits_code(self, readiness: Readiness | None) -> bool:
        """Whether a fault without a code is so recent that the code may still come; never waits."""
        if readiness is None or not lacks_code(readiness) or self._status.in_callback:
            return False
        status = self._status.known
        return status is not None and status.age < _CODE_FOLLOWS

    def known_readiness(self) -> Readiness:
        """As `readiness`, from the messages received so far. Never waits, so a drive may call it any time."""
        battery, inputs = self._battery.known, self._inputs.known
        charging = None if battery is None or battery.age > _STALE else battery.value.charging
        status, outdated = self._status_known()
        faults, before = self._known_faults(status, outdated)
        return assess(
            status,
            faults,
            charging,
            self._own_tasks(),
            self.other_goals.active(),
            faults_before=before,
            keys=() if inputs is None else triggered_keys(inputs.value),
            refusals=self.refusals.reasons(),
            link_lost=outdated,
            has_moved=self._has_moved,
        )

    def _status_known(self) -> tuple[RobotStatus | None, bool]:
        """The last /robot_status, and whether it may be out of date; never waits."""
        self._look_at_links(self._status.links)
        reading = self._status.known
        if reading is None:
            return None, False
        if status_shows_fitness(reading.value):
            self.refusals.end_before(reading.received)
        return reading.value, self._status.outdated

    def _look_at_links(self, up: frozenset[object]) -> None:
        """Discard facts learned by moving if a lost link shows that the robot may have restarted."""
        before, self._links = self._links, up or self._links
        if not before <= up:
            self._has_moved = False
            self.refusals.doubt()

    def _known_faults(
        self, status: RobotStatus | None, outdated: bool
    ) -> tuple[tuple[StatusCode, ...], tuple[StatusCode, ...]]:
        """Active faults, and faults that may be over; never waits."""
        with self._fault_lock:
            self._faults.keep_links(self._status_code.links)
            if status is not None and not outdated and status_shows_fitness(status):
                self._faults.forget_before()
            return self._faults.active, self._faults.before

    def note_outcome(self, outcome: Outcome, *, drives: bool, reported: bool) -> None:
        """Remember how a goal ended, for `readiness`.

        Args:
            outcome: How it ended.
            drives: Whether the goal moves the base.
            reported: Whether /robot_status reported the end, which also makes the robot's state known.
        """
        if not drives:
            return
        if outcome.arrived:
            self._has_moved = True
            self.refusals.end()
        elif outcome.kind in (OutcomeKind.FAILED, OutcomeKind.REJECTED):
            self._has_moved = False
            status = self._status_known()[0] if reported else None
            why = outcome.text or "no reason given"
            self.refusals.note(
                say("the last motion was not carried out ({what}: {why})", what=outcome.description, why=why),
                time.monotonic(),
                None if status is None else status.robot_state,
            )

    def _listen(self, *feeds: Feed[Any]) -> None:
        """Subscribe and start tracking active faults; once this returns, no code is missed."""
        for feed in feeds:  # all of them before the first wait, so that they connect at the same time
            feed.open()
        with self._lock:
            watching, self._watching = self._watching, True
        if not watching:
            self._status_code.on(self._on_status_code)
        for feed in feeds:  # also those that another thread has opened
            feed.connect()

    def require_ready(self, what: str, check: bool) -> None:
        """Refuse if a known reason blocks every motion; if none is known, the chassis decides.

        Raises:
            MotionRefused: With the readiness.
        """
        self._connection.require_open()
        self._require_not_over()
        self._listen(self._battery, self._status, self._status_code, self._velocity)
        readiness = self.explained_readiness()
        if check and readiness.refuses:
            raise MotionRefused(say("{what} refused, nothing was sent", what=what), readiness=readiness)
