"""`ApiState`: the robot as the Robot API shows it, kept from its topics, and the pushes to clients.

Messages arrive in the node's threads and are kept as parts of values by row and type. One thread makes the
pushes: the values of a type that changed, once for all clients, PoseSpeed and ScannerData at a limited rate.
A client that reads slowly gets the newest value of each type.
"""

from __future__ import annotations

import json
import threading
import time
from collections import deque
from collections.abc import Callable, Collection, Hashable, Mapping
from contextlib import closing
from functools import partial
from typing import TYPE_CHECKING

from rosproto.bounded_cache import BoundedCache
from rosproto.errors import RosError
from rosproto.gateway import Access, GatewayLimits, GatewayState, MessageEvent, Refused, SharedSubscription
from rosproto.logs import get_logger
from rosproto.node import Node
from rosproto.sentence import shown
from rosproto.watchdog import Watchdog
from woosh_pure.api_server.commands import Commands
from woosh_pure.api_server.site import RobotSite
from woosh_pure.enums import TaskState
from woosh_pure.faults import ActiveFaults, FaultLevel
from woosh_pure.firmware.versions import firmware
from woosh_pure.interface.table import row as interface_row
from woosh_pure.lease import ChassisLease
from woosh_pure.motion.steps import MAX_SPEED, MAX_TURN_RATE
from woosh_pure.robot_api import wire
from woosh_pure.robot_api.commands import to_ros
from woosh_pure.robot_api.translate import COUNT, PAIRS, ROBOT, SECTIONS, operation_state, path_driven, to_api
from woosh_pure.robot_api.wire import Values
from woosh_pure.values.messages import message_type
from woosh_pure.velocity.shaper import DriveLimits

if TYPE_CHECKING:
    from woosh_pure.api_server.session import ApiSession

_log = get_logger("woosh_pure.api_server")

SCAN, SCANNER, PLAN = "/scan", ROBOT + "ScannerData", ROBOT + "PlanNavPath"
EVENT = COUNT + "StatusCode"
PARAMETERS = "/driver_base/parameter"
TYPES = {row: interface_row(row).type for row in (*(pair.row for pair in PAIRS), PARAMETERS)}
ROWS = tuple(row for row in TYPES if row != SCAN)
OPTIONAL = {"/odometer", "/move_base/global_plan"}  # a type is known without these rows
SILENT = {"/move_base/global_plan", "/status_code", PARAMETERS}  # not waited for at the start
AGING = {"/movebase_pose2d", "/odom_twist"}  # sent all the time, so an old one is not the present one
MAX_AGE = 5.0
START_SECONDS = 1.5  # that the start waits for each topic's first message: a first client sees them all
SCAN_SECONDS = 2.0  # that a request waits for a scan
PLAN_SECONDS = 5.0
MAX_LINEAR, MAX_ANGULAR = 1.0, 1.0  # m/s, rad/s, where the chassis tells no limits
KEPT, MAX_SOURCES = 50, 1000  # events and tasks; parts of the robot whose last code is known
PERIODS = {ROBOT + "PoseSpeed": 0.1, SCANNER: 0.2}
"""Seconds between two pushes of a type; the others are pushed with each change."""
CHANGED_BY = {row: {pair.type_name for pair in PAIRS if pair.row == row} for row in TYPES}
"""By row: the types that may change with its messages; those that follow from several are added here."""
for _name in ("OperationState", "NavPath", "DeviceState", "HardwareState"):
    CHANGED_BY["/robot_status"].add(ROBOT + _name)
    CHANGED_BY["/status_code"].add(ROBOT + _name)
CHANGED_BY["/status_code"].add(COUNT + "AbnormalCodes")
CHANGED_BY["/odom_twist"].add(ROBOT + "NavPath")
_ENDS = {TaskState.COMPLETED: 1, TaskState.FAILED: 2, TaskState.CANCELLED: 3}  # count.Task.State
_NOTHING: Mapping[str, Values] = {}


def is_command(type_name: object) -> bool:
    """Whether it is the type of a request that does more than read."""
    request = wire.requests().get(type_name) if isinstance(type_name, str) else None
    return request is not None and request.kind != "read"


def asks_robot(type_name: object) -> bool:
    """Whether a request may wait for the robot, so that what comes after it is read meanwhile."""
    return is_command(type_name) or type_name in (SCANNER, PLAN)


class ApiState(GatewayState):
    """What the sessions of one server share; arguments as of `RobotApiServer`.

    Raises:
        RosError: The topics cannot be subscribed.
    """

    def __init__(
        self,
        node: Node,
        access: Access,
        limits: GatewayLimits,
        watchdog: Watchdog | None,
        robot_id: int,
        site: RobotSite | None,
        lease: ChassisLease | None,
        *,
        share: bool,
    ) -> None:
        super().__init__(node, "robot-api", access, limits, watchdog)
        self.commands = Commands(self, lease, share=share)
        self._robot_id = robot_id
        self._site = site
        self._answers: dict[str, Callable[[Values], Values]] = {
            SCANNER: lambda _: self._newest_scan(),
            PLAN: self._plan,
            **({ROBOT + "CountData": self._statistics, **site.answers()} if site is not None else {}),
        }
        self._began = int(time.time())
        self._news = threading.Condition()
        self._latest: dict[str, MessageEvent] = {}  # by row
        self._faults = ActiveFaults()
        self._last_codes: BoundedCache[object, int] = BoundedCache(MAX_SOURCES)
        self._events: deque[Values] = deque(maxlen=KEPT)
        self._active: dict[int, Values] = {}
        self._tasks: deque[tuple[int, Values]] = deque(maxlen=KEPT)  # with when its end came
        self._sessions: set[ApiSession] = set()
        self._wanted: frozenset[str] = frozenset()
        self._changed: set[str] = set()
        self._warned: set[str] = set()
        self._ended = False
        self._scanning = threading.Lock()
        self._scan: SharedSubscription | None = None
        self._links: dict[str, SharedSubscription] = {}
        self._pusher = threading.Thread(target=self._push_changes, name="woosh:robot-api pushes", daemon=True)
        try:
            for row in ROWS:
                self._links[row] = self.shared_subscriptions.open(row, self)
            with self._news:
                self._news.wait_for(lambda: self._latest.keys() | SILENT >= {*ROWS}, START_SECONDS)
        except BaseException:
            super().close(1.0)
            raise
        self._pusher.start()

    def close(self, timeout: float) -> None:
        """Release everything, after the sessions have ended."""
        with self._news:
            self._ended = True
            self._news.notify_all()
        self.commands.close()
        self._pusher.join(timeout)
        super().close(timeout)

    # -- messages of the robot ------------------------------------------------------------------------------

    def offer(self, event: MessageEvent) -> None:
        """Keep a message, which is decoded when its values are asked for; in a thread of the node."""
        row = event.topic
        if event.type_name != TYPES[row]:
            why = f"{event.description.publisher} publishes {event.type_name}, not {TYPES[row]}"
            self._warn(row, why)
            if row == SCAN and SCAN not in self._latest:
                self.pool.spawn(partial(self._refuse_scans, why))
            return
        recorded = _translated(event) if row in ("/robot_status", "/status_code") else {}
        with self._news:
            awaited = row == SCAN or row not in self._latest
            self._latest[row] = event
            if EVENT in recorded:
                self._keep_event(recorded[EVENT])
            elif recorded:
                self._keep_task(recorded[ROBOT + "TaskProc"])
            changed = self._wanted & CHANGED_BY[row]
            self._changed |= changed
            if changed or awaited:
                self._news.notify_all()

    def _keep_event(self, part: Values) -> None:
        """Push a status code as an event, and keep it. One that is only repeated is the same event."""
        code = self._faults.receive(part["code"])
        repeated = self._last_codes.get(code.source) == code.code
        if repeated and (not code.is_fault or code.code in self._active):
            return
        self._last_codes.put(code.source, code.code)
        task, state = self.known(ROBOT + "TaskProc"), self.known(ROBOT + "RobotState") or {}
        event = {**part, "time": time.time_ns() // 1_000_000, **state}
        if task is not None and TaskState(task["state"]).is_under_way:
            event |= {"robotTaskId": task["robotTaskId"], "type": task["action"]["type"]}
        self._events.append(event)
        self._active[code.code] = event
        active = {fault.code for fault in self._faults.active}
        self._active = {number: kept for number, kept in self._active.items() if number in active}
        self.push_event(EVENT, event)

    def push_event(self, type_name: str, values: Values) -> None:
        """Push what happened to the clients that subscribe to its type; nothing of it is left out."""
        text = self._text(type_name, values)
        with self._news:
            for session in self._sessions:
                if type_name in session.topics:
                    session.channel.outbox.put(type_name, len(text), text)

    def _keep_task(self, task: Values) -> None:
        over = TaskState(task["state"]).is_final and task["robotTaskId"]
        last = self._tasks[-1][1] if self._tasks else {}
        if over and any(last.get(key) != task[key] for key in ("robotTaskId", "state")):
            self._tasks.append((int(time.time()), task))

    # -- values ---------------------------------------------------------------------------------------------

    def start_list(self, list_id: int) -> None:
        """Begin a task list that is stored in the robot. Raises Refused."""
        why = "this server knows no task lists" if self._site is None else self._site.start_list(list_id)
        if why:
            raise Refused(why)

    def answer(self, type_name: str, asked: Values) -> Values:
        """The values of the answer to a read request. May wait for the robot, see `waits`.

        Raises:
            Refused: It is not known.
            RosError: The robot does not answer, or a value does not fit its type.
        """
        own = self._answers.get(type_name)
        if own is not None:
            return self._identified(wire.requests()[type_name].answer, own(asked))
        facts = self._facts()
        with self._news:
            values = self._values(type_name, facts)
        if values is None:
            raise Refused(f"{type_name} is not known here: no topic of the robot tells it, or none was heard")
        return self._identified(type_name, values)

    def waits(self, type_name: object, client: Hashable) -> bool:
        """Whether a request of a client may take long, so that it needs a thread."""
        if not isinstance(type_name, str):
            return False
        commanded = is_command(type_name) and self.commands.waits(type_name, client)
        return commanded or type_name in self._answers

    def known(self, type_name: str, facts: Mapping[str, Values] = _NOTHING) -> Values | None:
        """The parts of a type, if all its rows were heard and their publishers are there; and its facts. None
        if it is not known."""
        rows = [pair.row for pair in PAIRS if pair.type_name == type_name]
        with self._news:
            heard = [row for row in rows if self.hears(row)]
            if not rows or not OPTIONAL.issuperset(set(rows).difference(heard)):
                return facts.get(type_name)
            values: Values = {}
            for row in heard:
                values |= _translated(self._latest[row])[type_name]
        return {**values, **facts.get(type_name, {})}

    def hears(self, row: str, seconds: float | None = None) -> bool:
        """Whether a topic was heard and its publisher is there; lately, if it is sent all the time."""
        with self._news:
            link, event = self._links.get(row, self._scan), self._latest.get(row)
            if event is None or link is None or not link.connections:
                return False
            return row not in AGING or time.monotonic() - event.received <= (seconds or MAX_AGE)

    def drive_limits(self) -> DriveLimits:
        """Speeds that the chassis tells, or the usual ones."""
        event, linear, angular = self._latest.get(PARAMETERS), 0.0, 0.0
        if event is not None:
            told = firmware().convert(event.message, message_type(event.type_name))
            linear, angular = told.maxLinear, told.maxAngular
        return DriveLimits(
            linear if 0.0 < linear <= MAX_SPEED else MAX_LINEAR,
            angular if 0.0 < angular <= MAX_TURN_RATE else MAX_ANGULAR,
        )

    def _facts(self) -> Mapping[str, Values]:
        """What the site tells. Called without the lock, because the site has its own."""
        if self._site is None:
            return {}
        return {**self._site.facts(), ROBOT + "Scene": self._site.present()}

    def _identified(self, type_name: str, values: Values) -> Values:
        own = any(field.key == "robotId" for field in wire.fields(type_name))
        return {**values, "robotId": self._robot_id} if own else values

    def _values(self, type_name: str, facts: Mapping[str, Values]) -> Values | None:
        """The present values of a type; None if they are not known. The lock is held."""
        if type_name == ROBOT + "RobotInfo":
            found = {key: self._values(name, facts) for key, name in SECTIONS.items()}
            found |= self.known(ROBOT + "RobotState", facts) or {}
            return {key: values for key, values in found.items() if values is not None}
        if type_name == COUNT + "StatusCodes":
            return {"scs": [*self._events]}
        if type_name == COUNT + "AbnormalCodes":
            return {"scs": [*self._active.values()]}
        if type_name == ROBOT + "TaskHistory":
            return {"tes": [task for _, task in self._tasks]}
        if type_name in (ROBOT + "OperationState", ROBOT + "NavPath"):
            names = (ROBOT + name for name in ("TaskProc", "RobotState", "Mode", "PoseSpeed", "NavPath"))
            known = {name: values for name in names if (values := self.known(name, facts)) is not None}
            if type_name == ROBOT + "NavPath":
                return path_driven(known)
            return operation_state(
                known, max((f.level for f in self._faults.active), default=FaultLevel.NORMAL)
            )
        told = self.known(type_name, facts)
        return self._placed(told) if told is not None and type_name == SCANNER else told

    def _newest_scan(self) -> Values:
        before = self._latest.get(SCAN)
        with self.waiting(), closing(self.shared_subscriptions.open(SCAN, self)), self._news:
            if not self._news.wait_for(lambda: self._latest.get(SCAN) is not before, SCAN_SECONDS):
                raise Refused(f"no scan was received within {SCAN_SECONDS:g} s")
            return self._placed(_translated(self._latest[SCAN])[SCANNER])

    def _placed(self, scan: Values) -> Values:
        """A scan with the pose of the robot, if it is known."""
        speed = self.known(ROBOT + "PoseSpeed")
        return scan if speed is None else {**scan, "pose": speed["pose"]}

    def _statistics(self, asked: Values) -> Values:
        """CountData of a robot that began with the server: one day, the tasks and warnings that are kept."""
        now, speed = int(time.time()), self.known(ROBOT + "PoseSpeed") or {}
        span = asked.get("bucket", {"start": 0, "end": now})
        times = {"start": max(self._began, span["start"]), "end": min(now, span["end"])}
        day = {"buckets": [times], "mileage": {"end": speed.get("mileage", 0)}}
        days = [day] if times["start"] <= times["end"] else []
        with self._news:
            tasks = [
                {"taskId": one["robotTaskId"], "dest": one["dest"], "state": _ENDS[one["state"]], "end": True}
                for ended, one in self._tasks
                if span["start"] <= ended <= span["end"]
            ]
            warnings = [
                {"info": one}
                for one in self._events
                if one["level"] >= FaultLevel.WARNING and span["start"] <= one["time"] // 1000 <= span["end"]
            ]
        counts = {"operationQty": len(days), "taskQty": len(tasks), "abnormalQty": len(warnings)}
        return {"operations": {"ops": days}, "tasks": {"ts": tasks}, "abnormals": {"ss": warnings}, **counts}

    def _plan(self, asked: Values) -> Values:
        """Ask the navigation for a path; nothing is driven."""
        row, request = to_ros(PLAN, asked)
        client = self.node.service_client(row, interface_row(row).type)
        with self.waiting(), client:
            response = client.call(request, PLAN_SECONDS)
        return to_api("/move_base/global_plan", response.plan)[ROBOT + "NavPath"]

    # -- clients --------------------------------------------------------------------------------------------

    def subscribe(self, session: ApiSession, topics: Collection[str], *, sub: bool) -> None:
        """Begin or end pushes to a client; first the present values are pushed. Waits for no master."""
        facts = self._facts()
        with self._news:
            sub = sub and not session.channel.gone
            new = sorted(set(topics) - session.topics - {EVENT, SCANNER}) if sub else []
            session.topics = session.topics.union(topics) if sub else session.topics.difference(topics)
            for type_name in () if sub else topics:
                session.forget(type_name)
            if session.topics:
                self._sessions.add(session)
            else:
                self._sessions.discard(session)
            self._wanted = frozenset().union(*(one.topics for one in self._sessions))
            for type_name in new:
                session.push(type_name, self._present(type_name, facts))
        if SCANNER in topics:
            self.pool.spawn(self._follow_scans)

    def _follow_scans(self) -> None:
        """Subscribe to the scans while a client wants them. The master may be slow."""
        try:
            with self._scanning:
                if SCANNER in self._wanted and self._scan is None:
                    self._scan = self.shared_subscriptions.open(SCAN, self)
                elif SCANNER not in self._wanted and self._scan is not None:
                    scan, self._scan = self._scan, None
                    scan.close()
        except RosError as problem:
            self._warn(SCAN, str(problem))
            self._refuse_scans(str(problem))

    def _refuse_scans(self, why: str) -> None:
        """Tell the clients that wait for scans why none come; they may subscribe again."""
        with self._news:
            waiting = [session for session in self._sessions if SCANNER in session.topics]
        for session in waiting:
            self.subscribe(session, {SCANNER}, sub=False)
            session.refuse_subscription(f"{SCANNER} is not pushed: {why}")

    def _push_changes(self) -> None:
        due: dict[str, float] = {}
        while True:
            with self._news:
                if self._ended:
                    return
                now = time.monotonic()
                ready = {name for name in self._changed if due.get(name, now) <= now}
                if not ready:
                    self._news.wait(min((due[name] - now for name in self._changed), default=None))
                    continue
                self._changed -= ready
            facts = self._facts()
            with self._news:
                for name in ready:
                    due[name] = now + PERIODS.get(name, 0.0)
                    text = self._present(name, facts)
                    for session in self._sessions:
                        session.push(name, text)

    def _present(self, type_name: str, facts: Mapping[str, Values]) -> str | None:
        """The push of the present value; None if it is not known, or a message does not fit (logged once)."""
        try:
            values = self._values(type_name, facts)
            return None if values is None else self._text(type_name, values)
        except Exception as problem:  # the other types are still pushed
            self._warn(type_name, f"it is not pushed: {problem}")
            return None

    def _text(self, type_name: str, values: Values) -> str:
        return json.dumps(wire.push(type_name, self._identified(type_name, values)))

    def _warn(self, name: str, text: str) -> None:
        if name not in self._warned:
            self._warned.add(name)
            _log.warning("! robot-api: %s: %s", name, shown(text))


def _translated(event: MessageEvent) -> dict[str, Values]:
    """The values of a message, whatever revision of its type the robot's firmware has."""
    message = firmware().convert(event.message, message_type(event.type_name))
    return to_api(event.topic, message)
