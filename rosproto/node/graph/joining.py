"""How a node joins its master: find it, ask what the start depends on, listen; and listen elsewhere later."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosproto.errors import ConnectionLost, MasterError, RosError, RosTimeout
from rosproto.node.graph import replies
from rosproto.node.graph.endpoints import Endpoints, listening_address, open_endpoints
from rosproto.node.incoming import local_link as intraprocess
from rosproto.records import NamedTuple
from rosproto.transport.address import resolve

if TYPE_CHECKING:
    from rosproto.node.graph.master_client import MasterClient
    from rosproto.node.node import Node
    from rosproto.transport.deadline import Deadline

__all__ = ["GraphFacts", "ask_facts", "join", "rebind"]

REBIND_SECONDS = 1.0  # for looking up names, and for ending what used the old address


class GraphFacts(NamedTuple):
    """What holds for the whole graph while a node is open.

    Attributes:
        simulated: Time comes from /clock.
        rosout_topics: Records on /rosout list the topics of their node.
    """

    simulated: bool
    rosout_topics: bool


def ask_facts(master: MasterClient, timeout: float | None) -> GraphFacts:
    """Ask a master, in one request, whether it is one and how its graph is set up.

    Raises:
        ConnectionLost, RosTimeout: Nobody answers.
        RosError: What answers is no master.
    """
    pid, sim_time, no_topics = master.several(
        [
            ("getPid", ()),
            ("getParam", ("/use_sim_time",)),
            ("getParam", ("/rosout_disable_topics_generation",)),
        ],
        timeout=timeout,
    )
    if isinstance(pid, MasterError):
        raise pid
    replies.checked("getPid", master.uri, pid, replies.as_int)
    return GraphFacts(
        simulated=sim_time is True,  # an error means that it is not set
        rosout_topics=isinstance(no_topics, MasterError) or not no_topics,
    )


def join(node: Node, deadline: Deadline) -> tuple[Endpoints, GraphFacts]:
    """Find the master, then listen: a node that cannot register need not open a port.

    Raises:
        ConnectionLost, RosTimeout: The node cannot join; the text names it and the master.
    """
    try:
        facts = ask_facts(node._master, deadline.remaining())
        node._master_hosts = frozenset(resolve(node._master_address[0], deadline))
        announced, bind = listening_address(
            node._host_given, node._master_address, deadline.remaining() or 0.1
        )
        return open_endpoints(announced, bind, node._master_address, **node._endpoint_options), facts
    except RosError as error:
        raise _cannot_join(node, error) from error


def _cannot_join(node: Node, error: RosError) -> RosError:
    text = f"node {node.name} cannot join the master {node.master_uri}: {error}"
    if isinstance(error, RosTimeout):
        return RosTimeout(text, what=f"the master {node.master_uri}", seconds=error.seconds)
    return ConnectionLost(text, peer=node.master_uri)


def rebind(node: Node) -> bool:
    """Listen on our present address towards the master, when it is another one now; True when it is.

    Raises:
        RosError: There is no way to the master at present, or nothing can be listened on.
    """
    if node._host_given is not None:
        return False
    announced, bind = listening_address(None, node._master_address, REBIND_SECONDS)
    old = node._endpoints
    if announced == old.host:
        return False
    new = open_endpoints(announced, bind, node._master_address, **node._endpoint_options)
    new.tcpros.on_service = old.tcpros.on_service
    node._endpoints = new
    if node._intraprocess:
        intraprocess.forget_node(old.uri, node)
        intraprocess.note_node(node)
    old.close(REBIND_SECONDS)
    node._topics.links_changed_address()
    return True
