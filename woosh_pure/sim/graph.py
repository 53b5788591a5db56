"""The ROS graph of the simulated chassis: nodes with the real names, and every row of the table on them."""

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
"""Types whose definition is not published: what the simulated chassis has instead; clients learn it."""

_PATIENCE = {True: 60.0, False: 10.0}
"""Seconds for a node to find the master. One of our own is there; only a busy computer makes it late."""
_PERIOD, _SELDOM = 5.0, 12  # s between looks at our own master; looks between comparisons of the graph

_RI = "/ros_interface"
_NOBODY_LISTENS = {
    "/enable_follower": "std_msgs/Bool",
    "/follow_base/local_costmap/set_footprint": "geometry_msgs/Polygon",
}
_NOBODY_PUBLISHES = {"/follow/remote_control_request": "woosh_msgs/IOs"}
_NOBODY_SERVES = {"/xarm_base": "woosh_msgs/Arm"}


class Handlers(Protocol):
    """What answers on the graph; `woosh_pure.sim.ros_handlers.Server` is one."""

    @property
    def services(self) -> Mapping[str, Callable[[Any], dict[str, object]]]:
        """By name: from a request to the fields of its reply."""

    @property
    def topics(self) -> Mapping[str, Callable[[Any], None]]:
        """By name: what obeys a message."""

    @property
    def actions(self) -> Mapping[str, Callable[[Any], None]]:
        """By name: what carries out a goal."""

    def accessory(self, action_type: str, goal: Any) -> None:
        """Carry out a goal of a server without a handler of its own."""

    def distant(self, handler: Callable[[Any], object]) -> Callable[[Any], object]:
        """An action's handler behind the network."""


class Graph:
    """Nodes, publishers, subscribers, services and action servers, by name.

    Attributes:
        nodes: By name.
        publishers: (node, topic) to publisher.
        lights: Last LED message of each strip, by topic.
        heard: Last message on each written topic.
        costmap: The navigation's, which is in no table (assumed).
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
        # Told as the real one's nodes are connected.
        self._robot = LocalNodes(told_as="TCPROS", master=own_master)
        self.internal_clients: dict[str, rosproto.ActionClient] = {}

    def node(self, name: str) -> rosproto.Node:
        """The node of that name, made on first use.

        Its links to others are real sockets also within this process; those of the robot within itself need
        none. It refuses every definition that is not its own, as the real one does: to agree is the client's
        part.
        """
        if name not in self.nodes:
            node = RobotNode(
                name,
                self._network,
                master_uri=self._uri,
                host=self._host,
                intraprocess=self._robot,
                timeout=_PATIENCE[self._own_master],
            )
            if self._own_master:
                # Nothing is lost between it and us, and its restart is told (`look_at_master`). Forty nodes
                # that asked for it every second were most of what an idle robot cost.
                node.watch_master(period=_PERIOD, full_check_every=_SELDOM)
            node.revisions = OwnDefinitionsOnly()
            if self._building is not None:
                self._building.enter_context(node.registering())
            self.nodes[name] = node
        return self.nodes[name]

    def build(self) -> None:
        """Bring everything up."""
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
                self._leave_loose_ends()
            self.client("/move_base")
            grid = self._firmware.message_class("nav_msgs/OccupancyGrid")
            self.costmap = self.node("/move_base").publisher(COSTMAP, grid, queue_size=1)

    def _leave_loose_ends(self) -> None:
        """What /ros_interface has ready for parts that this chassis does not have."""
        node = self.node(_RI)
        for topic, type_ in _NOBODY_LISTENS.items():
            self._keep.append(node.publisher(topic, self._firmware.message_class(type_), queue_size=1))
        for topic, type_ in _NOBODY_PUBLISHES.items():
            self._keep.append(node.subscriber(topic, self._firmware.message_class(type_), callback=_ignore))
        for name, type_ in _NOBODY_SERVES.items():
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
            callback = partial(self._hear, row.name, obey)
            if row.definition_known:
                callback = revised_listener(self._firmware, row.type, callback)
            type_ = self._class_of(row)
            self._keep.append(self.node(name).subscriber(row.name, type_, callback=callback, queue_size=10))
        if self._full:
            for name in row.written_by:
                # Seen on the shelf's strip: the robot itself writes it under its other name.
                for topic in row.aliases or (row.name,):
                    self._keep.append(self.node(name).publisher(topic, self._class_of(row), queue_size=1))

    def _hear(self, topic: str, obey: Callable[[Any], object], message: Any) -> None:
        self._network.carry(lambda: self._obey(topic, obey, message))

    def _obey(self, topic: str, obey: Callable[[Any], object], message: Any) -> None:
        self.heard[topic] = message
        obey(message)

    def _serve(self, row: Row) -> None:
        node = self.node(row.providers[0])
        handler = self._distant(revised_service(self._firmware, row.type, self._server.services[row.name]))
        self._keep.append(node.service_server(row.name, self._firmware.service_class(row.type), handler))

    def _distant(self, handler: Callable[[Any], Any]) -> Callable[[Any], Any]:
        """A service behind the network: request and reply take their time."""

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
        revised = revised_action(self._firmware, row.type, self._server.distant(handler))
        self._keep.append(rosproto.ActionServer(node, row.name, type_, revised))
        if self._full:
            self.client(row.name)
            for name in row.listeners:
                listener = self.node(name).subscriber(f"{row.name}/goal", type_goal(type_), callback=_ignore)
                self._keep.append(listener)

    def client(self, name: str) -> rosproto.ActionClient:
        """The client /ros_interface keeps on an action server: the robot itself competes with us."""
        if name not in self.internal_clients:
            row = interface.row(name)
            type_ = self._firmware.message_class(f"{row.type}Action")
            # It never takes the server for gone: what a dropped link keeps back reaches the robot itself.
            self.internal_clients[name] = rosproto.ActionClient(
                self.node(_RI), name, type_, status_timeout=None
            )
        return self.internal_clients[name]

    def first(self, topic: str) -> rosproto.Publisher | None:
        """The publisher that carries a topic's content (the first provider's)."""
        row = interface.row(topic)
        return self.publishers.get((row.providers[0], topic))

    def look_at_master(self) -> None:
        """The master was replaced: have every node register again."""
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
    """For topics that the real node subscribes to, and that change nothing here."""


# -- an older firmware: on the wire it has that firmware's definitions ---------------------------------------
#
# Handlers and fillers know the current definitions only. On the way out and in, messages are carried over by
# field name, as the real robot's program was written for its own.


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
