"""What every part of a node may know of it: its name, its master, its addresses, and that it is closing.

`Node` is the face on top and makes one of these; the parts are given it, or the one or two things of it that
they use. It imports no part. What a part needs of another one is handed to it by `node.py`.
"""

from __future__ import annotations

import itertools
import logging
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

from rosproto import names
from rosproto.logs import PeerLog, get_logger
from rosproto.node.clock import NodeClock
from rosproto.node.definitions.md5sum_mismatch import Revisions
from rosproto.node.events import Event, Events
from rosproto.node.graph.listening import Endpoints
from rosproto.node.graph.master_client import MasterClient
from rosproto.node.graph.registrations import Registrations
from rosproto.node.incoming.local_nodes import LocalNodes, chosen
from rosproto.node.outgoing.link_monitor import LinkMonitor
from rosproto.protocol.wire_limits import Limits
from rosproto.transport.robot_host_names import HostNames
from rosproto.transport.uri import is_loopback, parse_uri

_log = get_logger("rosproto.node")

MOST_WARNINGS = 100  # names of a program that makes up a new one each time


class Naming:
    """Resolves names for one node.

    Args:
        node_name: The node's own, global.
        remappings: Names and what they stand for, as written on a command line.

    Raises:
        ValueError: One side of a remapping is a name that no master takes.
    """

    def __init__(self, node_name: str, remappings: Mapping[str, str]) -> None:
        self._node_name = node_name
        self._remappings = names.resolve_remappings(remappings, node_name)
        self._warned: set[str] = set()

    def resolve(self, name: str) -> str:
        """The global name, remapped; one that is not legal, though some use it, is warned of once.

        Raises:
            ValueError: No master takes it.
        """
        resolved = names.resolve(name, self._node_name, self._remappings)
        new = resolved not in self._warned and len(self._warned) < MOST_WARNINGS
        if new and not names.is_legal_name(resolved):
            self._warned.add(resolved)
            _log.warning("! %s is not a legal ROS name; roscpp and some tools refuse it", resolved)
        return resolved


MASTER_CALL_SECONDS = 10.0
FAREWELL_SECONDS = 2.0  # what is not taken back by then is taken back by the master monitor


class Context:
    """The ground that the parts of one node stand on.

    Attributes:
        name: Global name of the node.
        limits: Bounds for what peers may ask.
        revisions: Definitions, and which of them a peer means.
        hosts: Host names that this computer may not know.
        master, master_uri: The typed client of the master, the node's name as caller id.
        master_address, master_hosts: Host and port of the master; every address of that host.
        master_lost: True while the master does not answer; the master monitor writes it.
        registrations: What the master knows about us. A part that is registered adds a `Registration`; the
            master monitor registers all of it again when the master restarted or our address changed.
        endpoints: Where the node listens now; another object after a change of address.
        clock: The node's time, wall or simulated.
        monitor: The thread that watches all subscribers.
        events, emit: What happened lately; notes one more and tells the program.
        said: What peers do, told to the log within bounds.
        local_nodes: Nodes of this process that are connected without sockets; None for none.
        host_given: Address or name that the program gave; None when it is to be found.
        check_again: Called with a subscription whose publishers should be asked for; the master monitor's.
        closing: Set when closing begins; every long wait of a part watches it.
        ended: Set when it is over.
        close_reason: "" by the program, else who closed the node and why.
        closers: Called by closing, newest first, before the servers go; each is bounded and idempotent.
        before_close, shutdown_callbacks: See `Node.before_close` and `Node.on_shutdown`.
        fork_callbacks: Called in a fork of this process, where nothing of the node works (`shutdown.py`).
    """

    endpoints: Endpoints

    def __init__(
        self,
        name: str,
        *,
        master_uri: str,
        host: str | None,
        limits: Limits,
        revisions: Revisions,
        remappings: Mapping[str, str],
        hosts: Mapping[str, str],
        intraprocess: bool | LocalNodes,
        on_event: Callable[[Event], object] | None,
    ) -> None:
        self.name = name
        self.limits = limits
        self.revisions = revisions
        self.host_given = host
        self.local_nodes = chosen(intraprocess)
        self.said = PeerLog("rosproto.node")
        self.events = Events(name, on_event)
        self.emit = self.events.emit
        self.closing = threading.Event()
        self.ended = threading.Event()
        self.close_reason = ""
        self.close_lock = threading.Lock()
        self.closer: int | None = None  # the thread that closes
        self.closers: list[Callable[[], None]] = []
        self.before_close: list[Callable[[str], object]] = []
        self.shutdown_callbacks: list[Callable[[str], object]] = []
        self.fork_callbacks: list[Callable[[], None]] = []
        self.check_again: Callable[[Any], None] = lambda subscription: None
        self.master_lost = False
        self._naming = Naming(name, remappings)
        self._link_ids = itertools.count(1)
        self.hosts = HostNames(hosts, master=parse_uri(master_uri)[0])
        self.master_uri = master_uri
        self.master = self.master_client(MASTER_CALL_SECONDS)
        self.master_uri = self.master.uri
        at, port = parse_uri(self.master.uri)
        self.master_address = (self.hosts.meant(at), port)
        self.master_hosts: frozenset[str] = frozenset()
        self.monitor = LinkMonitor(name)
        self.registrations = Registrations(
            self.master, self.master.within(FAREWELL_SECONDS), lambda: self.master_lost
        )
        self.clock = NodeClock()

    def master_client(self, timeout: float) -> MasterClient:
        """Another client of the master, with connections of its own and `timeout` seconds for a call."""
        carrier = self.local_nodes and self.local_nodes.calls_to(
            self.master_uri, limits=self.limits, timeout=timeout, hosts=self.hosts
        )
        return MasterClient(
            self.master_uri,
            self.name,
            timeout=timeout,
            limits=self.limits,
            client=carrier or None,
            hosts=self.hosts,
        )

    @property
    def uri(self) -> str:
        """XML-RPC URI of the node's slave API, at present."""
        return self.endpoints.uri

    @property
    def closed(self) -> bool:
        """True from the beginning of closing."""
        return self.closing.is_set()

    @property
    def logger(self) -> logging.Logger:
        """The logger that carries the node's name; whether it is published is the business of `rosout.py`."""
        return logging.getLogger("ros" + self.name.replace("/", "."))

    def resolve_name(self, name: str) -> str:
        """The global name that `name` means here, remappings applied.

        Raises:
            ValueError: No master takes it.
        """
        return self._naming.resolve(name)

    def is_master_address(self, host: str) -> bool:
        """Did this call come from the master's computer? Or, when the master is here, from our address."""
        hosts = self.master_hosts
        here = self.endpoints.host in hosts or any(is_loopback(address) for address in hosts)
        return host in hosts or (here and host == self.endpoints.host)

    def next_link_id(self) -> int:
        """A number for a connection, in getBusInfo."""
        return next(self._link_ids)

    def wall_time(self) -> float:
        """Seconds since 1970 by this computer's clock."""
        return time.time()
