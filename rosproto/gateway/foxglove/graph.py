"""The graph as the master knows it, looked at again and again while somebody is connected.

The master has no call that tells of changes in the graph, so it is asked. It may go away and come back.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from rosproto.errors import RosError
from rosproto.gateway.access import Access
from rosproto.gateway.foxglove.sdk import sdk
from rosproto.logs import get_logger
from rosproto.node.graph.master_client import SystemState
from rosproto.records import NamedTuple

if TYPE_CHECKING:
    from typing import Any

    from rosproto.node import Node

__all__ = ["NOTHING", "GraphView", "GraphWatch", "connection_graph"]

_log = get_logger("rosproto.gateway")

PERIOD = 1.0  # seconds between two looks
LOOK_SECONDS = 3.0


class GraphView(NamedTuple):
    """What was seen.

    Attributes:
        types: Topics that somebody publishes, and what.
        state: Who publishes, subscribes and serves what.
        master: Which run of the master this is.
    """

    types: Mapping[str, str]
    state: SystemState
    master: object = None


NOTHING = GraphView({}, SystemState({}, {}, {}))


class GraphWatch:
    """Looks at the graph while `wanted()`; one thread.

    Args:
        node: Asks its master.
        wanted: Whether anybody is interested now.
        changed: Called with each view that differs from the one before, in this thread.
        lost: Called with the error when the master does not answer any more.
        back: Called when it does again, with whether it is another run of it, before `changed`.
    """

    def __init__(
        self,
        node: Node,
        *,
        wanted: Callable[[], bool],
        changed: Callable[[GraphView], object],
        lost: Callable[[RosError], object],
        back: Callable[[bool], object],
        period: float = PERIOD,
    ) -> None:
        self._node = node
        self._wanted, self._changed, self._lost, self._back = wanted, changed, lost, back
        self._period = period
        self._wake = threading.Event()
        self._looked = threading.Condition()
        self._looks = 0
        self._closed = False
        self.view = NOTHING
        self.away: RosError | None = None
        self._thread = threading.Thread(target=self._run, name="rosproto:foxglove graph", daemon=True)
        self._thread.start()

    def hurry(self) -> None:
        """Look now."""
        self._wake.set()

    def fresh(self, timeout: float) -> GraphView:
        """A view that was seen after this was called; an older one when that takes too long."""
        with self._looked:
            wanted = self._looks + 1
            self._wake.set()
            self._looked.wait_for(lambda: self._looks >= wanted or self._closed, timeout)
        return self.view

    def close(self, timeout: float) -> None:
        """End it; a look that is under way is not waited for longer than this."""
        self._closed = True
        self._wake.set()
        self._thread.join(timeout)

    def _run(self) -> None:
        while not self._closed:
            self._wake.wait(self._period)
            self._wake.clear()
            if self._closed:
                return
            try:
                if self._wanted():
                    self._look()
            except Exception:  # a look that fails must not be the last one
                _log.exception("! foxglove: looking at the graph failed")
            with self._looked:
                self._looks += 1
                self._looked.notify_all()

    def _look(self) -> None:
        master = self._node.master
        try:
            state = master.get_system_state(timeout=LOOK_SECONDS)
            types = master.get_topic_types(timeout=LOOK_SECONDS)
            run = self.view.master
            if self.away is not None or run is None:
                run = self._run_of_master()
        except RosError as problem:
            if self.away is None and not self._node.closed:
                self.away = problem
                self._lost(problem)
            return
        if self.away is not None:
            self.away = None
            self._back(run != self.view.master)
        published = {
            topic: types[topic]
            for topic in sorted(state.publishers)
            if state.publishers[topic] and types.get(topic, "*") != "*"
        }
        view = GraphView(published, state, run)
        if view != self.view:
            self.view = view
            self._changed(view)

    def _run_of_master(self) -> object:
        pid = self._node.master.get_pid(timeout=LOOK_SECONDS)
        try:
            return pid, self._node.master.get_param("/run_id", timeout=LOOK_SECONDS)
        except RosError:
            return pid, None


def connection_graph(view: GraphView, access: Access) -> Any:
    """What the SDK sends of it, without what is not open."""
    graph = sdk().ConnectionGraph()
    for topic, nodes in view.state.publishers.items():
        if access.may_read("topic", topic) is None:
            graph.set_published_topic(topic, nodes)
    for topic, nodes in view.state.subscribers.items():
        if access.may_read("topic", topic) is None:
            graph.set_subscribed_topic(topic, nodes)
    for service, nodes in view.state.services.items():
        if access.may_read("service", service) is None:
            graph.set_advertised_service(service, nodes)
    return graph
