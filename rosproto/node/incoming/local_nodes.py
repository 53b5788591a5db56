"""The open nodes of this process, by URI, so that their messages need no sockets.

The master still decides which nodes connect. All nodes share one table; `Node(intraprocess=False)` uses none,
and nodes that are given the same `LocalNodes` are local only to each other.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rosproto.protocol.wire_limits import Limits
from rosproto.transport import HostNames, XmlRpcClient
from rosproto.transport.uri import parse_uri

if TYPE_CHECKING:
    from rosproto.master import Master

FindPublication = Callable[[str], Any]
"""Returns the `Publication` of a resolved topic, or None."""


class LocalNodes:
    """Nodes that exchange messages without sockets.

    Args:
        told_as: The transport of these links in statistics and for `rosnode info`; a simulation gives the one
            that it simulates.
        master: A master of this process, which nodes that have it call without a socket, too.
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
        """A client for the master with that URI; None if it is not the one given."""
        if self._master is None or parse_uri(uri) != parse_uri(self._master.uri):
            return None
        from rosproto.master.local_client import LocalClient

        return LocalClient(self._master, limits=limits, timeout=timeout, hosts=hosts)

    def clear(self) -> None:
        """Remove all nodes."""
        self._open.clear()


EVERYBODY = LocalNodes()
"""The nodes of this process."""


def chosen(intraprocess: bool | LocalNodes) -> LocalNodes | None:
    """The table for the option `intraprocess` of a node; None if it uses sockets only."""
    if isinstance(intraprocess, LocalNodes):
        return intraprocess
    return EVERYBODY if intraprocess else None


def forget_all() -> None:
    """Empty the shared table in a fork of this process: the threads of its nodes do not run there.

    Nodes with another table are all closed there.
    """
    EVERYBODY.clear()
