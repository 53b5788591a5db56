"""Parameters for /rosapi, as JSON text, within the rules of an `Access`.

A namespace is read without its hidden parameters, and written or deleted only if everything in it may be;
otherwise `/` would circumvent all patterns.
"""

from __future__ import annotations

import base64
import json
import math

from rosproto.gateway.access import Refusal
from rosproto.gateway.rosbridge.rosapi.graph import RosapiError, Visible
from rosproto.node import Node

_HIDDEN = object()
MOST_NESTING = 32  # of a client's value


class VisibleParameters:
    """The part of the parameter server that one gateway shows. The node resolves names."""

    def __init__(self, node: Node, visible: Visible) -> None:
        self._node = node
        self._visible = visible

    def get(self, name: str, default: str) -> str:
        """A parameter as JSON text; if it is not set, `default` (JSON, or else a string) or "null"."""
        key = self._key(name)
        value = self._node.params.get(key, _HIDDEN)
        if value is _HIDDEN:
            self._check(self._visible.access.may_read("parameter", key))
            return _to_json(_from_json_or_text(default))
        shown = self._pruned(key, value)
        if shown is _HIDDEN:
            self._check(self._visible.access.may_read("parameter", key))
            shown = {}  # a visible namespace without visible parameters
        return _to_json(shown)

    def set(self, name: str, value: str) -> tuple[()]:
        """Set a parameter from JSON text. The response has no fields."""
        key = self._key(name)
        try:
            parsed = json.loads(value)
        except (ValueError, RecursionError) as error:
            raise RosapiError(
                f'parameter {key}: the value must be JSON text, such as "0.5" or "\\"text\\"": {error}'
            ) from error
        if parsed is None:
            raise RosapiError(f"parameter {key}: null is no value of a parameter; delete it instead")
        self._check_write(key)
        for below in _leaves(key, parsed):
            self._check_one(below)
        try:
            self._node.params.set(key, parsed)
        except ValueError as error:
            raise RosapiError(str(error)) from error
        return ()

    def delete(self, name: str) -> tuple[()]:
        """Delete a parameter, if it is set. The response has no fields."""
        key = self._key(name)
        self._check_write(key)
        if self._node.params.has(key):
            self._node.params.delete(key)
        return ()

    def has(self, name: str) -> bool:
        """Whether a visible parameter or namespace of this name is set."""
        key = self._key(name)
        if self._visible.shows("parameter", key):
            return self._node.params.has(key)
        below = key.rstrip("/") + "/"
        return any(other.startswith(below) for other in self.names())

    def search(self, name: str) -> str:
        """The nearest parameter of this name, from the gateway's namespace upwards, or ""."""
        if not name or name.startswith("~"):
            raise RosapiError(
                f'"{name}" cannot be searched for; give a relative name, such as robot_description'
            )
        found = self._node.params.search(name) or ""
        return found if found and self._visible.shows("parameter", found) else ""

    def names(self) -> list[str]:
        """All visible keys, sorted."""
        return self._visible.only("parameter", self._node.params.names())

    def _key(self, name: str) -> str:
        """The resolved key of a name, without // and / at the end, for comparison with patterns."""
        if not name:
            raise RosapiError("the name of the parameter is empty")
        try:
            resolved = "/" if not name.strip("/") else self._node.resolve_name(name)
        except ValueError as error:
            raise RosapiError(str(error)) from error
        return "/" + "/".join(part for part in resolved.split("/") if part)

    def _pruned(self, key: str, value: object) -> object:
        if isinstance(value, dict):
            shown = {name: self._pruned(f"{key.rstrip('/')}/{name}", below) for name, below in value.items()}
            kept = {name: below for name, below in shown.items() if below is not _HIDDEN}
            return kept or (_HIDDEN if value else self._if_shown(key, value))
        return self._if_shown(key, value)

    def _if_shown(self, key: str, value: object) -> object:
        return value if self._visible.shows("parameter", key) else _HIDDEN

    def _check_write(self, key: str) -> None:
        """Check that the key, and everything below it, may be written."""
        self._check_one(key)
        below = key.rstrip("/") + "/"
        for other in self._node.params.names():
            if other.startswith(below):
                self._check_one(other)

    def _check_one(self, key: str) -> None:
        self._check(self._visible.access.may_read("parameter", key))
        self._check(self._visible.access.may_write("parameter", key))

    @staticmethod
    def _check(refusal: Refusal | None) -> None:
        if refusal is not None:
            raise RosapiError(refusal.text)


def _leaves(key: str, value: object, depth: int = 0) -> list[str]:
    if depth > MOST_NESTING:
        raise RosapiError(f"parameter {key}: nested deeper than {MOST_NESTING}")
    if not isinstance(value, dict):
        return []
    found = []
    for name, below in value.items():
        child = f"{key.rstrip('/')}/{name}"
        found += [child, *_leaves(child, below, depth + 1)]
    return found


def _from_json_or_text(text: str) -> object:
    if text == "":
        return None
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return text


def _to_json(value: object) -> str:
    return json.dumps(_plain(value))


def _plain(value: object) -> object:
    """Replace values that JSON cannot express: NaN and infinity by null, bytes by base64, a date by text."""
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, dict):
        return {str(name): _plain(below) for name, below in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, (bytes, bytearray)):
        return base64.b64encode(value).decode("ascii")
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    return str(value)
