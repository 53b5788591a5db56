"""Assembles the parts of one node, joins the master, and closes everything in a fixed order.

A node joins in two steps: it asks the master for the graph's settings, then opens its servers.

`Node` (`node.py`) is the public API above. Below are `Context`, the packages `graph`, `definitions`,
`incoming`, `outgoing` and `services`, and the table of topics. Parts call upwards by callables passed here;
nothing below `node.py` imports `Node`.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

from rosproto.errors import ConnectionLost, MasterError, RosError, RosTimeout
from rosproto.node import shutdown
from rosproto.node.clock import NodeClock
from rosproto.node.context import Context
from rosproto.node.graph import api_client
from rosproto.node.graph.listening import open_endpoints
from rosproto.node.graph.master_client import MasterClient
from rosproto.node.graph.slave_api import SlaveApi
from rosproto.node.master_monitor import MasterMonitor
from rosproto.node.options import NodeNaming
from rosproto.node.parameters import Parameters
from rosproto.node.stats import NodeStats
from rosproto.node.topics import TopicTable
from rosproto.sentence import say
from rosproto.transport.deadline import Deadline
from rosproto.transport.name_lookup import resolve
from rosproto.transport.shared_threads import release_shared_threads

if TYPE_CHECKING:
    from rosproto.node.services.table import Services


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
    pid, sim_time, no_topics = master.batch(
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


class NodeParts:
    """The parts of one node; nothing is opened before `join`.

    Args:
        context: State shared by the parts.
        naming: Resolves names.
        port, tcpros_port, allow, allow_shutdown, on_shutdown_request: See `Node`.

    Attributes:
        context, naming: As given.
        clock, topics, slave, master_monitor: The parts that every node has.
    """

    def __init__(
        self,
        context: Context,
        naming: NodeNaming,
        *,
        port: int,
        tcpros_port: int,
        allow: Iterable[str] | None,
        allow_shutdown: bool,
        on_shutdown_request: Callable[[str], object] | None,
    ) -> None:
        self.context = context
        self.naming = naming
        self.clock = NodeClock()
        self.topics = TopicTable(context)
        self._lock = threading.RLock()
        self._services: Services | None = None
        self._parameters: Parameters | None = None
        address = context.listening
        self.slave = SlaveApi(
            name=context.name,
            master=context.master,
            topics=self.topics,
            own_uri=lambda: address.uri,
            tcpros_address=lambda: (address.host, address.endpoints.tcpros.port),
            is_master_address=context.is_master_address,
            shut_down=partial(shutdown.shut_down_later, context.name, self.close, on_shutdown_request),
            allow_shutdown=allow_shutdown,
        )
        address.listen = partial(
            open_endpoints,
            master=context.master_address,
            port=port,
            tcpros_port=tcpros_port,
            limits=context.limits,
            allow=None if allow is None else frozenset(allow),
            name=context.name,
            dispatch=self.slave.dispatch,
            on_topic=self.topics.accept,
        )
        self.master_monitor = MasterMonitor(context, self.topics, self._moved)
        context.check_publishers = self.master_monitor.check_publishers
        context.lifecycle.fork_callbacks.append(self._abandon)

    def join(self, timeout: float) -> GraphSettings:
        """Find the master, then listen: a node that cannot register need not open a port.

        Raises:
            ConnectionLost, RosTimeout: The node cannot join, the text names it and the master; everything is
                closed.
        """
        context, deadline = self.context, Deadline(timeout)
        try:
            settings = ask_settings(context.master, deadline.remaining())
            context.master_hosts = frozenset(resolve(context.master_address[0], deadline))
            context.listening.open(context.master_address, deadline.remaining() or 0.1)
            return settings
        except RosError as error:
            context.give_up()
            raise _cannot_join(context.name, context.master.uri, error) from error
        except BaseException:
            context.give_up()
            raise

    @property
    def services(self) -> Services:
        """The service servers and clients, made on first use."""
        with self._lock:
            if self._services is None:
                from rosproto.node.services.table import Services

                self._services = Services(self.context)
                self.context.lifecycle.fork_callbacks.append(self._services.abandon)
            return self._services

    @property
    def parameters(self) -> Parameters:
        """The parameter server as a mapping, made on first use."""
        with self._lock:
            if self._parameters is None:
                context = self.context
                self._parameters = Parameters(
                    context.master,
                    context.registrations,
                    own_uri=lambda: context.uri,
                    resolve_name=self.naming.resolve,
                )
                self.slave.on_parameter_update = self._parameters.on_update
            return self._parameters

    def stats(self) -> NodeStats:
        """See `Node.stats`."""
        context = self.context
        return NodeStats(
            name=context.name,
            uri=context.uri,
            master_uri=context.master.uri,
            master_lost=context.master_lost,
            links=tuple(self.topics.link_stats()),
            services={} if self._services is None else self._services.stats(),
        )

    def close(self, reason: str) -> None:
        """Close the node; `reason` is "" if the program closes it."""
        context, seconds = self.context, shutdown.CLOSE_SECONDS
        context.lifecycle.close(
            reason,
            self._forget_local,
            partial(context.leave_master, seconds),
            partial(self.master_monitor.close, seconds),
            self.topics.close,
            partial(context.close_servers, seconds),
            # Again: a call to the master that hung has ended with the client that `close_servers` closed.
            partial(self.master_monitor.close, seconds),
            partial(release_shared_threads, seconds),
        )

    # -- nodes of this process ------------------------------------------------------------------------------

    def note_local(self) -> None:
        """Let other nodes of this process connect without sockets."""
        if self.context.local_nodes is not None:
            self.context.local_nodes.note(self.context.uri, self.topics.publication)

    def _forget_local(self) -> None:
        if self.context.local_nodes is not None:
            self.context.local_nodes.forget(self.context.uri, self.topics.publication)

    def _moved(self, old_uri: str) -> None:
        if self.context.local_nodes is not None:
            self.context.local_nodes.forget(old_uri, self.topics.publication)
            self.note_local()

    def _abandon(self) -> None:
        """Mark the parts as closed in a fork of this process."""
        self.context.master.abandon()
        self.clock.closing = self.context.lifecycle.closing
        self.topics.abandon()


def _cannot_join(name: str, uri: str, error: RosError) -> RosError:
    text = say("node {name} cannot join the master {uri}: {error}", name=name, uri=uri, error=error)
    why = error.why or str(error)
    if isinstance(error, RosTimeout):
        return RosTimeout(text, what=f"the master {uri}", seconds=error.seconds, peer=uri, why=why)
    return ConnectionLost(text, peer=uri, why=why)
