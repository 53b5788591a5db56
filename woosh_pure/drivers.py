"""Who else can drive the base by velocity: other publishers of the velocity topics.

Nothing on the robot decides between two of them: it obeys whatever comes last, so that two programs which
send different velocities shake it, and a zero of one does not stop the other.

The master tells a *subscriber* when publishers come and go, but not a publisher; and a subscription of ours
would look to everybody as if somebody obeyed there. So the graph is asked: before a drive, and now and then
in it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rosproto.errors import ConnectionLost, MasterError, RosError, RosTimeout
from rosproto.node import NodeClient
from rosproto.transport.address import parse_uri

from .interface import ROBOT_NODES, topics

if TYPE_CHECKING:
    import rosproto
    from rosproto.node import SystemState

__all__ = ["OtherDriver", "other_drivers"]

_ASK = 1.0  # seconds for one node to answer


@dataclass(frozen=True, slots=True)
class OtherDriver:
    """A node that can send velocities.

    Attributes:
        node: Its name.
        topics: The velocity topics it publishes.
        uri: Its address.
        on_robot: It runs on the robot's own computer (and we do not): most likely it belongs to the robot,
            under a name that we do not know.
        answers: False when it is registered, but did not answer in time.
    """

    node: str
    topics: tuple[str, ...]
    uri: str
    on_robot: bool = False
    answers: bool = True

    def sentence(self) -> str:
        """Who, where, and what to do about it."""
        text = f"{self.node} ({self.uri}) can send velocities, too, on {' and '.join(self.topics)}"
        if self.on_robot:
            return f"{text}; it runs on the robot itself, and is taken for a part of it"
        if not self.answers:
            text += "; it does not answer: if it has gone, `rosproto node cleanup` takes it off the master"
        return text


def other_drivers(node: rosproto.Node, timeout: float = 2.0) -> tuple[OtherDriver, ...]:
    """Other nodes that can send velocities; the robot's own ones (`interface.ROBOT_NODES`) are left out.

    A node whose process has ended stays registered at the master; it is asked itself, and left out, too.

    Args:
        node: In whose name to ask.
        timeout: Seconds for the master.

    Raises:
        ConnectionLost, RosTimeout, MasterError: The master cannot be asked.
    """
    state = node.master.get_system_state(timeout=timeout)
    found: dict[str, list[str]] = {}
    for row in topics("write"):
        for name in state.publishers.get(row.name, ()) if row.bypasses_protection else ():
            if name not in ROBOT_NODES and name != node.name:
                found.setdefault(name, []).append(row.name)
    if not found:
        return ()
    robot = _robot_host(node, state)
    asked = (_ask(node, name, tuple(names), robot) for name, names in sorted(found.items()))
    return tuple(driver for driver in asked if driver is not None)


def _refused(error: BaseException | None) -> bool:
    while error is not None:
        if isinstance(error, ConnectionRefusedError):
            return True
        error = error.__cause__
    return False


def _robot_host(node: rosproto.Node, state: SystemState) -> str | None:
    """Where the robot's own nodes run; None when that is this computer, too, or when there are none."""
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
    """What the node itself says; None when it is not there any more."""
    try:
        uri = node.master.lookup_node(name, timeout=_ASK)
        if robot is not None and parse_uri(uri)[0] == robot:
            return OtherDriver(name, names, uri, on_robot=True)
        with NodeClient(uri, node.name, timeout=_ASK) as slave:
            published = {topic for topic, _ in slave.get_publications()}
    except MasterError:
        return None  # it has signed off meanwhile
    except ConnectionLost as error:
        if _refused(error):
            return None  # the computer answers, and nobody listens there: the process has ended
        return OtherDriver(name, names, uri, answers=False)
    except RosTimeout:
        return OtherDriver(name, names, uri, answers=False)
    except (RosError, ValueError):
        return OtherDriver(name, names, uri)  # it answers, in whatever way
    still = tuple(topic for topic in names if topic in published)
    return OtherDriver(name, still, uri) if still else None
