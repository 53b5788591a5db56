"""The connection of one node to its master: clients for calls, its addresses, and whether it answers."""

from __future__ import annotations

from collections.abc import Callable

from rosproto.node.graph.master_client import MasterClient
from rosproto.protocol.wire_limits import Limits
from rosproto.transport import HostNames, XmlRpcClient
from rosproto.transport.uri import is_loopback, parse_uri

MASTER_CALL_SECONDS = 10.0


class MasterConnection:
    """One node's connection to its master.

    Args:
        uri: As the program gave it.
        name: Of the node.
        limits: Bounds for the answers.
        hosts: Host names that this computer may not know.
        local_client: Returns a client for a master of this process, with that many seconds for a call;
            None to call over the network.

    Attributes:
        uri: The master's URI in canonical form.
        client: The client with the node's name as caller id.
        address: Host and port of the master.
        host_addresses: Every address of the master's host; empty until the node has joined.
        lost: True while the master does not answer; set by the master monitor.
    """

    def __init__(
        self,
        uri: str,
        name: str,
        *,
        limits: Limits,
        hosts: HostNames,
        local_client: Callable[[float], XmlRpcClient | None] = lambda seconds: None,
    ) -> None:
        self._name = name
        self._limits = limits
        self._hosts = hosts
        self._local_client = local_client
        self.uri = uri
        self.client = self.new_client(MASTER_CALL_SECONDS)
        self.uri = self.client.uri
        host, port = parse_uri(self.uri)
        self.address = (hosts.mapped(host), port)
        self.host_addresses: frozenset[str] = frozenset()
        self.lost = False

    def new_client(self, timeout: float) -> MasterClient:
        """Another client, with connections separate from `client` and `timeout` seconds for a call."""
        return MasterClient(
            self.uri,
            self._name,
            timeout=timeout,
            limits=self._limits,
            client=self._local_client(timeout),
            hosts=self._hosts,
        )

    def is_at(self, host: str, *, own_host: str) -> bool:
        """True when a call from `host` may come from the master.

        Args:
            host: Address of the caller.
            own_host: Our address: calls of a master on this computer come from there.
        """
        here = own_host in self.host_addresses or any(is_loopback(other) for other in self.host_addresses)
        return host in self.host_addresses or (here and host == own_host)
