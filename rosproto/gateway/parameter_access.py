"""`ParameterAccess`: the rules of an `Access` for parameters, whose names are namespaces as well.

A namespace is read without its hidden parameters, and set or deleted only if everything in it may be;
otherwise `/` would circumvent all patterns.
"""

from __future__ import annotations

from rosproto.gateway.access import Access, Refusal
from rosproto.node import Node

HIDDEN = object()
MAX_NESTING = 32  # of a client's value


class ParameterAccess:
    """The rules for the parameters of one gateway.

    Args:
        node: Resolves names, and asks the master which parameters are set.
        access: Which names clients may read and set.
    """

    def __init__(self, node: Node, access: Access) -> None:
        self._node = node
        self._access = access

    def key(self, name: str) -> str:
        """The full name of a parameter; every operation uses it in place of the client's spelling.

        Raises:
            ValueError: It is not a name.
        """
        return self._node.resolve_name(name)

    def visible(self, key: str, value: object) -> object:
        """The value without its hidden parameters; `HIDDEN` if nothing is left."""
        if isinstance(value, dict) and value:
            below = {name: self.visible(_join(key, name), one) for name, one in value.items()}
            return {name: one for name, one in below.items() if one is not HIDDEN} or HIDDEN
        return value if self._access.shows("parameter", key) else HIDDEN

    def may_write(self, key: str, value: object = None) -> Refusal | None:
        """Return None if a parameter may be set to a value, or deleted, with all below it; else the reason.

        Raises:
            ValueError: The value is nested too deeply.
            MasterError, ConnectionLost, RosTimeout: The master does not answer.
        """
        refusal = self._access.may_write("parameter", key)
        if refusal is not None:
            return refusal
        below = _join(key, "")
        keys = [other for other in self._node.params.names() if other.startswith(below)]
        for one in (*keys, *_keys_in(key, value)):
            refusal = self._access.may_write("parameter", one)
            if refusal is not None:
                return refusal
        return None


def _join(key: str, name: str) -> str:
    return f"{key.rstrip('/')}/{name}"


def _keys_in(key: str, value: object, depth: int = 0) -> list[str]:
    if depth > MAX_NESTING:
        raise ValueError(f"parameter {key[:200]}: nested deeper than {MAX_NESTING}")
    if not isinstance(value, dict):
        return []
    found = []
    for name, below in value.items():
        child = _join(key, name)
        found += [child, *_keys_in(child, below, depth + 1)]
    return found
