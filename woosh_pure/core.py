"""What the verbs of `Chassis` share: the node, feeds, publishers, clients, and what is known of the robot.

Everything is made on first use and closed by `close`. Safe from any thread.
"""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import rosproto
from rosproto.codec.conversion import ValuesLost
from rosproto.errors import ConnectionLost, RosError, RosTimeout
from rosproto.logs import get_logger
from rosproto.node.services.client import Cancellation

from .begun import current
from .enums import TaskCommand
from .errors import MotionRefused, StaleState
from .faults import ActiveFaults, Faults, StatusCode
from .feed import Feed
from .firmware_limits import limit_error, require_message
from .geometry import Velocity
from .interface import find, row
from .outcome import Outcome, OutcomeKind
from .readiness import Readiness, assess, status_shows_fitness, triggered_keys
from .refusals import Refusals
from .rivals import Rivals
from .running import Running
from .velocity_topics import VelocityTopics

if TYPE_CHECKING:
    from .values import RobotStatus

__all__ = ["Core"]

logger = get_logger("woosh_pure.core")

# A link counts as lost when its publisher has been away for this long: a restart of one node of the chassis
# takes about a second, and is no reason to give a task up.
_LOST_AFTER = 5.0


class Core:
    """Connection to one chassis.

    Attributes:
        master_uri: Where its master is.
        node: Our node, made on first use.
        running: What was started and still runs.
        rivals: Goals of other clients, as far as heard.
        refusals: What the chassis has refused, until it is shown to be over.
        velocity: The velocity topics.
    """

    def __init__(
        self,
        master_uri: str,
        *,
        name: str,
        host: str | None,
        timeout: float,
        leave_running: bool = False,
        msg_path: Sequence[str | os.PathLike[str]] = (),
        resolve: Mapping[str, str] | None = None,
    ) -> None:
        self.master_uri = master_uri
        self.timeout = timeout
        self._name, self._host = name, host
        self._msg_path = msg_path
        self._resolve = resolve
        # For the lists; never held while the network is waited for.
        self._lock = threading.RLock()
        # One node, publisher, client ... is made at a time; this may take long.
        self._making = threading.RLock()
        self._node: rosproto.Node | None = None
        self._feeds: dict[str, Feed[Any]] = {}
        self._publishers: dict[str, rosproto.Publisher] = {}
        self._services: dict[str, Any] = {}
        self._actions: dict[str, rosproto.ActionClient] = {}
        self.running = Running(leave=leave_running)
        self.velocity = VelocityTopics(self)
        self._faults = ActiveFaults()
        self.rivals = Rivals()
        self.refusals = Refusals()
        self._has_moved = False
        self._fault_lock = threading.Lock()
        self._missing_since: dict[str, float] = {}
        self._closed = False
        self._watching = False

    # -- the graph -------------------------------------------------------------------------------------------

    @property
    def node(self) -> rosproto.Node:
        """Our node; its name is unique, so no two programs throw each other out."""
        made = self._node
        if made is not None and not self._closed:
            return made  # without the lock: `stop` must not wait for a verb that is connecting
        with self._making:
            self.require_open()
            if self._node is None:
                self._node = self.new_node()
                self._node.before_close(self._before_close)
            return self._node

    def new_node(self) -> rosproto.Node:
        """A node of ours, under a name that no other has."""
        return rosproto.Node(
            self._name,
            master_uri=self.master_uri,
            host=self._host,
            anonymous=True,
            timeout=self.timeout,
            msg_path=self._msg_path,
            resolve=self._resolve,
        )

    def _before_close(self, reason: str) -> None:
        topics = self.velocity.in_use
        self.running.end_with_node(reason)
        if reason and topics:
            self.velocity.zero_from_elsewhere(topics)

    @property
    def state(self) -> str:
        """Whether there is a connection, in words."""
        if self._closed:
            return "closed"
        return "not connected yet" if self._node is None else "connected"

    def require_open(self) -> None:
        """Refuse everything after `close`.

        Raises:
            ConnectionLost: This Chassis is closed.
        """
        if self._closed:
            raise ConnectionLost(f"this Chassis is closed; open a new one for {self.master_uri}")

    def feed(self, name: str) -> Feed[Any]:
        """The feed of that name, or of a topic that has none, subscribed on first reading."""
        with self._lock:
            if name not in self._feeds:
                found = row(name) if name.startswith("/") else find(name)
                self._feeds[name] = Feed(found, lambda: self.node)
            return self._feeds[name]

    def publisher(self, topic: str, type_name: Any) -> rosproto.Publisher:
        """A publisher of any topic and type, kept until close."""
        self.require_open()
        with self._making:
            if topic not in self._publishers:
                self._publishers[topic] = self.node.publisher(topic, type_name, queue_size=10)
            return self._publishers[topic]

    def wait_any(self, publishers: Sequence[rosproto.Publisher], timeout: float) -> None:
        """Wait until one of several publishers has a subscriber.

        Raises:
            RosTimeout: None has.
        """
        deadline = time.monotonic() + timeout
        while not any(p.connections for p in publishers):
            if time.monotonic() > deadline:
                names = " or ".join(p.topic for p in publishers)
                raise RosTimeout(
                    f"nobody listens to {names}; this chassis may not have it", what=names, seconds=timeout
                )
            time.sleep(0.01)

    def connect(self, topic: str, type_: Any) -> None:
        """Wait until the chassis listens to a topic, without sending anything.

        Raises:
            RosTimeout: Nobody of the chassis subscribes.
        """
        self.require_connection(self.publisher(topic, type_), topic)

    def send(self, topic: str, message: Any, timeout: float | None = None) -> None:
        """Publish once, after the chassis has connected.

        Raises:
            RosTimeout: Nobody of the chassis subscribes.
        """
        publisher = self.publisher(topic, type(message))
        self.require_connection(publisher, topic, timeout)
        require_message(topic, publisher, message)
        if (begun := current()) is not None:
            begun.require_wanted(topic)
        publisher.publish(message)
        publisher.flush(self.timeout)

    def require_connection(
        self, publisher: rosproto.Publisher, topic: str, timeout: float | None = None
    ) -> None:
        """Wait until somebody listens.

        Raises:
            RosTimeout: Nobody came in time.
        """
        publisher.wait_for_connection(timeout=self.timeout if timeout is None else timeout)

    def service(self, name: str) -> Any:
        """The client of a service of the interface."""
        self.require_open()
        if made := self._services.get(name):
            return made  # without the lock: a cancel must not wait for a verb that is connecting
        with self._making:
            if name not in self._services:
                client = self.node.service_client(name, row(name).type)
                client.lossless = True
                self._services[name] = client
            return self._services[name]

    def call(self, name: str, *, timeout: float | None = None, **fields: Any) -> Any:
        """Call a service of the interface and return its response.

        Raises:
            FirmwareLimit: The chassis's definition has no field for a value given; nothing was sent.
        """
        client, seconds = self.service(name), self.timeout if timeout is None else timeout
        # What cancels a task must go out, whoever has gone.
        begun = None if name == "/exec_task" else current()
        try:
            if begun is not None:
                return client.call_cancellable(begun.calling, None, seconds, **fields)
            return client.call(timeout=seconds, **fields)
        except ValuesLost as error:
            lack = f"no field for {', '.join(error.fields)}"
            raise limit_error(name, error.theirs, error.fields, lack) from error

    def services_of_type(self, type_name: str) -> list[str]:
        """Names of the services of a type, by asking the service with each name what it is; none is called.

        Raises:
            ConnectionLost, RosTimeout, MasterError: The master cannot be asked.
        """
        from .survey import survey

        answers = survey(self.node, timeout=self.timeout, kinds=("service",))
        return [answer.name for answer in answers if answer.type == type_name]

    def call_found(self, name: str, type_name: str, *, timeout: float | None = None, **fields: Any) -> Any:
        """Call a service that is in no row of the interface under this name."""
        with self.node.service_client(name, type_name) as client:
            cancellation = Cancellation() if (begun := current()) is None else begun.calling
            seconds = self.timeout if timeout is None else timeout
            return client.call_cancellable(cancellation, None, seconds, **fields)

    def action(self, name: str) -> rosproto.ActionClient:
        """The client of an action of the interface, ready to send.

        Raises:
            RosTimeout: The server is not there; the text says which part is missing.
        """
        self.require_open()
        with self._making:
            client = self._actions.get(name)
            if client is None:
                client = rosproto.ActionClient(self.node, name, row(name).type)
                self._actions[name] = client
        client.wait_for_server(self.timeout)
        return client

    def exec_task(self, command: TaskCommand, task_id: int, *, timeout: float, **fields: Any) -> Any:
        """Call /exec_task."""
        return self.call("/exec_task", timeout=timeout, task_exect=int(command), task_id=task_id, **fields)

    # -- what is known ---------------------------------------------------------------------------------------

    def watch_faults(self) -> None:
        """Begin to keep the set of active faults; from the return on, no code is missed."""
        feed = self.feed("status_code")
        with self._lock:
            watching, self._watching = self._watching, True
        if not watching:
            feed.on(self._on_status_code)
        else:
            feed.heard  # noqa: B018  (the first use waits for the links, also when another thread began)

    def _on_status_code(self, code: StatusCode) -> None:
        with self._fault_lock:
            self._faults.receive(code.code)
        self.refusals.receive(code)

    def active_faults(self) -> Faults:
        """Faults active now, as far as heard since this Chassis listens, and whether that is all."""
        self._listen("status", "status_code")
        status, outdated = self._status_known()
        with self._fault_lock:
            return Faults(self._faults.active, None if status is None or outdated else status.robot_state)

    def readiness(self) -> Readiness:
        """What is known against moving; the first call waits until the links it needs stand."""
        if (begun := current()) is not None:
            begun.require_wanted("readiness")  # `wait_until_ready` asks again and again
        self._listen("battery", "status", "status_code", "inputs")
        self.rivals.listen(self.node)
        return self.known_readiness()

    def known_readiness(self) -> Readiness:
        """As `readiness`, from what was heard so far: never waits, so that a drive may ask it at any time."""
        battery = self._known("battery")
        charging = None if battery is None else battery.charging
        status, outdated = self._status_known()
        with self._fault_lock:
            faults = self._faults.active
        ours = {goal.task_id for goal in self.running.goals if goal.task_id}
        return assess(
            status,
            faults,
            charging,
            ours,
            self.rivals.active(),
            keys=triggered_keys(self._known("inputs")),
            refusals=self.refusals.reasons(),
            link_lost=outdated,
            has_moved=self._has_moved,
        )

    def _status_known(self) -> tuple[RobotStatus | None, bool]:
        """The last /robot_status, and whether what it says may be over; never waits."""
        feed = self._feeds.get("status")
        reading = None if feed is None else feed.known
        if feed is None or reading is None:
            return None, False
        if status_shows_fitness(reading.value):
            self.refusals.end_before(reading.received)
        return reading.value, feed.outdated

    def note_outcome(self, outcome: Outcome, *, drives: bool, told: bool) -> None:
        """Remember how a goal ended, for `readiness`.

        Args:
            outcome: How.
            drives: Whether it moves the base.
            told: Whether /robot_status has told its end: then the state of the robot is known with it.
        """
        if not drives:
            return
        if outcome.arrived:
            self._has_moved = True
            self.refusals.end()
        elif outcome.kind in (OutcomeKind.FAILED, OutcomeKind.REJECTED):
            self._has_moved = False
            status = self._status_known()[0] if told else None
            self.refusals.note(
                f"the last motion was not carried out ({outcome.goal}: {outcome.text or 'no reason given'})",
                time.monotonic(),
                None if status is None else status.robot_state,
            )

    def _listen(self, *names: str) -> None:
        feeds = [self.feed(name).open() for name in names]  # all at once: they connect at the same time
        if "status_code" in names:
            self.watch_faults()
        for feed in feeds:
            feed.heard  # noqa: B018  (the first use waits for the links)

    def _known(self, name: str) -> Any:
        feed = self._feeds.get(name)
        reading = None if feed is None else feed.known
        return None if reading is None else reading.value

    def require_ready(self, what: str, check: bool) -> None:
        """Refuse when something known blocks every motion; where that is not known, the chassis decides.

        Raises:
            MotionRefused: With the readiness.
        """
        self.require_open()
        self.running.require_not_over()
        self._listen("battery", "status", "status_code", "velocity")
        readiness = self.known_readiness()
        if check and readiness.refuses:
            raise MotionRefused(f"{what} refused, nothing was sent", readiness=readiness)

    def require_publisher(self, feed: Feed[Any]) -> None:
        """Wait until the topic that tells the end of a goal is connected.

        Raises:
            StaleState: Nobody publishes it: the end could not be seen, so nothing is started.
        """
        deadline = time.monotonic() + self.timeout
        while feed.publishers == 0:
            if time.monotonic() > deadline:
                why = f" ({feed.unreachable})" if feed.unreachable else ""
                raise StaleState(
                    f"{feed.topic}: no publisher within {self.timeout} s{why}, so the end of a task "
                    "could not be seen; check `woosh doctor`",
                    topic=feed.topic,
                )
            time.sleep(0.01)

    def require_heard(self, name: str, timeout: float) -> None:
        """Wait for a feed's first value.

        Raises:
            StaleState: It stayed silent.
        """
        feed = self.feed(name)
        try:
            feed.wait(timeout, new=False)
        except RosTimeout as error:
            raise StaleState(
                f"{feed.topic} is silent, so nobody could see whether the robot obeys; check the chassis, "
                "or pass feedback_timeout=None to drive without it",
                topic=feed.topic,
                age=feed.age,
            ) from error

    def lost(self, name: str) -> str:
        """Why the link behind a feed counts as lost; "" while it is fine."""
        feed = self.feed(name)
        if feed.publishers > 0:
            self._missing_since.pop(name, None)
        else:
            since = self._missing_since.setdefault(name, time.monotonic())
            if time.monotonic() - since > _LOST_AFTER:
                return f"{feed.topic} has had no publisher for {_LOST_AFTER} s"
        beat = self.feed("velocity")
        age = beat.age
        if age is not None and age > _LOST_AFTER:
            return f"the chassis has been silent for {age:.1f} s ({beat.topic})"
        return ""

    def status_shows_end_of(self, task_id: int) -> bool:
        """True when the last status says that this task is over."""
        status = self.feed("status").latest
        return status is not None and status.task_id == task_id and status.task_state.is_final

    def wait_standing(self, timeout: float) -> bool | None:
        """Whether the robot stands still: True as soon as measured, False when it still moves, None when
        unknown."""
        feed = self.feed("velocity")
        began = time.monotonic()

        def fresh() -> Velocity | None:
            reading = feed.reading
            return reading.value if reading is not None and reading.received >= began else None

        while (left := began + timeout - time.monotonic()) > 0.0:
            velocity = fresh()
            if velocity is not None and velocity.is_standing():
                return True
            try:
                feed.wait(min(left, 0.5))
            except RosTimeout:
                continue
            except RosError:
                return None
        return None if fresh() is None else False

    @property
    def opened_feeds(self) -> set[str]:
        """Names of the feeds used so far."""
        with self._lock:
            return set(self._feeds)

    def close(self) -> None:
        """Close feeds and node; goals and drives must have ended before.

        May be called again: one that was interrupted by Ctrl-C is finished then.
        """
        with self._making, self._lock:
            self._closed = True
            feeds, node = list(self._feeds.values()), self._node
        self.running.close()
        for feed in feeds:
            feed.close()
        if node is not None:
            node.close()
