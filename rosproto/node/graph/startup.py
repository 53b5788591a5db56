"""How a node joins the graph: it asks the master for the graph's settings, then opens its servers."""

from __future__ import annotations

from typing import NamedTuple

from rosproto.errors import ConnectionLost, MasterError, RosError, RosTimeout
from rosproto.node.graph import api_client
from rosproto.node.graph.listening import Listen, Listening
from rosproto.node.graph.master_client import MasterClient
from rosproto.node.graph.master_connection import MasterConnection
from rosproto.sentence import say
from rosproto.transport.deadline import Deadline
from rosproto.transport.name_lookup import resolve


class GraphSettings(NamedTuple):
    """Settings of the whole graph, read once when a node joins.

    Attributes:
        simulated: Time comes from /clock.
        rosout_topics: Records on /rosout list the topics of their node.
    """

    simulated: bool
    rosout_topics: bool


def ask_settings(master: MasterClient, timeout: float | None) -> GraphSettings:
    """Ask a master, in one request, for its process id and the graph's settings.

    Raises:
        ConnectionLost, RosTimeout: There is no answer.
        RosError: The answer is not a master's.
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
    api_client.checked("getPid", master.uri, pid, api_client.as_int)
    return GraphSettings(
        simulated=sim_time is True,  # an error means that it is not set
        rosout_topics=isinstance(no_topics, MasterError) or not no_topics,
    )


def join(
    name: str, master: MasterConnection, address: Listening, listen: Listen, deadline: Deadline
) -> GraphSettings:
    """Find the master, then listen: a node that cannot register need not open a port.

    Raises:
        ConnectionLost, RosTimeout: The node cannot join; the text names it and the master.
    """
    try:
        settings = ask_settings(master.client, deadline.remaining())
        master.host_addresses = frozenset(resolve(master.address[0], deadline))
        address.open(listen, master.address, deadline.remaining() or 0.1)
        return settings
    except RosError as error:
        raise _cannot_join(name, master.uri, error) from error


def _cannot_join(name: str, uri: str, error: RosError) -> RosError:
    text = say("node {name} cannot join the master {uri}: {error}", name=name, uri=uri, error=error)
    why = error.why or str(error)
    if isinstance(error, RosTimeout):
        return RosTimeout(text, what=f"the master {uri}", seconds=error.seconds, peer=uri, why=why)
    return ConnectionLost(text, peer=uri, why=why)
