"""State shared by topics and services of one node: identity, limits, master, address, registrations, events.

`NodeParts` (`parts.py`) makes one `Context` for each node. A part that uses only one or two of its attributes
gets those, not the context.
"""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from rosproto.errors import ConnectionLost
from rosproto.logs import PeerLog
from rosproto.node.definitions.known_definitions import KnownDefinitions
from rosproto.node.events import Event, Events
from rosproto.node.graph.listening import Listening
from rosproto.node.graph.master_client import MasterClient
from rosproto.node.graph.registrations import Registrations
from rosproto.node.incoming.local_nodes import EVERYBODY, LocalNodes
from rosproto.node.outgoing.link_monitor import LinkMonitor
from rosproto.node.shutdown import Lifecycle
from rosproto.protocol.wire_limits import Limits
from rosproto.transport import HostNames
from rosproto.transport.deadline import Deadline
from rosproto.transport.uri import is_loopback, parse_uri

if TYPE_CHECKING:
    from rosproto.node.incoming.subscription import Subscription

MASTER_CALL_SECONDS = 10.0
FAREWELL_SECONDS = 2.0  # for unregistering; the master monitor completes the rest later


class Context:
    """State shared by the topics and services of one node.

    Attributes:
        name: Global name of the node.
        limits: Bounds for requests of peers.
        definitions: Known definitions, to convert between revisions of a type.
        hosts: Addresses of host names that this computer may not know.
        lifecycle: Open, closing or closed.
        master: Client of the master, with the node's name as caller id.
        master_address: Host and port of the master.
        master_hosts: Every address of the master's host; empty until the node has joined.
        master_lost: True while the master does not answer; set by the master monitor.
        listening: The node's present servers and address.
        registrations: All registrations at the master; the master monitor repeats them after a restart of
            the master or a change of our address.
        events: The latest events; `emit` adds one and calls `on_event`.
        peer_log: Bounded log of events that peers cause.
        local_nodes: Nodes of this process that are connected without sockets; None to use sockets only.
        check_publishers: Called with a subscription, to query its publishers at the master, and with whether
            that should be at once, not with the next look.
    """

    def __init__(
        self,
        name: str,
        *,
        master_uri: str,
        host: str | None,
        limits: Limits,
        definitions: KnownDefinitions,
        hosts: Mapping[str, str],
        intraprocess: bool | LocalNodes,
        on_event: Callable[[Event], object] | None,
    ) -> None:
        self.name = name
        self.limits = limits
        self.definitions = definitions
        nodes = EVERYBODY if intraprocess else None
        self.local_nodes = intraprocess if isinstance(intraprocess, LocalNodes) else nodes
        self.peer_log = PeerLog("rosproto.node")
        self.events = Events(name, on_event)
        self.lifecycle = Lifecycle()
        self.check_publishers: Callable[[Subscription, bool], None] = lambda subscription, at_once: None
        self._link_ids = itertools.count(1)
        host_of_master, port = parse_uri(master_uri)
        self.hosts = HostNames(hosts, master=host_of_master)
        self.listening = Listening(host)
        self._master_uri = master_uri
        self.master = self.new_master_client(MASTER_CALL_SECONDS)
        self.master_address = (self.hosts.mapped(host_of_master), port)
        self.master_hosts: frozenset[str] = frozenset()
        self.master_lost = False
        self._link_monitor: LinkMonitor | None = None
        self._monitor_lock = threading.Lock()
        self.registrations = Registrations(
            self.master, self.master.within(FAREWELL_SECONDS), lambda: self.master_lost
        )

    @property
    def link_monitor(self) -> LinkMonitor:
        """Watches all subscribers of other processes; made with the first of them, as it takes three files.

        Raises:
            ConnectionLost: No file is left to open, or the node is closed.
        """
        with self._monitor_lock:
            if self._link_monitor is None:
                if self.lifecycle.ended.is_set():
                    raise ConnectionLost(f"the node {self.name} is closed")
                self._link_monitor = LinkMonitor(self.name)
            return self._link_monitor

    def _close_link_monitor(self, seconds: float) -> None:
        with self._monitor_lock:
            monitor = self._link_monitor
        if monitor is not None:
            monitor.close(seconds)

    def new_master_client(self, timeout: float) -> MasterClient:
        """A client with connections separate from those of `master`, and `timeout` seconds for a call."""
        uri, direct = self._master_uri, None
        if self.local_nodes is not None:
            direct = self.local_nodes.calls_to(uri, limits=self.limits, timeout=timeout, hosts=self.hosts)
        return MasterClient(
            uri, self.name, timeout=timeout, limits=self.limits, client=direct, hosts=self.hosts
        )

    def is_master_address(self, host: str) -> bool:
        """True when a call from `host` may come from the master."""
        own = self.listening.host  # calls of a master on this computer come from there
        here = own in self.master_hosts or any(is_loopback(other) for other in self.master_hosts)
        return host in self.master_hosts or (here and host == own)

    @property
    def uri(self) -> str:
        """Present XML-RPC URI of the node's slave API."""
        return self.listening.uri

    def next_link_id(self) -> int:
        """A number for a connection that no other one of this node has, as in getBusInfo."""
        return next(self._link_ids)

    def leave_master(self, seconds: float) -> None:
        """Unregister everything, if the master answers."""
        if not self.master_lost:
            # A separate client: a call that hangs in `master` must not use up the time.
            with self.new_master_client(seconds) as master:
                self.registrations.unregister_all(Deadline(seconds), master)

    def close_servers(self, seconds: float) -> None:
        """Close the servers, the link monitor and the client of the master."""
        self.listening.endpoints.close(seconds)
        self._close_link_monitor(seconds)
        self.master.close()

    def give_up(self) -> None:
        """Close a node that could not listen and has registered nothing."""
        self.master.close()
        self.lifecycle.end()
