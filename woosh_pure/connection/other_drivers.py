"""Finds other nodes that can drive the base by velocity: other publishers of the velocity topics.

The robot does not arbitrate between publishers: it obeys the last message. Two programs that send different
velocities make it jerk, and a zero of one does not stop the other.

The master informs *subscribers* about publishers, but not publishers; and a subscription of ours would look
as if a base obeyed it. So the graph is read before a drive and periodically during it. Whether a node really
sends is seen from its own counters (`getBusStats`), read twice.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any, cast

import rosproto
from rosproto.errors import ConnectionLost, MasterError, RosError, RosTimeout
from rosproto.node import NodeClient, SystemState
from rosproto.sentence import both, say
from rosproto.transport import parse_uri
from rosproto.watchdog import is_watchdog_name
from woosh_pure.interface.table import ROBOT_NODES, topics

_MASTER, _ASK = 2.0, 1.0  # seconds for the master, and for one node, to answer
_WHOLE_TOPIC = -1  # in place of a connection's number, which is never negative


@dataclass(frozen=True, slots=True)
class OtherDriver:
    """A node that can send velocities.

    Attributes:
        node: Its name.
        topics: The velocity topics it publishes.
        uri: Its address.
        on_robot: It runs on the robot's own computer (and we do not): most likely it is a node of the robot
            that is not in our list.
        answers: False when it is registered, but did not answer in time.
        counters: Sum of the bytes and messages sent so far, by velocity topic and connection number. Empty if
            it does not report them.
    """

    node: str
    topics: tuple[str, ...]
    uri: str
    on_robot: bool = False
    answers: bool = True
    counters: Mapping[tuple[str, int], int] = field(default_factory=dict, compare=False, repr=False)

    def has_sent_since(self, before: OtherDriver | None) -> bool:
        """Whether it has sent something since the earlier check; False if that is not known."""
        if before is None or (before.node, before.uri) != (self.node, self.uri):
            return False
        return any(sent > before.counters.get(link, sent) for link, sent in self.counters.items())

    def sentence(self, *, sends: bool = False) -> str:
        """Describe the node, its address, and the remedy.

        Args:
            sends: Whether it was seen to send.
        """
        if sends:
            who = "{node} ({uri}) also sends velocities on {topics}"
        else:
            who = "{node} ({uri}) can also send velocities on {topics}"
        text = say(who, node=self.node, uri=self.uri, topics=self.topics)
        if self.on_robot:
            return both(text, "it runs on the robot itself, and is treated as part of it")
        if not self.answers:
            gone = "it does not answer: if it has ended, `rosproto node cleanup` removes it from the master"
            return both(text, gone)
        return text


def other_drivers(node: rosproto.Node) -> tuple[OtherDriver, ...]:
    """Return other nodes that can send velocities.

    The robot's own nodes (`interface.ROBOT_NODES`) are left out, and so are the watchdogs of programs
    (`rosproto.watchdog`), which send only when their program is gone. A node whose process has died stays
    registered at the master, so each is called, and dead ones are left out.

    Args:
        node: The calling node.

    Raises:
        ConnectionLost, RosTimeout, MasterError: The master did not answer.
    """
    state = node.master.get_system_state(timeout=_MASTER)
    found: dict[str, list[str]] = {}
    for row in topics("write"):
        for name in state.publishers.get(row.name, ()) if row.bypasses_protection else ():
            if name not in ROBOT_NODES and name != node.name and not is_watchdog_name(name):
                found.setdefault(name, []).append(row.name)
    if not found:
        return ()
    robot = _robot_host(node, state)
    asked = (_ask(node, name, tuple(names), robot) for name, names in sorted(found.items()))
    return tuple(driver for driver in asked if driver is not None)


def is_refused(error: BaseException | None) -> bool:
    """Whether the other computer refused the connection because nothing listens there."""
    while error is not None:
        if isinstance(error, ConnectionRefusedError):
            return True
        error = error.__cause__
    return False


def _robot_host(node: rosproto.Node, state: SystemState) -> str | None:
    """The host of the robot's own nodes; None if that is this computer, or if there are none."""
    own = parse_uri(node.uri)[0]
    for name in state.nodes:
        if name in ROBOT_NODES:
            try:
                host = parse_uri(node.master.lookup_node(name, timeout=_ASK))[0]
            except (RosError, ValueError):
                continue
            return None if host == own else host
    return None


def _ask(node: rosproto.Node, name: str, names: tuple[str, ...], robot: str | None) -> OtherDriver | None:
    """Query the node; None if it no longer exists."""
    try:
        uri = node.master.lookup_node(name, timeout=_ASK)
        if robot is not None and parse_uri(uri)[0] == robot:
            return OtherDriver(name, names, uri, on_robot=True)
        with NodeClient(uri, node.name, timeout=_ASK, hosts=node.hosts) as slave:
            published = {topic for topic, _ in slave.get_publications()}
            counters = _counters(slave, names)
    except MasterError:
        return None  # it has unregistered meanwhile
    except ConnectionLost as error:
        if is_refused(error) and not node.hosts.is_guess(parse_uri(uri)[0]):
            return None  # the computer refuses the connection: the process has ended
        return OtherDriver(name, names, uri, answers=False)
    except RosTimeout:
        return OtherDriver(name, names, uri, answers=False)
    except (RosError, ValueError):
        return OtherDriver(name, names, uri)  # any answer shows that it runs
    still = tuple(topic for topic in names if topic in published)
    return OtherDriver(name, still, uri, counters=counters) if still else None


def _counters(slave: NodeClient, topics: Collection[str]) -> dict[tuple[str, int], int]:
    """Return a node's send counters; {} if it does not report them in a known form.

    wiki.ros.org/ROS/Slave_API: publishStats is [[topic, messageDataSent, [[connectionId, bytesSent, numSent,
    connected], ...]], ...]. roscpp leaves messageDataSent out and has one cell more for each connection, so
    all numbers of a connection are added up.
    """
    counters = {}
    try:
        for name, *between, links in cast("list[list[Any]]", slave.get_bus_stats()[0]):
            if name in topics:
                counters[name, _WHOLE_TOPIC] = sum(cell for cell in between if type(cell) is int)
                for number, *cells in links:
                    counters[name, int(number)] = sum(cell for cell in cells if type(cell) is int)
    except (RosError, IndexError, TypeError, ValueError):
        return {}
    return counters
