"""`Graph`: the nodes of the simulated chassis with their real names, and every row of the interface table on
them."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from typing import Any

import rosproto
from rosproto.action import ServerGoal, action_type
from rosproto.codec import DynamicMessage
from rosproto.node import LocalNodes, OwnDefinitionsOnly
from woosh_pure import interface
from woosh_pure.firmware.versions import Firmware
from woosh_pure.interface.schema import Row
from woosh_pure.sim.network import Network, RobotNode
from woosh_pure.sim.planner import COSTMAP_TOPIC
from woosh_pure.sim.ros_handlers import RosHandlers
from woosh_pure.values.messages import message_type

_ASSUMED = {"woosh_msgs/VolumeCtl": "uint8 percent  # assumed\n"}
"""Assumed definitions of types whose definition is not published; clients learn them."""

_MASTER_TIMEOUT = {True: 60.0, False: 10.0}
"""Seconds for a node to find the master, by whether it is its own; that one is only late on a busy
computer."""
_PERIOD, _SELDOM = 5.0, 12  # s between checks of its own master; checks between comparisons of the graph

_RI = "/ros_interface"
_TOPICS_WITHOUT_SUBSCRIBER = {
    "/enable_follower": "std_msgs/Bool",
    "/follow_base/local_costmap/set_footprint": "geometry_msgs/Polygon",
}
_TOPICS_WITHOUT_PUBLISHER = {"/follow/remote_control_request": "woosh_msgs/IOs"}
_ACTIONS_WITHOUT_SERVER = {"/xarm_base": "woosh_msgs/Arm"}


class Graph:
    """Nodes, publishers, subscribers, services and action servers, by name.

    Attributes:
        nodes: By name.
        publishers: (node, topic) to publisher.
        heard: Last message on each written topic.
        costmap: Publisher of the navigation's costmap, which is not in the table (assumed).
    """

    def __init__(
        self,
        master_uri: str,
        server: RosHandlers,
        *,
        host: str | None,
        full: bool,
        latch_status: bool,
        firmware: Firmware,
        network: Network,
        assumed_types: bool,
        own_master: rosproto.Master | None,
    ) -> None:
        self._uri, self._host, self._full = master_uri, host, full
        self._own_master = own_master is not None
        self._firmware = firmware
        self._latch_status = latch_status
        self._network = network
        self._assumed_types = assumed_types
        self._server = server
        self.nodes: dict[str, rosproto.Node] = {}
        self.publishers: dict[tuple[str, str], rosproto.Publisher] = {}
        self.heard: dict[str, DynamicMessage] = {}
        self.costmap: rosproto.Publisher | None = None
        self._keep: list[object] = []
        self._building: ExitStack | None = None
        # Reported as TCPROS, as between the real nodes.
        self._robot = LocalNodes(told_as="TCPROS", master=own_master)
        self.internal_clients: dict[str, rosproto.ActionClient] = {}

    def node(self, name: str) -> rosproto.Node:
        """The node with a name, created on first use.

        Links to other programs are real sockets, also within this process; links between the robot's nodes
        are not.
        It refuses every definition but its own, as the real node does: the client must adapt.
        """
        if name not in self.nodes:
            node = RobotNode(
                name,
                self._network,
                master_uri=self._uri,
                host=self._host,
                intraprocess=self._robot,
                timeout=_MASTER_TIMEOUT[self._own_master],
            )
            if self._own_master:
                # A restart is announced by `check_master_now`. Checks every second by forty nodes took most
                # of the processor time of an idle robot.
                node.watch_master(period=_PERIOD, full_check_every=_SELDOM)
            node.definitions = OwnDefinitionsOnly()
            if self._building is not None:
                self._building.enter_context(node.batch())
            self.nodes[name] = node
        return self.nodes[name]

    def build(self) -> None:
        """Create all nodes and their parts."""
        with ExitStack() as stack:
            stack.callback(setattr, self, "_building", None)
            self._building = stack  # each node registers what it has with one request, at the end
            for row in interface.ROWS:
                if not row.definition_known and not self._assumed_types:
                    continue
                builder = {
                    "read": self._publish,
                    "write": self._listen,
                    "call": self._serve,
                    "act": self._act,
                }
                builder[row.flow](row)
            if self._full:
                self._add_unconnected_endpoints()
            self.client("/move_base")
            grid = self._firmware.message_class("nav_msgs/OccupancyGrid")
            self.costmap = self.node("/move_base").publisher(COSTMAP_TOPIC, grid, queue_size=1)

    def _add_unconnected_endpoints(self) -> None:
        """Add the endpoints of /ros_interface for parts that this chassis does not have."""
        node = self.node(_RI)
        for topic, type_ in _TOPICS_WITHOUT_SUBSCRIBER.items():
            self._keep.append(node.publisher(topic, self._firmware.message_class(type_), queue_size=1))
        for topic, type_ in _TOPICS_WITHOUT_PUBLISHER.items():
            self._keep.append(node.subscriber(topic, self._firmware.message_class(type_), callback=_ignore))
        for name, type_ in _ACTIONS_WITHOUT_SERVER.items():
            action = self._firmware.message_class(f"{type_}Action")
            self._keep.append(rosproto.ActionClient(node, name, action, status_timeout=None))

    def _class_of(self, row: Row) -> type[DynamicMessage]:
        if row.type in _ASSUMED:
            return rosproto.define(row.type, _ASSUMED[row.type])
        return self._firmware.message_class(row.type)

    def _publish(self, row: Row) -> None:
        latch = (
            bool(row.latched) or row.type in _ASSUMED or (row.name == "/robot_status" and self._latch_status)
        )
        providers = row.providers if self._full else row.providers[:1]
        type_ = self._class_of(row)
        for name in providers:
            publisher = self.node(name).publisher(row.name, type_, latch=latch, queue_size=10)
            self.publishers[name, row.name] = publisher
        if self._full:
            for name in row.listeners:
                self._keep.append(self.node(name).subscriber(row.name, type_, callback=_ignore, queue_size=1))

    def _listen(self, row: Row) -> None:
        providers = row.providers if self._full else row.providers[-1:]
        for index, name in enumerate(providers):
            obey = self._server.topics.get(row.name, _ignore) if index == 0 else _ignore
            type_ = self._class_of(row)
            callback = partial(self._receive, row, obey)
            self._keep.append(self.node(name).subscriber(row.name, type_, callback=callback, queue_size=10))
        if self._full:
            for name in row.written_by:
                # Seen on the shelf's light strip: the robot itself writes to the alias.
                for topic in row.aliases or (row.name,):
                    self._keep.append(self.node(name).publisher(topic, self._class_of(row), queue_size=1))

    def _receive(self, row: Row, obey: Callable[[DynamicMessage], object], message: DynamicMessage) -> None:
        if row.definition_known:
            message = self._firmware.convert(message, message_type(row.type))
        self._network.carry(lambda: self._handle_message(row.name, obey, message))

    def _handle_message(
        self, topic: str, obey: Callable[[DynamicMessage], object], message: DynamicMessage
    ) -> None:
        self.heard[topic] = message
        obey(message)

    def _serve(self, row: Row) -> None:
        firmware, handler = self._firmware, self._server.services[row.name]
        theirs = firmware.service_class(row.type)
        request, response = message_type(f"{row.type}Request"), message_type(f"{row.type}Response")

        def handle(message: DynamicMessage) -> DynamicMessage:
            self._network.travel()  # the request
            answer = handler(firmware.convert(message, request))
            self._network.travel()  # the response
            return firmware.convert(response(**answer), theirs._response_class)

        self._keep.append(self.node(row.providers[0]).service_server(row.name, theirs, handle))

    def _act(self, row: Row) -> None:
        handler = self._server.actions.get(row.name) or partial(self._server.accessory, row.type)
        node = self.node(row.providers[0])
        type_ = self._firmware.message_class(f"{row.type}Action")

        def handle(goal: ServerGoal) -> None:
            handler(RobotGoal(self._firmware, self._network, row.type, goal))

        self._keep.append(rosproto.ActionServer(node, row.name, type_, handle))
        if self._full:
            self.client(row.name)
            for name in row.listeners:
                goal = action_type(type_).action_goal
                listener = self.node(name).subscriber(f"{row.name}/goal", goal, callback=_ignore)
                self._keep.append(listener)

    def client(self, name: str) -> rosproto.ActionClient:
        """The client of /ros_interface for an action server, by which the robot itself sends goals."""
        if name not in self.internal_clients:
            row = interface.row(name)
            type_ = self._firmware.message_class(f"{row.type}Action")
            # Without a time-out: a simulated interruption does not affect links within the robot.
            self.internal_clients[name] = rosproto.ActionClient(
                self.node(_RI), name, type_, status_timeout=None
            )
        return self.internal_clients[name]

    def first(self, topic: str) -> rosproto.Publisher | None:
        """The publisher of a topic's content (that of the first provider)."""
        row = interface.row(topic)
        return self.publishers.get((row.providers[0], topic))

    def is_heard(self, publisher: rosproto.Publisher) -> bool:
        """Whether anybody but the robot's own nodes, which ignore what it measures, is connected."""
        return any(name not in self.nodes for name in publisher.subscribers)

    def check_master_now(self) -> None:
        """Make every node register again, after the master was replaced."""
        for node in self.nodes.values():
            node.check_master_now()

    def close(self) -> None:
        """Close all nodes."""
        for node in self.nodes.values():
            node.close()


def _ignore(message: DynamicMessage) -> None:
    """Callback for topics that have no effect in the simulation."""


class RobotGoal:
    """A `ServerGoal` with goal, feedback and result in the current definitions, whatever the firmware.

    The network delays its arrival and its cancel.
    """

    def __init__(self, firmware: Firmware, network: Network, type_name: str, goal: ServerGoal) -> None:
        self._firmware, self._network, self._goal = firmware, network, goal
        self._result = firmware.message_class(f"{type_name}Result")
        self._feedback = firmware.message_class(f"{type_name}Feedback")
        self.goal = firmware.convert(goal.goal, message_type(f"{type_name}Goal"))
        self._cancel_arrives: float | None = None
        network.travel()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._goal, name)

    def cancel_arrived(self) -> bool:
        """Whether a cancel request has arrived.

        Its delay begins with the first call that finds it, so this must be called repeatedly.
        """
        if not self._goal.cancel_requested:
            return False
        if self._cancel_arrives is None:
            self._cancel_arrives = self._network.arrival()
        return time.monotonic() >= self._cancel_arrives

    def publish_feedback(self, feedback: DynamicMessage) -> None:
        """See `ServerGoal`."""
        self._goal.publish_feedback(self._firmware.convert(feedback, self._feedback))

    def succeed(self, result: DynamicMessage | None = None, text: str = "") -> None:
        """See `ServerGoal`."""
        self._goal.succeed(self._converted(result), text)

    def abort(self, result: DynamicMessage | None = None, text: str = "") -> None:
        """See `ServerGoal`."""
        self._goal.abort(self._converted(result), text)

    def preempted(self, result: DynamicMessage | None = None, text: str = "") -> None:
        """See `ServerGoal`."""
        self._goal.preempted(self._converted(result), text)

    def _converted(self, result: DynamicMessage | None) -> DynamicMessage | None:
        return None if result is None else self._firmware.convert(result, self._result)
