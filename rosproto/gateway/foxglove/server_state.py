"""`ServerState`: the parts of one Foxglove server that its sessions share, and the list of sessions."""

from __future__ import annotations

import threading
import uuid
from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING, NamedTuple

from rosproto.errors import RosError
from rosproto.gateway.access import Access
from rosproto.gateway.client_limits import GatewayLimits
from rosproto.gateway.foxglove.advertised_channels import AdvertisedChannels, AdvertisedService
from rosproto.gateway.foxglove.assets import Assets
from rosproto.gateway.foxglove.graph import GraphView, GraphWatch
from rosproto.gateway.foxglove.messages import Level
from rosproto.gateway.foxglove.services import ServiceClasses
from rosproto.gateway.gateway_server import GatewayState
from rosproto.gateway.local_topic import LocalTopic
from rosproto.gateway.message_event import MessageEvent, TopicDescription
from rosproto.gateway.shared_subscriptions import Receiver, SharedSubscription
from rosproto.logs import get_logger
from rosproto.node import Node
from rosproto.watchdog import Watchdog

if TYPE_CHECKING:
    from rosproto.gateway.foxglove.session import FoxgloveSession

_log = get_logger("rosproto.gateway")

MASTER_STATUS = "master"  # id of the status about the master
FIRST_VIEW_SECONDS = 3.0  # the first viewer waits for a view of the graph


class ClientFacts(NamedTuple):
    """One client, at one moment.

    Attributes:
        peer: "host:port".
        subscriptions: Its topics.
        sent, sent_bytes: All messages sent to it.
        dropped: Messages dropped because it was too slow, by topic.
        published: Messages that it has published.
        since: When it connected, seconds since 1970.
    """

    peer: str
    subscriptions: tuple[str, ...]
    sent: int
    sent_bytes: int
    dropped: dict[str, int]
    published: int
    since: float


class ServerState(GatewayState):
    """The parts that the sessions share.

    Args:
        node: The node of the server.
        access: What viewers may see and write.
        limits: Bounds for a viewer.
        watchdog: Process that sends zero where a viewer drives if this process dies.
        name: The server's name for viewers.
        topics: Topics of this program.
        assets: Files for viewers.

    Attributes:
        run: Id of this run of the master, sent to viewers.
        refusals: Number of refused writes.
    """

    def __init__(
        self,
        node: Node,
        access: Access,
        limits: GatewayLimits,
        watchdog: Watchdog | None,
        *,
        name: str,
        topics: Iterable[LocalTopic],
        assets: Assets,
    ) -> None:
        super().__init__(node, "foxglove", access, limits, watchdog)
        self.name, self.assets = name, assets
        self.run = uuid.uuid4().hex
        self.refusals = 0
        self._local = {topic.name: topic for topic in topics}
        self.advertised = AdvertisedChannels(node, access, self._local.values())
        self._service_classes = ServiceClasses(node, access)
        self._lock = threading.Lock()
        self._sessions: set[FoxgloveSession] = set()
        self._clock_subscription: SharedSubscription | None = None
        self._time_lock = threading.Lock()
        self._simulated_now = 0
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
    def sessions(self) -> tuple[FoxgloveSession, ...]:
        """The sessions of all viewers."""
        with self._lock:
            return tuple(self._sessions)

    def add(self, session: FoxgloveSession) -> bool:
        """Add a viewer; True if it is the only one. Must not wait."""
        with self._lock:
            self._sessions.add(session)
            return len(self._sessions) == 1

    def welcome(self, session: FoxgloveSession, first: bool) -> None:
        """Send a new viewer the graph, the time and the state of the master; in a thread that may wait."""
        if first:  # the last view is old
            self._watch.next_view(FIRST_VIEW_SECONDS)
        if self._watch.problem is not None:
            session.status(_outdated(self._watch.problem), Level.ERROR, MASTER_STATUS)
        if self.node.clock.simulated:
            self._follow_clock()
            with self._time_lock:
                now = max(self._simulated_now, self.node.clock.now_nsec())
                if now:
                    session.tell_time(now)
        session.show(self.view)
        self.pool.spawn(self._ask_services)

    def gone(self, session: FoxgloveSession) -> None:
        """A session has ended."""
        with self._lock:
            self._sessions.discard(session)
            clock, self._clock_subscription = (
                (self._clock_subscription, None) if not self._sessions else (None, self._clock_subscription)
            )
        if clock is not None:
            clock.close()
            self._simulated_now = 0

    # -- the graph ------------------------------------------------------------------------------------------

    @property
    def view(self) -> GraphView:
        """The latest view of the graph."""
        return self._watch.view

    def advertised_services(self, view: GraphView) -> Mapping[str, AdvertisedService]:
        """The visible services of a view whose type is known."""
        return self.advertised.services(self._service_classes.present(view))

    def differs(self, description: TopicDescription) -> bool:
        """A publisher's definition differs from the advertised one: advertise it; False if it sent none.

        Called in a thread of the node.
        """
        learned = self.advertised.learn(description)
        if learned:
            self.pool.spawn(self._show)
        return learned

    def _show(self) -> None:
        for session in self.sessions:
            session.show(self.view)

    def _changed(self, view: GraphView) -> None:
        self.advertised.keep_only(set(view.types))
        self._show()
        self.pool.spawn(self._ask_services)

    def _ask_services(self) -> None:
        view = self.view
        if self._service_classes.ask(view, lambda: self._closed or not self._sessions):
            for session in self.sessions:
                session.show_services(view)

    def _lost(self, problem: RosError) -> None:
        _log.warning("! foxglove: %s", _outdated(problem))
        for session in self.sessions:
            session.status(_outdated(problem), Level.ERROR, MASTER_STATUS)

    def _back(self, another: bool) -> None:
        _log.info("= foxglove: the master is back")
        if another:
            self.run = uuid.uuid4().hex
        for session in self.sessions:
            session.remove_status(MASTER_STATUS)
            if another:
                session.restart()
            session.status(
                "the robot's master is back" + (", another run of it" if another else ""), Level.INFO
            )
            # `_changed` follows with the new master's view.

    # -- topics ---------------------------------------------------------------------------------------------

    def subscribe(self, topic: str, receiver: Receiver) -> SharedSubscription | ExitStack:
        """Subscribe to a topic of the robot or of this program; close the result. Calls the master."""
        local = self._local.get(topic)
        return self.shared_subscriptions.open(topic, receiver) if local is None else local.open(receiver)

    def _follow_clock(self) -> None:
        with self._lock:
            if self._clock_subscription is not None or not self._sessions:
                return
            try:
                self._clock_subscription = self.shared_subscriptions.open("/clock", self)
            except RosError as problem:
                _log.warning("! foxglove: simulated time cannot be followed: %s", problem)

    def offer(self, event: MessageEvent) -> None:
        """Send the simulated time of a message of /clock to all viewers; see `Receiver`."""
        if event.type_name != "rosgraph_msgs/Clock":
            return
        now = event.message.clock.to_nsec()
        with self._time_lock:
            self._simulated_now = now
            for session in self.sessions:
                session.tell_time(now)

    def capabilities(self) -> Sequence[str]:
        """The capabilities of the server, in the protocol's words."""
        found = ["clientPublish", "connectionGraph", "parameters", "parametersSubscribe", "services"]
        if self.node.clock.simulated:
            found.append("time")
        if self.assets:
            found.append("assets")
        return found

    def close(self, timeout: float) -> None:
        """Release everything, after the sessions have ended."""
        with self._lock:
            self._closed = True
        self._watch.close(timeout)
        super().close(timeout)


def _outdated(problem: RosError) -> str:
    return f"the robot's master does not answer; the graph shown is outdated: {problem}"
