"""`Graph`: the nodes of the simulated chassis with their real names, and every row of the interface table on
them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import ExitStack
from functools import partial
from typing import Any, Protocol

import rosproto
from rosproto.action import action_type
from rosproto.node import LocalNodes, OwnDefinitionsOnly
from woosh_pure import interface
from woosh_pure.firmware.versions import Firmware
from woosh_pure.interface.schema import Row
from woosh_pure.sim.costmap import TOPIC as COSTMAP
from woosh_pure.sim.network import Network, RobotNode
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


class Handlers(Protocol):
    """The part of `woosh_pure.sim.ros_handlers.RosHandlers` that the graph uses."""

    @property
    def services(self) -> Mapping[str, Callable[[Any], dict[str, object]]]:
        """Service handlers by name: from a request to the fields of its reply."""

    @property
    def topics(self) -> Mapping[str, Callable[[Any], None]]:
        """Message handlers by topic."""

    @property
    def actions(self) -> Mapping[str, Callable[[Any], None]]:
        """Goal handlers by action name."""

    def accessory(self, action_type: str, goal: Any) -> None:
        """Handle a goal of any other action server."""

    def delayed(self, handler: Callable[[Any], object]) -> Callable[[Any], object]:
        """Delay an action's handler by the network."""


class Graph:
    """Nodes, publishers, subscribers, services and action servers, by name.

    Attributes:
        nodes: By name.
        publishers: (node, topic) to publisher.
        lights: Last LED message of each strip, by topic.
        heard: Last message on each written topic.
        costmap: Publisher of the navigation's costmap, which is not in the table (assumed).
    """

    def __init__(
        self,
        master_uri: str,
        server: Handlers,
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
        self.heard: dict[str, Any] = {}
        self.costmap: rosproto.Publisher | None = None
        self._keep: list[Any] = []
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
                # A restart is announced by `look_at_master`. Checks every second by forty nodes were most of
                # the processor time of an idle robot.
                node.watch_master(period=_PERIOD, full_check_every=_SELDOM)
            node.revisions = OwnDefinitionsOnly()
            if self._building is not None:
                self._building.enter_context(node.registering())
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
            self.costmap = self.node("/move_base").publisher(COSTMAP, grid, queue_size=1)

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

    def _class_of(self, row: Row) -> Any:
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
            callback = partial(self._receive, row.name, obey)
            if row.definition_known:
                callback = revised_listener(self._firmware, row.type, callback)
            type_ = self._class_of(row)
            self._keep.append(self.node(name).subscriber(row.name, type_, callback=callback, queue_size=10))
        if self._full:
            for name in row.written_by:
                # Seen on the shelf's light strip: the robot itself writes to the alias.
                for topic in row.aliases or (row.name,):
                    self._keep.append(self.node(name).publisher(topic, self._class_of(row), queue_size=1))

    def _receive(self, topic: str, obey: Callable[[Any], object], message: Any) -> None:
        self._network.carry(lambda: self._handle_message(topic, obey, message))

    def _handle_message(self, topic: str, obey: Callable[[Any], object], message: Any) -> None:
        self.heard[topic] = message
        obey(message)

    def _serve(self, row: Row) -> None:
        node = self.node(row.providers[0])
        handler = self._delayed_service(
            revised_service(self._firmware, row.type, self._server.services[row.name])
        )
        self._keep.append(node.service_server(row.name, self._firmware.service_class(row.type), handler))

    def _delayed_service(self, handler: Callable[[Any], Any]) -> Callable[[Any], Any]:
        """Delay a service's request and reply by the network."""

        def handle(request: Any) -> Any:
            self._network.travel()
            reply = handler(request)
            self._network.travel()
            return reply

        return handle

    def _act(self, row: Row) -> None:
        handler = self._server.actions.get(row.name) or partial(self._server.accessory, row.type)
        node = self.node(row.providers[0])
        type_ = self._firmware.message_class(f"{row.type}Action")
        revised = revised_action(self._firmware, row.type, self._server.delayed(handler))
        self._keep.append(rosproto.ActionServer(node, row.name, type_, revised))
        if self._full:
            self.client(row.name)
            for name in row.listeners:
                listener = self.node(name).subscriber(f"{row.name}/goal", type_goal(type_), callback=_ignore)
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

    def look_at_master(self) -> None:
        """Make every node register again, after the master was replaced."""
        for node in self.nodes.values():
            node.look_at_master()

    def close(self) -> None:
        """Close all nodes."""
        for node in self.nodes.values():
            node.close()


def type_goal(action: Any) -> Any:
    """The class of an action's goal messages on the wire."""
    return action_type(action).action_goal


def _ignore(message: Any) -> None:
    """Callback for topics that have no effect in the simulation."""


# -- other firmware versions: conversion from and to their definitions ---------------------------------------
#
# Handlers and fillers use the current definitions only. Messages are converted by field name.


def revised_listener(firmware: Firmware, type_name: str, callback: Callable[[Any], object]) -> Any:
    """A callback for messages in the firmware's definition."""
    ours = message_type(type_name)
    if firmware.message_class(type_name)._md5sum == ours._md5sum:
        return callback
    return lambda message: callback(firmware.convert(message, ours))


def revised_service(
    firmware: Firmware, type_name: str, handler: Callable[[Any], Any]
) -> Callable[[Any], Any]:
    """A handler for requests in the firmware's definition; the inner one returns a dict of current fields."""
    theirs = firmware.service_class(type_name)
    request, response = message_type(f"{type_name}Request"), message_type(f"{type_name}Response")

    def handle(message: Any) -> Any:
        answer = handler(firmware.convert(message, request))
        return firmware.convert(response(**answer), theirs._response_class)

    return handle


def revised_action(firmware: Firmware, type_name: str, handler: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """A handler for goals in the firmware's definition."""
    return lambda goal: handler(RevisedGoal(firmware, type_name, goal))


class RevisedGoal:
    """A `ServerGoal` whose goal, feedback and result are in the current definitions."""

    def __init__(self, firmware: Firmware, type_name: str, goal: Any) -> None:
        self._firmware = firmware
        self._goal = goal
        self._result = firmware.message_class(f"{type_name}Result")
        self._feedback = firmware.message_class(f"{type_name}Feedback")
        self.goal = firmware.convert(goal.goal, message_type(f"{type_name}Goal"))

    def __getattr__(self, name: str) -> Any:
        return getattr(self._goal, name)

    def publish_feedback(self, feedback: Any) -> None:
        """See `ServerGoal`."""
        self._goal.publish_feedback(self._firmware.convert(feedback, self._feedback))

    def succeed(self, result: Any = None, text: str = "") -> None:
        """See `ServerGoal`."""
        self._goal.succeed(self._old(result), text)

    def abort(self, result: Any = None, text: str = "") -> None:
        """See `ServerGoal`."""
        self._goal.abort(self._old(result), text)

    def preempted(self, result: Any = None, text: str = "") -> None:
        """See `ServerGoal`."""
        self._goal.preempted(self._old(result), text)

    def _old(self, result: Any) -> Any:
        return None if result is None else self._firmware.convert(result, self._result)
