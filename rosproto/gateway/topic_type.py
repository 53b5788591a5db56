"""The type of a topic in the graph, which a client's type is compared with."""

from __future__ import annotations

from rosproto.gateway.access import Refused
from rosproto.node import Node


def topic_type(node: Node, topic: str) -> str | None:
    """The type of a topic by the master; None if unknown.

    Raises:
        MasterError, ConnectionLost, RosTimeout: The master does not answer.
    """
    known = node.master.get_topic_types().get(topic)
    return None if known in (None, "", "*") else known


def insist_type(node: Node, topic: str, type_name: str) -> None:
    """Check a client's type of a topic.

    The master also remembers types of nodes that have left; a type that no other node uses does not count.

    Raises:
        Refused: Other nodes use the topic with another type.
        MasterError, ConnectionLost, RosTimeout: The master does not answer.
    """
    known = topic_type(node, topic)
    if known is None or known == type_name:
        return
    state = node.master.get_system_state()
    if {*state.publishers.get(topic, ()), *state.subscribers.get(topic, ())} - {node.name}:
        raise Refused(f"{topic} is of type {known}, not {type_name[:200]}")
