"""Assembles the parts of one node, joins the master, and closes everything in a fixed order.

`Node` (`node.py`) is the public API above. Below are `Context`, the packages `graph`, `definitions`,
`incoming`, `outgoing` and `services`, and the table of topics. Parts call upwards by callables passed here;
nothing below `node.py` imports `Node`.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from functools import partial
from typing import TYPE_CHECKING

from rosproto.node import shutdown
from rosproto.node.clock import NodeClock
from rosproto.node.context import Context
from rosproto.node.graph.listening import Listen, open_endpoints
from rosproto.node.graph.master_monitor import MasterMonitor
from rosproto.node.graph.slave_api import SlaveApi
from rosproto.node.graph.startup import GraphSettings, join
from rosproto.node.naming import NodeNaming
from rosproto.node.parameters import Parameters
from rosproto.node.stats import NodeStats
from rosproto.node.topics import TopicTable
from rosproto.transport.deadline import Deadline

if TYPE_CHECKING:
    from rosproto.node.services.table import Services


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
        address, master = context.listening, context.master_connection
        self.slave = SlaveApi(
            name=context.name,
            master=context.master,
            topics=self.topics,
            own_uri=lambda: address.uri,
            tcpros_address=lambda: (address.host, address.endpoints.tcpros.port),
            is_master_address=lambda host: master.is_at(host, own_host=address.host),
            shut_down=partial(shutdown.shut_down_later, context.name, self.close, on_shutdown_request),
            allow_shutdown=allow_shutdown,
        )
        self._listen: Listen = partial(
            open_endpoints,
            master=master.address,
            port=port,
            tcpros_port=tcpros_port,
            limits=context.limits,
            allow=None if allow is None else frozenset(allow),
            name=context.name,
            dispatch=self.slave.dispatch,
            on_topic=self.topics.accept,
        )
        self.master_monitor = MasterMonitor(
            context.name,
            master=master,
            listening=address,
            registrations=context.registrations,
            topics=self.topics,
            closed=lambda: context.lifecycle.closed,
            listen=self._listen,
            moved=self._moved,
            emit=context.events.emit,
        )
        context.check_publishers = self.master_monitor.verify
        context.lifecycle.fork_callbacks.append(self._abandon)

    def join(self, timeout: float) -> GraphSettings:
        """Find the master and listen.

        Raises:
            ConnectionLost, RosTimeout: The node cannot join; everything is closed.
        """
        context = self.context
        try:
            return join(
                context.name,
                context.master_connection,
                context.listening,
                self._listen,
                Deadline(timeout),
            )
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
            master_lost=context.master_connection.lost,
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
            partial(self.master_monitor.close, seconds),
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
