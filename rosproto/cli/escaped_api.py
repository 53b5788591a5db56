"""What masters and nodes answer, fit to be printed: no name of theirs begins a line or commands the terminal.

Anybody may register names that are none, with line feeds in them. The commands see them escaped, wherever
they print them; asked for by that escaped name, the peer gets its own back. Values of parameters stay as they
are: they are data, and are printed as YAML.
"""

from __future__ import annotations

from rosproto.node.graph.master_client import MasterClient
from rosproto.node.graph.slave_client import NodeClient
from rosproto.text import printable

_VALUES = frozenset({"getParam", "subscribeParam"})


class _EscapedCalls:
    """Mixed into a client: translates the strings of its answers, and of what is asked next."""

    def call(self, method: str, *params: object, timeout: float | None = None) -> object:
        theirs = self.__dict__.setdefault("_theirs", {})
        asked = [theirs.get(p, p) if isinstance(p, str) else p for p in params]
        value: object = super().call(method, *asked, timeout=timeout)  # type: ignore[misc]
        return value if method in _VALUES else _shown(value, theirs)


class EscapedMasterClient(_EscapedCalls, MasterClient):
    """A `MasterClient` whose names can be printed."""


class EscapedNodeClient(_EscapedCalls, NodeClient):
    """A `NodeClient` whose answers can be printed."""


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
