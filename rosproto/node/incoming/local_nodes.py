"""The open nodes of this process, by URI: how a subscriber finds a publisher that needs no socket.

A table decides only *how* bytes travel between two nodes which the master has brought together. All nodes
share one; `Node(intraprocess=False)` does without, and nodes that are given a `LocalNodes` of their own are
local to each other alone.
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
"""Asked with a resolved topic: the `Publication` of a node there, or None."""


class LocalNodes:
    """Nodes that exchange messages without sockets.

    Args:
        told_as: The transport that these links have in statistics and for `rosnode info`: a simulation tells
            of those it simulates.
        master: A master of this process that these nodes, where it is theirs, call without a socket, too.
    """

    def __init__(self, told_as: str = "INTRAPROCESS", *, master: Master | None = None) -> None:
        self.told_as = told_as
        self._master = master
        self._open: dict[tuple[str, int], FindPublication] = {}

    def note(self, uri: str, find: FindPublication) -> None:
        """A node is open under its present URI."""
        self._open[parse_uri(uri)] = find

    def forget(self, uri: str, find: FindPublication) -> None:
        """It is not any more."""
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
        """What carries calls to the master with that URI; None when it is not the one given."""
        if self._master is None or parse_uri(uri) != parse_uri(self._master.uri):
            return None
        from rosproto.master.local_client import LocalClient

        return LocalClient(self._master, limits=limits, timeout=timeout, hosts=hosts)

    def clear(self) -> None:
        """None is open any more."""
        self._open.clear()


EVERYBODY = LocalNodes()
"""The nodes of this process."""


def chosen(intraprocess: bool | LocalNodes) -> LocalNodes | None:
    """The table of a node that was opened with this option; None without one."""
    if isinstance(intraprocess, LocalNodes):
        return intraprocess
    return EVERYBODY if intraprocess else None


def forget_all() -> None:
    """In a fork: a URI in the table means a node that speaks, and these are mute there.

    Nodes with a table of their own are closed there, all who know it.
    """
    EVERYBODY.clear()
