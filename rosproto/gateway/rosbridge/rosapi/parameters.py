"""Parameters for /rosapi, as JSON text, within the rules of `ParameterAccess`."""

from __future__ import annotations

import base64
import json

from rosproto.gateway.access import Access, Refusal
from rosproto.gateway.parameter_access import HIDDEN, ParameterAccess
from rosproto.gateway.rosbridge.rosapi.graph import RosapiError
from rosproto.json_values import plain
from rosproto.node import Node


class VisibleParameters:
    """The part of the parameter server that one gateway shows. The node resolves names."""

    def __init__(self, node: Node, access: Access) -> None:
        self._node = node
        self._access = access
        self._rules = ParameterAccess(node, access)

    def get(self, name: str, default: str) -> str:
        """A parameter as JSON text; if it is not set, `default` (JSON, or else a string) or "null"."""
        key = self._key(name)
        value = self._node.params.get(key, HIDDEN)
        if value is HIDDEN:
            self._check(self._access.may_read("parameter", key))
            return _to_json(_from_json_or_text(default))
        shown = self._rules.visible(key, value)
        if shown is HIDDEN:
            self._check(self._access.may_read("parameter", key))
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
            raise RosapiError(f"parameter {key}: null is not a value of a parameter; delete it instead")
        try:
            self._check(self._rules.may_write(key, parsed))
            self._node.params.set(key, parsed)
        except ValueError as error:
            raise RosapiError(str(error)) from error
        return ()

    def delete(self, name: str) -> tuple[()]:
        """Delete a parameter, if it is set. The response has no fields."""
        key = self._key(name)
        self._check(self._rules.may_write(key))
        if self._node.params.has(key):
            self._node.params.delete(key)
        return ()

    def has(self, name: str) -> bool:
        """Whether a visible parameter or namespace of this name is set."""
        key = self._key(name)
        if self._access.shows("parameter", key):
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
        return found if found and self._access.shows("parameter", found) else ""

    def names(self) -> list[str]:
        """All visible keys, sorted."""
        return self._access.visible("parameter", self._node.params.names())

    def _key(self, name: str) -> str:
        if not name:
            raise RosapiError("the name of the parameter is empty")
        try:
            return self._rules.key(name)
        except ValueError as error:
            raise RosapiError(str(error)) from error

    @staticmethod
    def _check(refusal: Refusal | None) -> None:
        if refusal is not None:
            raise RosapiError(refusal.text)


def _from_json_or_text(text: str) -> object:
    if text == "":
        return None
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return text


def _to_json(value: object) -> str:
    return json.dumps(plain(value, octets=lambda octets: base64.b64encode(octets).decode()))
