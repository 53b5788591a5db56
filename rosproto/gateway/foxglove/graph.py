"""`GraphWatch`: polls the master for the ROS graph every second while a viewer is connected.

The master does not report changes. It may stop answering, and come back.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from rosproto.errors import MasterError, RosError
from rosproto.gateway.access import Access, Kind
from rosproto.logs import get_logger
from rosproto.node import Node
from rosproto.node.graph.master_client import SystemState

_log = get_logger("rosproto.gateway")

PERIOD = 1.0  # seconds between two polls
POLL_TIMEOUT = 3.0


class MasterRun(NamedTuple):
    """Identifies a run of the master.

    Attributes:
        pid: Its process id.
        run_id: The parameter /run_id; None until roslaunch has set it.
    """

    pid: int
    run_id: object = None

    def is_another(self, before: MasterRun | None) -> bool:
        """Whether the master has been restarted since; unknown ids are not compared."""
        if before is None or None in (self.run_id, before.run_id):
            return before is not None and self.pid != before.pid
        return self != before


class GraphView(NamedTuple):
    """The graph at one moment.

    Attributes:
        types: Topics that have publishers -> type.
        state: Publishers, subscribers and service providers.
        master: The run of the master; None before the first answer.
    """

    types: Mapping[str, str]
    state: SystemState
    master: MasterRun | None = None


EMPTY_VIEW = GraphView({}, SystemState({}, {}, {}))


class GraphWatch:
    """Polls in its own thread, while `wanted()`.

    Args:
        node: Calls its master.
        wanted: Whether a viewer is connected.
        changed: Called with each view that differs from the one before. All callbacks run in the thread.
        lost: Called with the error when the master stops answering.
        back: Called when it answers again, with whether it has been restarted; before `changed`.

    Attributes:
        view: The latest view.
        problem: Why the master does not answer; None while it does.
    """

    def __init__(
        self,
        node: Node,
        *,
        wanted: Callable[[], bool],
        changed: Callable[[GraphView], object],
        lost: Callable[[RosError], object],
        back: Callable[[bool], object],
    ) -> None:
        self._node = node
        self._wanted, self._changed, self._lost, self._back = wanted, changed, lost, back
        self._wake = threading.Event()
        self._polled = threading.Condition()
        self._polls = 0
        self._closed = False
        self.view = EMPTY_VIEW
        self.problem: RosError | None = None
        self._thread = threading.Thread(target=self._run, name="rosproto:foxglove graph", daemon=True)
        self._thread.start()

    def next_view(self, timeout: float) -> None:
        """Wait for a view polled after this call, or until the time is over."""
        with self._polled:
            wanted = self._polls + 1
            self._wake.set()
            self._polled.wait_for(lambda: self._polls >= wanted or self._closed, timeout)

    def close(self, timeout: float) -> None:
        """End the thread; waits at most this long for a poll in progress."""
        self._closed = True
        self._wake.set()
        self._thread.join(timeout)

    def _run(self) -> None:
        while not self._closed:
            self._wake.wait(PERIOD)
            self._wake.clear()
            if self._closed:
                return
            try:
                if self._wanted():
                    self._poll()
            except Exception:  # one failed poll must not end the thread
                _log.exception("! foxglove: polling the graph failed")
            with self._polled:
                self._polls += 1
                self._polled.notify_all()

    def _poll(self) -> None:
        master = self._node.master
        try:
            state = master.get_system_state(timeout=POLL_TIMEOUT)
            types = master.get_topic_types(timeout=POLL_TIMEOUT)
            run = self.view.master
            if self.problem is not None or run is None or run.run_id is None:
                run = self._run_of_master()
        except RosError as problem:
            if self.problem is None and not self._node.closed:
                self.problem = problem
                self._lost(problem)
            return
        if self.problem is not None:
            self.problem = None
            self._back(run.is_another(self.view.master))
        published = {
            topic: types[topic]
            for topic in sorted(state.publishers)
            if state.publishers[topic] and types.get(topic, "*") != "*"
        }
        view = GraphView(published, state, run)
        if view != self.view:
            self.view = view
            self._changed(view)

    def _run_of_master(self) -> MasterRun:
        pid = self._node.master.get_pid(timeout=POLL_TIMEOUT)
        try:
            return MasterRun(pid, self._node.master.get_param("/run_id", timeout=POLL_TIMEOUT))
        except MasterError:  # it is not set
            return MasterRun(pid)


class ConnectionGraph(NamedTuple):
    """Publishers, subscribers and service providers by name."""

    published: Mapping[str, Sequence[str]] = {}
    subscribed: Mapping[str, Sequence[str]] = {}
    services: Mapping[str, Sequence[str]] = {}


def connection_graph(view: GraphView, access: Access) -> ConnectionGraph:
    """The connections of a view, without names that viewers may not see."""
    state = view.state

    def seen(names: Mapping[str, Sequence[str]], kind: Kind) -> dict[str, Sequence[str]]:
        return {
            name: [node for node in nodes if access.shows("node", node)]
            for name, nodes in names.items()
            if access.shows(kind, name)
        }

    return ConnectionGraph(
        seen(state.publishers, "topic"), seen(state.subscribers, "topic"), seen(state.services, "service")
    )
