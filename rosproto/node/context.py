"""State shared by topics and services of one node: identity, limits, master, address, registrations, events.

`NodeParts` (`parts.py`) makes one `Context` for each node. A part that uses only one or two of its attributes
gets those, not the context.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from typing import Any

from rosproto.logs import PeerLog
from rosproto.node.definitions.known_definitions import KnownDefinitions
from rosproto.node.events import Event, Events
from rosproto.node.graph.listening import Listening
from rosproto.node.graph.master_connection import MasterConnection
from rosproto.node.graph.registrations import Registrations
from rosproto.node.incoming.local_nodes import LocalNodes, chosen
from rosproto.node.outgoing.link_monitor import LinkMonitor
from rosproto.node.shutdown import Lifecycle
from rosproto.protocol.wire_limits import Limits
from rosproto.transport import HostNames, XmlRpcClient
from rosproto.transport.deadline import Deadline
from rosproto.transport.uri import parse_uri

FAREWELL_SECONDS = 2.0  # for unregistering; the master monitor completes the rest later


class Context:
    """State shared by the topics and services of one node.

    Attributes:
        name: Global name of the node.
        limits: Bounds for requests of peers.
        revisions: Known definitions, to convert between revisions of a type.
        hosts: Addresses of host names that this computer may not know.
        lifecycle: Open, closing or closed.
        master_connection: The master's address, and whether it answers.
        master: The client of `master_connection`.
        listening: The node's present servers and address.
        registrations: All registrations at the master; the master monitor repeats them after a restart of
            the master or a change of our address.
        link_monitor: The thread that watches all subscribers.
        events: The latest events; `emit` adds one and calls `on_event`.
        peer_log: Bounded log of events that peers cause.
        local_nodes: Nodes of this process that are connected without sockets; None to use sockets only.
        check_publishers: Called with a subscription, to query its publishers at the master.
    """

    def __init__(
        self,
        name: str,
        *,
        master_uri: str,
        host: str | None,
        limits: Limits,
        revisions: KnownDefinitions,
        hosts: Mapping[str, str],
        intraprocess: bool | LocalNodes,
        on_event: Callable[[Event], object] | None,
    ) -> None:
        self.name = name
        self.limits = limits
        self.revisions = revisions
        self.local_nodes = chosen(intraprocess)
        self.peer_log = PeerLog("rosproto.node")
        self.events = Events(name, on_event)
        self.lifecycle = Lifecycle()
        self.check_publishers: Callable[[Any], None] = lambda subscription: None
        self._link_ids = itertools.count(1)
        self.hosts = HostNames(hosts, master=parse_uri(master_uri)[0])
        self.listening = Listening(host)
        self.master_connection = connection = MasterConnection(
            master_uri,
            name,
            limits=limits,
            hosts=self.hosts,
            local_client=lambda seconds: self._local_client(master_uri, seconds),
        )
        self.master = connection.client
        self.link_monitor = LinkMonitor(name)
        self.registrations = Registrations(
            self.master, self.master.within(FAREWELL_SECONDS), lambda: connection.lost
        )

    def _local_client(self, uri: str, seconds: float) -> XmlRpcClient | None:
        if self.local_nodes is None:
            return None
        return self.local_nodes.calls_to(uri, limits=self.limits, timeout=seconds, hosts=self.hosts)

    @property
    def uri(self) -> str:
        """Present XML-RPC URI of the node's slave API."""
        return self.listening.uri

    def next_link_id(self) -> int:
        """A number for a connection, in getBusInfo."""
        return next(self._link_ids)

    def leave_master(self, seconds: float) -> None:
        """Unregister everything, if the master answers."""
        if not self.master_connection.lost:
            # A separate client: a call that hangs in `master` must not use up the time.
            with self.master_connection.new_client(seconds) as master:
                self.registrations.unregister_all(Deadline(seconds), master)

    def close_servers(self, seconds: float) -> None:
        """Close the servers, the link monitor and the client of the master."""
        self.listening.endpoints.close(seconds)
        self.link_monitor.close(seconds)
        self.master.close()

    def give_up(self) -> None:
        """Close a node that could not listen and has registered nothing."""
        self.master.close()
        self.link_monitor.close()
        self.lifecycle.end()
