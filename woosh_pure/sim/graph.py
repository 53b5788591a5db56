"""`Graph`: the nodes of the simulated chassis with their real names, and every row of the interface table on
them."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import rosproto
from rosproto.action import ServerGoal, action_type
from rosproto.codec import DynamicMessage, ServiceType
from rosproto.node import LocalNodes, OwnDefinitionsOnly
from woosh_pure import interface
from woosh_pure.firmware.versions import Firmware
from woosh_pure.interface.schema import Row
from woosh_pure.served_graph.graph import ServedGraph, ignore
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


class Graph(ServedGraph):
    """All rows of the interface, on the nodes of a real chassis, through the simulated network.

    Attributes:
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
        super().__init__(server, self._make_node)
        self._uri, self._host, self._full = master_uri, host, full
        self._own_master = own_master is not None
        self._firmware = firmware
        self._latch_status = latch_status
        self._network = network
        self._assumed_types = assumed_types
        self._server = server
        self.heard: dict[str, DynamicMessage] = {}
        self.costmap: rosproto.Publisher | None = None
        # Reported as TCPROS, as between the real nodes.
        self._robot = LocalNodes(told_as="TCPROS", master=own_master)
        self.internal_clients: dict[str, rosproto.ActionClient] = {}

    def _make_node(self, name: str) -> rosproto.Node:
        """Make a node.

        Links to other programs are real sockets, also within this process; links between the robot's nodes
        are not.
        It refuses every definition but its own, as the real node does: the client must adapt.
        """
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
        return node

    def build_all(self) -> None:
        """Create all nodes and their parts."""
        self.build(row for row in interface.ROWS if row.definition_known or self._assumed_types)

    def _add_more(self) -> None:
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
            self._keep.append(node.subscriber(topic, self._firmware.message_class(type_), callback=ignore))
        for name, type_ in _ACTIONS_WITHOUT_SERVER.items():
            action = self._firmware.message_class(f"{type_}Action")
            self._keep.append(rosproto.ActionClient(node, name, action, status_timeout=None))

    def _class_of(self, row: Row) -> type[DynamicMessage]:
        if row.type in _ASSUMED:
            return rosproto.define(row.type, _ASSUMED[row.type])
        return self._firmware.message_class(row.type)

    def publish(self, row: Row) -> None:
        """Publish a topic by all its providers, and subscribe to it as the real nodes do."""
        latch = (
            bool(row.latched) or row.type in _ASSUMED or (row.name == "/robot_status" and self._latch_status)
        )
        for name in row.providers if self._full else row.providers[:1]:
            super().publish(replace(row, providers=(name,), latched=latch))
        if self._full:
            type_ = self._class_of(row)
            for name in row.listeners:
                self._keep.append(self.node(name).subscriber(row.name, type_, callback=ignore, queue_size=1))

    def listen(self, row: Row) -> None:
        """Subscribe to a topic by all its providers, of which the first obeys."""
        providers = row.providers if self._full else row.providers[-1:]
        for index, name in enumerate(providers):
            self._subscribe(row, name, self._server.topics.get(row.name, ignore) if index == 0 else ignore)
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

    def _service(self, row: Row) -> tuple[type[ServiceType], Callable[[DynamicMessage], DynamicMessage]]:
        firmware, handler = self._firmware, self._server.services[row.name]
        theirs = firmware.service_class(row.type)
        request, response = message_type(f"{row.type}Request"), message_type(f"{row.type}Response")

        def handle(message: DynamicMessage) -> DynamicMessage:
            self._network.travel()  # the request
            answer = handler(firmware.convert(message, request))
            self._network.travel()  # the response
            return firmware.convert(response(**answer), theirs._response_class)

        return theirs, handle

    def _action(self, row: Row) -> tuple[type[DynamicMessage], Callable[[ServerGoal], object]]:
        handler = self._server.actions.get(row.name) or partial(self._server.accessory, row.type)

        def handle(goal: ServerGoal) -> None:
            handler(RobotGoal(self._firmware, self._network, row.type, goal))

        return self._firmware.message_class(f"{row.type}Action"), handle

    def _act(self, row: Row) -> None:
        super()._act(row)
        if self._full:
            self.client(row.name)
            type_ = self._firmware.message_class(f"{row.type}Action")
            for name in row.listeners:
                goal = action_type(type_).action_goal
                listener = self.node(name).subscriber(f"{row.name}/goal", goal, callback=ignore)
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

    def check_master_now(self) -> None:
        """Make every node register again, after the master was replaced."""
        for node in self.nodes.values():
            node.check_master_now()


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
        arrives = self._network.earlier(self._cancel_arrives)
        return time.monotonic() >= arrives

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
