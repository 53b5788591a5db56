"""Clients of masters and nodes that escape names in replies, so that no name can control the terminal.

A peer may register invalid names, such as names with line feeds. Replies have them escaped; later requests
translate them back. Parameter values are unchanged: they are printed as YAML.
"""

from __future__ import annotations

from rosproto.node.graph.master_client import MasterClient
from rosproto.node.graph.slave_client import NodeClient
from rosproto.text import printable
from rosproto.transport.xmlrpc_client import LastReply

_VALUES = frozenset({"getParam", "subscribeParam"})


class _EscapedCalls:
    """Mixin for a client: escapes strings in replies, and translates them back in requests."""

    def call(
        self, method: str, *params: object, timeout: float | None = None, last: LastReply | None = None
    ) -> object:
        theirs = self.__dict__.setdefault("_theirs", {})
        asked = [theirs.get(p, p) if isinstance(p, str) else p for p in params]
        value: object = super().call(method, *asked, timeout=timeout, last=last)  # type: ignore[misc]
        return value if method in _VALUES else _shown(value, theirs)


class EscapedMasterClient(_EscapedCalls, MasterClient):
    """A `MasterClient` with printable names."""


class EscapedNodeClient(_EscapedCalls, NodeClient):
    """A `NodeClient` with printable answers."""


def _shown(value: object, theirs: dict[str, str]) -> object:
    if isinstance(value, str):
        text = printable(value)
        if text != value:
            theirs[text] = value
        return text
    if isinstance(value, (list, tuple)):
        return [_shown(item, theirs) for item in value]
    if isinstance(value, dict):
        return {_shown(key, theirs): _shown(item, theirs) for key, item in value.items()}
    return value
