"""What the sessions of one server share: the node, its graph, the topics that are followed."""

from __future__ import annotations

import threading
import uuid
from collections.abc import Callable, Iterable
from concurrent.futures import Executor
from typing import TYPE_CHECKING, Any

from rosproto.errors import RosError
from rosproto.gateway.access import Access
from rosproto.gateway.foxglove.assets import Assets
from rosproto.gateway.foxglove.graph import GraphView, GraphWatch
from rosproto.gateway.foxglove.local_topic import LocalTopic
from rosproto.gateway.foxglove.parameters import ParameterView
from rosproto.gateway.foxglove.publish import ClientTopics
from rosproto.gateway.foxglove.schemas import TopicSchema, TopicSchemas
from rosproto.gateway.foxglove.sdk import websocket
from rosproto.gateway.foxglove.services import ServiceTypes
from rosproto.gateway.foxglove.session import Session
from rosproto.gateway.limits import GatewayLimits
from rosproto.gateway.publications import Publications
from rosproto.gateway.taps import Receiver, Tap, Taps
from rosproto.gateway.write_guard import WriteGuard
from rosproto.logs import get_logger

if TYPE_CHECKING:
    from rosproto.gateway.message_event import MessageEvent, TopicDescription
    from rosproto.node import Node
    from rosproto.watchdog import Watchdog

__all__ = ["Shared"]

_log = get_logger("rosproto.gateway")

MASTER_STATUS = "master"  # id of the status about the master
FIRST_VIEW_SECONDS = 3.0  # that the first client waits for a view of the graph


class Shared:
    """The robot's side of a server, and the list of its sessions.

    Args:
        node: Talks to the robot.
        name: What viewers show as the server's name.
        access: What clients may see and write.
        limits: What a client may cost.
        topics: Topics of this program.
        assets: Files for viewers.
        watchdog: Sends zero where a client drives when this process is gone.
    """

    def __init__(
        self,
        node: Node,
        *,
        name: str,
        access: Access,
        limits: GatewayLimits,
        topics: Iterable[LocalTopic],
        assets: Assets,
        watchdog: Watchdog | None = None,
    ) -> None:
        self.node, self.name, self.access, self.limits, self.assets = node, name, access, limits, assets
        self.session_id = uuid.uuid4().hex
        self.refusals = 0
        self.pool: Executor
        self.later: Callable[[float, Callable[[], None]], None] = lambda seconds, call: None
        self.taps = Taps(node, limits)
        self.guard = WriteGuard(node.clock.now)
        self.publications = Publications(node, self.guard, watchdog=watchdog)
        self.client_topics = ClientTopics(node, access, limits, self.publications)
        self.parameters = ParameterView(node, access, limits)
        self.services = ServiceTypes(node, access)
        self._local = {topic.name: topic for topic in topics}
        self._schemas = TopicSchemas(node)
        self._lock = threading.Lock()
        self._offering = threading.Lock()
        self._offered: tuple[GraphView | None, dict[str, TopicSchema]] = (None, {})
        self._sessions: set[Session] = set()
        self._clock_tap: Tap | None = None
        self._closed = False
        self._watch = GraphWatch(
            node,
            wanted=lambda: bool(self._sessions),
            changed=self._changed,
            lost=self._lost,
            back=self._back,
        )

    # -- sessions -------------------------------------------------------------------------------------------

    @property
    def sessions(self) -> tuple[Session, ...]:
        """The sessions of all clients."""
        with self._lock:
            return tuple(self._sessions)

    def new_session(self, peer: str, hang_up: Callable[[], None]) -> Session:
        """Make the session of a client; called in a thread that may wait."""
        session = Session(self, peer, hang_up)
        with self._lock:
            if self._closed:
                session.server.stop()
                raise RuntimeError("the server is closing")
            first = not self._sessions
            self._sessions.add(session)
        if first:
            self._watch.next_view(FIRST_VIEW_SECONDS)
        self.pool.submit(self._ask_services)
        self._follow_clock()
        return session

    def welcome(self, session: Session) -> None:
        """Tell a newly connected client whether the master is there, and the simulated time."""
        if self._watch.problem is not None:
            session.status(_outdated(self._watch.problem), "Error", MASTER_STATUS)
        if self.node.clock.simulated and self.node.clock.now_nsec():
            session.time(self.node.clock.now_nsec())

    def gone(self, session: Session) -> None:
        """A session has ended."""
        with self._lock:
            self._sessions.discard(session)
            tap, self._clock_tap = (self._clock_tap, None) if not self._sessions else (None, self._clock_tap)
        if tap is not None:
            tap.close()

    # -- the graph ------------------------------------------------------------------------------------------

    @property
    def view(self) -> GraphView:
        """The latest view of the graph."""
        return self._watch.view

    def offered(self, view: GraphView) -> dict[str, TopicSchema]:
        """The topics of a view that clients may see, with this program's own, and their schemas."""
        with self._offering:
            if self._offered[0] is not view:
                found = {
                    topic: schema
                    for topic, kind in view.types.items()
                    if topic not in self._local
                    and self.access.may_read("topic", topic) is None
                    and (schema := self._schemas.schema(topic, kind, view.state.publishers[topic]))
                }
                for topic in self._local.values():
                    if self.access.may_read("topic", topic.name) is None:
                        told = topic.description
                        found[topic.name] = TopicSchema(told.type_name, told.md5sum, told.definition)
                self._offered = view, found
            return self._offered[1]

    def schema_differs(self, topic: str, description: TopicDescription) -> None:
        """A publisher's definition differs from what clients were told. Called in a thread of the node."""
        if self._schemas.learn(description) is None:
            return
        with self._offering:
            self._offered = None, {}

        def renew() -> None:
            for session in self.sessions:
                session.renew(topic)

        self._submit(renew)

    def _changed(self, view: GraphView) -> None:
        self._schemas.keep_only(set(view.types))
        self.services.forget(view)
        for session in self.sessions:
            session.show(view)
        self._submit(self._ask_services)

    def _ask_services(self) -> None:
        view = self.view
        if self.services.ask(view, lambda: self._closed or not self._sessions):
            for session in self.sessions:
                session.show_services(view)

    def _lost(self, problem: RosError) -> None:
        _log.warning("! foxglove: %s", _outdated(problem))
        for session in self.sessions:
            session.status(_outdated(problem), "Error", MASTER_STATUS)

    def _back(self, another: bool) -> None:
        _log.info("= foxglove: the master is back")
        if another:
            self.session_id = uuid.uuid4().hex
        for session in self.sessions:
            session.remove_status(MASTER_STATUS)
            if another:
                session.forget_everything()
            session.status("the robot's master is back" + (", another run of it" if another else ""), "Info")
            # `_changed` follows with what the new master knows; offering the old view now would be in vain.

    def _submit(self, function: Callable[[], object]) -> None:
        try:
            self.pool.submit(function)
        except RuntimeError:
            pass  # closed

    # -- topics ---------------------------------------------------------------------------------------------

    def tap(self, topic: str, receiver: Receiver) -> Any:
        """Follow a topic of the robot or of this program; close what this returns."""
        local = self._local.get(topic)
        return self.taps.open(topic, receiver) if local is None else local.open(receiver)

    def _follow_clock(self) -> None:
        """With simulated time, follow /clock for all sessions."""
        if not self.node.clock.simulated:
            return
        with self._lock:
            if self._clock_tap is not None or not self._sessions:
                return
            try:
                self._clock_tap = self.taps.open("/clock", _ClockReceiver(self))
            except RosError as problem:
                _log.warning("! foxglove: simulated time cannot be followed: %s", problem)

    def capabilities(self) -> list[Any]:
        """What the server tells viewers that it can do."""
        capability = websocket().Capability
        found = [
            capability.ClientPublish,
            capability.ConnectionGraph,
            capability.Parameters,
            capability.Services,
        ]
        if self.node.clock.simulated:
            found.append(capability.Time)
        return found

    def stop(self) -> None:
        """Admit nobody any more, and send every client a close frame."""
        with self._lock:
            self._closed = True
        for session in self.sessions:
            session.stop()

    def close(self, timeout: float) -> None:
        """End all sessions and release everything."""
        with self._lock:
            self._closed = True
        self._watch.close(timeout)
        for session in self.sessions:
            session.close()
        self.publications.close()
        self.taps.close()


def _outdated(problem: RosError) -> str:
    return f"the robot's master does not answer, what is shown is old: {problem}"


class _ClockReceiver:
    """Tells all sessions the simulated time."""

    def __init__(self, shared: Shared) -> None:
        self._shared = shared

    def offer(self, event: MessageEvent) -> None:
        if event.type_name == "rosgraph_msgs/Clock":
            seconds = event.message.clock
            now = seconds.secs * 1_000_000_000 + seconds.nsecs
            for session in self._shared.sessions:
                session.time(now)
