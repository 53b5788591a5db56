"""The open nodes of this process by URI, for links without sockets.

The master still decides which nodes connect. By default all nodes share one table;
`Node(intraprocess=False)` uses none, and nodes with the same `LocalNodes` are local only to each other.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from rosproto.protocol.wire_limits import Limits
from rosproto.transport import HostNames, XmlRpcClient
from rosproto.transport.uri import parse_uri

if TYPE_CHECKING:
    from rosproto.master import Master
    from rosproto.node.outgoing.publication import Publication

FindPublication = Callable[[str], "Publication | None"]
"""Returns the `Publication` of a resolved topic."""


class LocalNodes:
    """Nodes that exchange messages without sockets.

    Args:
        told_as: Transport of these links in statistics and `rosnode info`; a simulation gives the simulated
            one.
        master: A master in this process, which these nodes call without a socket.
    """

    def __init__(self, told_as: str = "INTRAPROCESS", *, master: Master | None = None) -> None:
        self.told_as = told_as
        self._master = master
        self._open: dict[tuple[str, int], FindPublication] = {}

    def note(self, uri: str, find: FindPublication) -> None:
        """Add an open node under its present URI."""
        self._open[parse_uri(uri)] = find

    def forget(self, uri: str, find: FindPublication) -> None:
        """Remove a node."""
        key = parse_uri(uri)
        if self._open.get(key) == find:
            self._open.pop(key, None)

    def find(self, uri: str) -> FindPublication | None:
        """The open node with that URI."""
        try:
            return self._open.get(parse_uri(uri))
        except ValueError:
            return None

    def calls_to(self, uri: str, *, limits: Limits, timeout: float, hosts: HostNames) -> XmlRpcClient | None:
        """A client for the table's master; None if `uri` is not its URI."""
        if self._master is None or parse_uri(uri) != parse_uri(self._master.uri):
            return None
        from rosproto.master.local_client import LocalClient

        return LocalClient(self._master, limits=limits, timeout=timeout, hosts=hosts)

    def clear(self) -> None:
        """Remove all nodes, in a fork of this process, where their threads do not run."""
        self._open.clear()


EVERYBODY = LocalNodes()
"""The nodes of this process."""
