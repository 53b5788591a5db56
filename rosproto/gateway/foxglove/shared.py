"""What the sessions of one server share: the robot's side of it."""

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
from rosproto.gateway.foxglove.schemas import Described, TopicBook
from rosproto.gateway.foxglove.sdk import websocket
from rosproto.gateway.foxglove.services import ServiceBook
from rosproto.gateway.foxglove.session import Session
from rosproto.gateway.limits import GatewayLimits
from rosproto.gateway.publications import Publications
from rosproto.gateway.taps import Receiver, Tap, Taps
from rosproto.gateway.write_guard import WriteGuard
from rosproto.logs import get_logger

if TYPE_CHECKING:
    from rosproto.gateway.message_event import Sample, TopicDescription
    from rosproto.node import Node

__all__ = ["House"]

_log = get_logger("rosproto.gateway")

MASTER = "master"  # id of the status about it
FIRST_LOOK = 3.0  # seconds a new client waits for a view of the graph


class House:
    """The node, what is known of its graph, and who is here.

    Args:
        node: Talks to the robot.
        name: What viewers show as the server's name.
        access: What is open.
        limits: Bounds.
        topics: Topics of this program's own.
        assets: Files for viewers.
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
    ) -> None:
        self.node, self.name, self.access, self.limits, self.assets = node, name, access, limits, assets
        self.session_id = uuid.uuid4().hex
        self.refusals = 0
        self.pool: Executor
        self.later: Callable[[float, Callable[[], None]], None] = lambda seconds, call: None
        self.taps = Taps(node, limits)
        self.guard = WriteGuard(node.clock.now)
        self.publications = Publications(node, self.guard)
        self.client_topics = ClientTopics(node, access, limits, self.publications)
        self.parameters = ParameterView(node, access, limits)
        self.services = ServiceBook(node, access)
        self._local = {topic.name: topic for topic in topics}
        self._book = TopicBook(node)
        self._lock = threading.Lock()
        self._offering = threading.Lock()
        self._offered: tuple[GraphView | None, dict[str, Described]] = (None, {})
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

    # -- who is here ----------------------------------------------------------------------------------------

    @property
    def sessions(self) -> tuple[Session, ...]:
        """All of them."""
        with self._lock:
            return tuple(self._sessions)

    def receive(self, peer: str, hang_up: Callable[[], None]) -> Session:
        """Make the session of a client; in a thread that may wait."""
        session = Session(self, peer, hang_up)
        with self._lock:
            if self._closed:
                session.server.stop()
                raise RuntimeError("the server is closing")
            first = not self._sessions
            self._sessions.add(session)
        if first:
            self._watch.fresh(FIRST_LOOK)
        self.pool.submit(self._ask_services)
        self._follow_clock()
        return session

    def welcome(self, session: Session) -> None:
        """Tell a client how things stand, now that it is connected and hears it."""
        if self._watch.away is not None:
            session.status(_away(self._watch.away), "Error", MASTER)
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
        """The graph as it was seen last."""
        return self._watch.view

    def offered(self, view: GraphView) -> dict[str, Described]:
        """Topics of a view that are open and described, with this program's own."""
        with self._offering:
            if self._offered[0] is not view:
                found = {
                    topic: described
                    for topic, kind in view.types.items()
                    if topic not in self._local
                    and self.access.may_read("topic", topic) is None
                    and (described := self._book.describe(topic, kind, view.state.publishers[topic]))
                }
                for topic in self._local.values():
                    if self.access.may_read("topic", topic.name) is None:
                        told = topic.description
                        found[topic.name] = Described(told.type_name, told.md5sum, told.definition)
                self._offered = view, found
            return self._offered[1]

    def heard(self, topic: str, description: TopicDescription) -> None:
        """A publisher's own definition differs from what clients were told. In a thread of the node."""
        if self._book.note(description) is None:
            return
        with self._offering:
            self._offered = None, {}

        def tell() -> None:
            for session in self.sessions:
                session.renew(topic)

        self._submit(tell)

    def _changed(self, view: GraphView) -> None:
        self._book.forget(set(view.types))
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
        _log.warning("! foxglove: %s", _away(problem))
        for session in self.sessions:
            session.status(_away(problem), "Error", MASTER)

    def _back(self, another: bool) -> None:
        _log.info("= foxglove: the master is back")
        if another:
            self.session_id = uuid.uuid4().hex
        for session in self.sessions:
            session.take_back_status(MASTER)
            if another:
                session.begin_anew()
            session.status("the robot's master is back" + (", another run of it" if another else ""), "Info")
            # What the new run has is shown next (`_changed`); the old view's topics would come and go.

    def _submit(self, function: Callable[[], object]) -> None:
        try:
            self.pool.submit(function)
        except RuntimeError:
            pass  # closed

    # -- topics ---------------------------------------------------------------------------------------------

    def tap(self, topic: str, receiver: Receiver) -> Any:
        """Follow a topic, at the robot or here; close what this returns."""
        local = self._local.get(topic)
        return self.taps.open(topic, receiver) if local is None else local.open(receiver)

    def _follow_clock(self) -> None:
        """With simulated time: /clock, for all."""
        if not self.node.clock.simulated:
            return
        with self._lock:
            if self._clock_tap is not None or not self._sessions:
                return
            try:
                self._clock_tap = self.taps.open("/clock", _Clock(self))
            except RosError as problem:
                _log.warning("! foxglove: simulated time cannot be followed: %s", problem)

    def capabilities(self) -> list[Any]:
        """What viewers are told that this server can."""
        can = websocket().Capability
        found = [can.ClientPublish, can.ConnectionGraph, can.Parameters, can.Services]
        if self.node.clock.simulated:
            found.append(can.Time)
        return found

    def say_goodbye(self) -> None:
        """Let nobody in any more, and end the connections of those who are here in order."""
        with self._lock:
            self._closed = True
        for session in self.sessions:
            session.stop()

    def close(self, timeout: float) -> None:
        """End all sessions and leave everything."""
        with self._lock:
            self._closed = True
        self._watch.close(timeout)
        for session in self.sessions:
            session.close()
        self.publications.close()
        self.taps.close()


def _away(problem: RosError) -> str:
    return f"the robot's master does not answer, what is shown is old: {problem}"


class _Clock:
    """Tells the sessions the simulation's time."""

    def __init__(self, house: House) -> None:
        self._house = house

    def offer(self, sample: Sample) -> None:
        if sample.type_name == "rosgraph_msgs/Clock":
            seconds = sample.message.clock
            now = seconds.secs * 1_000_000_000 + seconds.nsecs
            for session in self._house.sessions:
                session.time(now)
