"""The open nodes of this process, by URI: how a subscriber finds a publisher that needs no socket.

The table decides only *how* bytes travel between two nodes which the master has brought together, and
`Node(intraprocess=False)` does without.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from rosproto.transport.address import parse_uri

if TYPE_CHECKING:
    from rosproto.node.outgoing.publication import Publication

__all__ = ["FindPublication", "find_node", "forget_all", "forget_node", "note_node"]

FindPublication = Callable[[str], "Publication | None"]
"""Asked with a resolved topic: what a node publishes there."""

_open_nodes: dict[tuple[str, int], FindPublication] = {}


def note_node(uri: str, find: FindPublication) -> None:
    """A node is open under its present URI."""
    _open_nodes[parse_uri(uri)] = find


def forget_node(uri: str, find: FindPublication) -> None:
    """It is not any more."""
    key = parse_uri(uri)
    if _open_nodes.get(key) == find:
        _open_nodes.pop(key, None)


def find_node(uri: str) -> FindPublication | None:
    """The open node of this process with that URI."""
    try:
        return _open_nodes.get(parse_uri(uri))
    except ValueError:
        return None


def forget_all() -> None:
    """In a fork: a URI in the table means a node that speaks, and these are mute there."""
    _open_nodes.clear()
