"""Why the chassis would not move: `ReadinessState` collects the facts, `assess` derives the reasons.

The sources are `/robot_status`, `/status_code`, `/battery`, `/IO_input` and the states of the action servers.
The chassis is never probed, because every possible probe has side effects:

- `/exec_task` replies with the state of the robot, but each of its commands runs, pauses, resumes or ends a
  task, and what the chassis does with an unknown command or task id is not documented.
- A goal of zero length on `/cmd_vel_control` or `/move_base` is not harmless either. An action server of this
  kind ends its current goal when a new one comes, so the probe would end a task of the robot itself or of
  another client. It may make the robot leave the charger, and the reply to an empty list of steps is not
  documented.
"""

from __future__ import annotations

import math
import re
import threading
import time
from collections.abc import Callable, Collection, Iterable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import rosproto
from rosproto.codec import DynamicMessage
from rosproto.errors import LocalProtocolError, RosTimeout
from rosproto.logs import get_logger
from rosproto.sentence import say
from woosh_pure.connection.call_scope import current
from woosh_pure.connection.connection import Connection
from woosh_pure.enums import RobotMode, RobotState, WorkMode
from woosh_pure.errors import MotionRefused
from woosh_pure.faults import ActiveFaults, Department, FaultLevel, Faults, StatusCode, decode_status_code
from woosh_pure.feed.feed import Feed, Feeds
from woosh_pure.outcome import Outcome, OutcomeKind
from woosh_pure.readiness.robot_facts import FAULT, LOST, MANUAL, MAPPING, with_robot_facts
from woosh_pure.reasons import Readiness, Reason, ReasonKey
from woosh_pure.values.messages import message_type
from woosh_pure.values.state import RobotStatus

if TYPE_CHECKING:
    from woosh_pure.robot_api.background import Background
    from woosh_pure.robot_api.values import DeviceFacts

_log = get_logger("woosh_pure.readiness")
_CODE = re.compile(r"(?<!\d)\d{12}(?!\d)")
_STOPPED = (RobotState.FAULT, RobotState.MAPPING)
_SAYS_NOTHING = (None, RobotState.UNDEFINED, RobotState.UNINITIALISED)


@dataclass(frozen=True, slots=True)
class _Refusal:
    at: float
    reason: Reason
    sources: frozenset[tuple[int, int, int, int]]


class Refusals:
    """The newest refusal or failure of a motion, remembered until its cause is shown to be over.

    A cause from before we connected (a pressed emergency stop, a bumper that was hit) may never appear on a
    topic, but the chassis then refuses motions. So the refusal is remembered, and readiness lists it as a
    reason. Safe from any thread.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._last: _Refusal | None = None

    def note(self, text: str, at: float, state: RobotState | None = None) -> None:
        """Remember that a motion was refused or has failed.

        Args:
            text: Which motion, and the chassis's reason.
            at: When, by the monotonic clock.
            state: The robot's state reported along with it; None if it was not.
        """
        severe = [code for code in _codes(text) if code.level is FaultLevel.SEVERE]
        blocking = bool(severe) or state in _STOPPED
        doubt = not blocking and state in _SAYS_NOTHING
        reason = Reason(ReasonKey.REFUSED, text, blocking, doubt)
        with self._lock:
            self._last = _Refusal(at, reason, frozenset(code.source for code in severe))

    def end(self) -> None:
        """Forget the refusal: the robot has moved since."""
        with self._lock:
            self._last = None

    def end_before(self, moment: float) -> None:
        """Forget a refusal from before this moment, at which the robot reported that it is over."""
        with self._lock:
            if self._last is not None and self._last.at < moment:
                self._last = None

    def doubt(self) -> None:
        """Mark the cause as possibly over: the robot may have been restarted."""
        with self._lock:
            if self._last is not None:
                self._last = replace(self._last, reason=self._last.reason.doubted())

    def receive(self, code: StatusCode) -> None:
        """Take in a status code; one that ends a fault also ends the refusal because of it."""
        if not code.known or code.level is not FaultLevel.NORMAL:
            return
        depth = 4 if code.submodule else 3
        with self._lock:
            last = self._last
            if last is not None and any(s[:depth] == code.source[:depth] for s in last.sources):
                self._last = None

    def reasons(self) -> tuple[Reason, ...]:
        """The remembered refusal as reasons, for a `Readiness`."""
        with self._lock:
            return () if self._last is None else (self._last.reason,)


def _codes(text: str) -> list[StatusCode]:
    return [decode_status_code(int(number)) for number in _CODE.findall(text)]


NOT_HEARD = (
    "no /robot_status heard yet (it is sent on change only), so an earlier emergency stop, fault or "
    "mode is not known"
)
LINK_LOST = "the connection to the publisher of /robot_status has broken since: its value may be out of date"
BEFORE = "{fault}; it was reported before the connection to its publisher broke: it may be over"
STATE_UNDEFINED = "the robot does not report its state"
KEY_TRIGGERED = (
    "key {number} of the chassis is triggered (/IO_input): it may be the emergency stop; which key is which "
    "is not documented"
)


ROBOT_ITSELF = "/ros_interface"
"""The chassis's own node that carries out tasks, which is a client of the action servers."""


def assess(
    status: RobotStatus | None,
    faults: Iterable[StatusCode],
    charging: bool | None = None,
    own_tasks: Collection[int] = (),
    other_goals: Iterable[tuple[str, str]] = (),
    *,
    faults_before: Iterable[StatusCode] = (),
    keys: Collection[int] = (),
    refusals: Iterable[Reason] = (),
    link_lost: bool = False,
    has_moved: bool = False,
    robot: DeviceFacts | None = None,
    silent: float | None = None,
) -> Readiness:
    """Collect the known reasons against moving, and the unknown facts; the cause comes first.

    Args:
        status: The last /robot_status; None if none was received (it is published on change only).
        faults: Active faults.
        charging: By /battery; None if none was received.
        own_tasks: Ids of the tasks that this client started.
        other_goals: Other clients with a running goal: (client, action).
        faults_before: Faults received over links that have broken since; they may be over.
        keys: Numbers of the chassis's keys that /IO_input shows as triggered.
        refusals: Refusals and failures that are not known to be over.
        link_lost: The link of /robot_status has broken since its last message, which then blocks no longer.
        has_moved: One of our motions has arrived, so nothing stopped the robot at that time, and every change
            since then was reported.
        robot: What the robot says by its Robot API; None if that is not known.
        silent: Seconds for which a topic that is sent all the time was not heard; None if it is.
    """
    from_faults = [_from_fault(fault) for fault in faults]
    reasons: list[Reason] = []
    if status is not None:
        told_by_status = _from_status(status, charging, own_tasks)
        if any(reason.blocking for reason in from_faults):  # they name the fault
            told_by_status = [reason for reason in told_by_status if reason.key is not ReasonKey.FAULT]
        reasons += [reason.doubted() for reason in told_by_status] if link_lost else told_by_status
    elif not has_moved:
        reasons.append(Reason(ReasonKey.UNKNOWN, NOT_HEARD, False, doubt=True))
    if link_lost:
        reasons.append(Reason(ReasonKey.LINK_LOST, LINK_LOST, False, doubt=True))
    elif silent is not None:
        text = say(
            "nothing was heard from the robot for {seconds:.0f} s: its state may be out of date",
            seconds=silent,
        )
        reasons.append(Reason(ReasonKey.SILENT, text, False, doubt=True))
    reasons += from_faults
    reasons += [
        replace(_from_fault(fault), text=say(BEFORE, fault=fault)).doubted() for fault in faults_before
    ]
    reasons += [
        _other_goal(*other)
        for other in other_goals
        if other[0] != ROBOT_ITSELF
        or (status is None and not own_tasks)  # else another reason names its task
    ]
    reasons += [Reason(ReasonKey.CHASSIS_KEY, say(KEY_TRIGGERED, number=key), False) for key in keys]
    reasons = with_robot_facts(reasons, robot)
    blocking_keys = {reason.key for reason in reasons if reason.blocking}
    reasons += [reason for reason in refusals if not blocking_keys]  # otherwise the state is more exact
    return Readiness(tuple(sorted(reasons, key=_order)))


def _order(reason: Reason) -> tuple[bool, bool, bool]:
    """Sort key: a pressed button first (it explains the rest), then blocking reasons, then unknown facts."""
    pressed = reason.key in (ReasonKey.EMERGENCY_STOP, ReasonKey.BUMPER)
    return not pressed, not reason.blocking, not reason.doubt


def lacks_code(readiness: Readiness) -> bool:
    """Whether a fault is known by the robot's state only, so that no status code says which one."""
    return _OF_STATE[RobotState.FAULT] in readiness.reasons


def status_shows_fitness(status: RobotStatus) -> bool:
    """Whether the state shows that nothing stops the robot, so that earlier causes are over."""
    automatic = status.robot_mode not in (RobotMode.MANUAL, RobotMode.MAINTENANCE)
    return automatic and status.robot_state in _FIT


_FIT = (RobotState.IDLE, RobotState.PARKING, RobotState.IN_TASK, RobotState.CHARGING)


def triggered_keys(inputs: DynamicMessage) -> tuple[int, ...]:
    """Numbers of the chassis's own keys that a woosh_msgs/IOs shows as triggered; () without one."""
    lines = () if inputs is None else inputs.IOs
    return tuple(int(line.id) for line in lines if line.module == _KEYS_MODULE and line.status == _TRIGGERED)


_KEYS_MODULE, _TRIGGERED = 1, 1  # woosh_msgs/IO: module 0x01 chassis keys, status 1 triggered


_OF_STATE = {
    # States that say nothing about faults and buttons are doubts.
    RobotState.UNINITIALISED: Reason(ReasonKey.NOT_LOCALISED, LOST, False, doubt=True),
    RobotState.UNDEFINED: Reason(ReasonKey.UNKNOWN, STATE_UNDEFINED, False, doubt=True),
    RobotState.FAULT: Reason(ReasonKey.FAULT, FAULT),
    RobotState.MAPPING: Reason(ReasonKey.MAPPING, MAPPING),
}


def _from_status(status: RobotStatus, charging: bool | None, own_tasks: Collection[int]) -> list[Reason]:
    reasons = []
    if status.robot_mode in (RobotMode.MANUAL, RobotMode.MAINTENANCE):
        reasons.append(
            Reason(
                ReasonKey.MANUAL_MODE,
                say(MANUAL, mode=status.robot_mode),
            )
        )
    if status.work_mode is WorkMode.DEPLOYMENT:
        reasons.append(
            Reason(ReasonKey.NOT_IN_TASK_MODE, "the robot is in deployment mode; tasks need task mode", False)
        )
    if status.robot_state in _OF_STATE:
        reasons.append(_OF_STATE[status.robot_state])
    if not status.task_state.is_final and status.task_state.value > 0:
        reasons.append(_task_under_way(status, own_tasks))
    if charging and status.robot_state is not RobotState.CHARGING:
        reasons.append(
            Reason(ReasonKey.CHARGING_CABLE, "the battery is charging without a task; unplug the cable")
        )
    return reasons


def _other_goal(client: str, action: str) -> Reason:
    if client == ROBOT_ITSELF:
        text = say(
            "the robot has a task of another client, or of its own, under way on {action}", action=action
        )
    else:
        text = say("{client} has a goal of its own under way on {action}", client=client, action=action)
    return Reason(ReasonKey.OTHER_CLIENT, text, False)


def _task_under_way(status: RobotStatus, own_tasks: Collection[int]) -> Reason:
    if status.task_id in own_tasks:
        return Reason(
            ReasonKey.BUSY,
            say("our own task {id} is {state}", id=status.task_id, state=status.task_state),
            False,
        )
    text = say(
        "task {id} of another client (or of the robot itself) is {state}",
        id=status.task_id,
        state=status.task_state,
    )
    return Reason(ReasonKey.OTHER_CLIENT, text, False)


_KEYS = {
    (Department.ELECTRICAL, 2, 1): ReasonKey.EMERGENCY_STOP,
    (Department.ELECTRICAL, 2, 2): ReasonKey.BUMPER,
    (Department.SYSTEM, 1, 3): ReasonKey.NOT_LOCALISED,
}


def _from_fault(fault: StatusCode) -> Reason:
    key = _KEYS.get((fault.department, fault.module, fault.submodule), ReasonKey.FAULT)
    if fault.code == 140201000032:
        key = ReasonKey.NO_MAP
    # Only severe codes (emergency stop, bumper, broken hardware) block every motion; others may block one
    # kind.
    return Reason(key, str(fault), fault.level is FaultLevel.SEVERE)


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
_SILENT = 3.0  # seconds without /odom_twist, which is sent many times a second
_FIRST_FACTS, _FACTS_STALE = (
    0.3,
    5.0,
)  # seconds to wait for the first answer of the Robot API; and its validity


class ReadinessState:
    """Collects the facts for the `Readiness` of one `Chassis`.

    Args:
        connection: Its node listens to the goals of other clients.
        feeds: The source of states and status codes.
        own_tasks: Return the ids of our own tasks, which do not speak against moving.
        require_not_over: Raise if no motion can begin any more.
        robot_facts: What the robot says by its Robot API; None if that is not asked.

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
        robot_facts: Background[DeviceFacts] | None = None,
    ) -> None:
        self._connection = connection
        self._robot_facts = robot_facts
        self._battery, self._status, self._status_code, self._inputs, self._velocity = (
            feeds.get(name) for name in ("battery", "status", "status_code", "inputs", "velocity")
        )
        self._own_tasks = own_tasks
        self._require_not_over = require_not_over
        self._lock = threading.Lock()
        self._faults = ActiveFaults()
        self._fault_lock = threading.Lock()
        self._watching = False
        self._has_moved = self._has_looked = False
        self._since = math.inf  # when readiness was asked for first
        self._links: frozenset[object] = frozenset()  # of /robot_status, when it was looked at last
        self.other_goals = OtherGoals()
        self.refusals = Refusals()

    def _on_status_code(self, code: StatusCode) -> None:
        feed = self._status_code
        # The reading of this very code: its header names the node that sent it.
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
        self._listen(self._battery, self._status, self._status_code, self._inputs, self._velocity)
        self.other_goals.listen(self._connection.open_node())
        if self._robot_facts is not None:
            self._robot_facts.want(_FIRST_FACTS)
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
        battery, inputs, velocity = self._battery.known, self._inputs.known, self._velocity.known
        silent = 0.0
        if velocity is not None or self._velocity.links:
            silent = time.monotonic() - max(self._since, velocity.received if velocity else 0.0)
        charging = None if battery is None or battery.age > _STALE else battery.value.charging
        status, outdated = self._status_known()
        faults, before = self._known_faults(status, outdated)
        asked = self._robot_facts
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
            robot=None if asked is None or asked.age > _FACTS_STALE else asked.answer,
            silent=silent if silent >= _SILENT else None,
        )

    def _status_known(self) -> tuple[RobotStatus | None, bool]:
        """The last /robot_status, and whether it may be out of date; never waits."""
        self._look_at_links(self._status.links)
        reading, outdated = self._status.known, self._status.outdated
        if reading is None:
            return None, False
        if status_shows_fitness(reading.value):
            self.refusals.end_before(reading.received)
        return reading.value, outdated

    def _look_at_links(self, up: frozenset[object]) -> None:
        """Discard facts learned by moving if a lost link shows that the robot may have restarted."""
        # While none is up, those of before are kept, to be compared with those that come up again.
        before, self._links = self._links, up or self._links
        if not before <= up:
            self._has_moved = False
            self.refusals.doubt()

    def _known_faults(
        self, status: RobotStatus | None, outdated: bool
    ) -> tuple[tuple[StatusCode, ...], tuple[StatusCode, ...]]:
        """Active faults, and faults that may be over; never waits."""
        fit = status is not None and not outdated and status_shows_fitness(status)
        with self._fault_lock:
            self._faults.keep_links(self._status_code.links)
            if fit:
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
            self._since = min(self._since, time.monotonic())
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
        self._look_for_motion(what)
        readiness = self.explained_readiness()
        if check and readiness.refuses:
            raise MotionRefused(say("{what} refused, nothing was sent", what=what), readiness=readiness)

    def _look_for_motion(self, what: str) -> None:
        """Log, before the first motion of this Chassis, that the robot moves already."""
        looked, self._has_looked = self._has_looked, True
        if looked or not self._velocity.links:
            return
        with suppress(RosTimeout, LocalProtocolError):  # a callback of the velocity cannot wait for it
            if not self._velocity.wait(0.2, new=False).is_standing():
                text = "the robot moves already, by another client or a person; only one should command it"
                _log.warning("! %s: %s", what, say(text))
