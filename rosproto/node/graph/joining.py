"""How a node joins its master: find it, ask what the start depends on, listen; and listen elsewhere later."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from rosproto.errors import ConnectionLost, MasterError, RosError, RosTimeout
from rosproto.node.context import Context
from rosproto.node.graph import replies
from rosproto.node.graph.endpoints import Endpoints, listening_address
from rosproto.node.graph.master_client import MasterClient
from rosproto.sentence import say
from rosproto.transport.address import resolve
from rosproto.transport.deadline import Deadline

REBIND_SECONDS = 1.0  # for looking up names, and for ending what used the old address


Listen = Callable[[str, str], Endpoints]
"""Opens the servers of the node: the host to announce, the address to listen on."""


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


def join(context: Context, listen: Listen, deadline: Deadline) -> tuple[Endpoints, GraphFacts]:
    """Find the master, then listen: a node that cannot register need not open a port.

    Raises:
        ConnectionLost, RosTimeout: The node cannot join; the text names it and the master.
    """
    try:
        facts = ask_facts(context.master, deadline.remaining())
        context.master_hosts = frozenset(resolve(context.master_address[0], deadline))
        announced, bind = listening_address(
            context.host_given, context.master_address, deadline.remaining() or 0.1
        )
        return listen(announced, bind), facts
    except RosError as error:
        raise _cannot_join(context, error) from error


def _cannot_join(context: Context, error: RosError) -> RosError:
    cannot = "node {name} cannot join the master {uri}: {error}"
    text = say(cannot, name=context.name, uri=context.master_uri, error=error)
    peer, why = context.master_uri, error.why or str(error)
    if isinstance(error, RosTimeout):
        what = f"the master {context.master_uri}"
        return RosTimeout(text, what=what, seconds=error.seconds, peer=peer, why=why)
    return ConnectionLost(text, peer=peer, why=why)


def rebind(context: Context, listen: Listen, moved: Callable[[str], None]) -> bool:
    """Listen on our present address towards the master, when it is another one now; True when it is.

    `moved` is called with the URI that holds no more, before what used it ends.

    Raises:
        RosError: There is no way to the master at present, or nothing can be listened on.
    """
    if context.host_given is not None:
        return False
    announced, bind = listening_address(None, context.master_address, REBIND_SECONDS)
    old = context.endpoints
    if announced == old.host:
        return False
    new = listen(announced, bind)
    new.tcpros.on_service = old.tcpros.on_service
    context.endpoints = new
    moved(old.uri)
    old.close(REBIND_SECONDS)
    return True
