"""Check the arguments of the Master API, with rosmaster's texts (rosmaster/validators.py).

A check takes the value and the caller's name and returns the value for the method: names are returned
resolved. rosmaster accepts unusual characters in names, and tools rely on that (`rosparam` calls itself
`/rosparam-1234`, roslaunch writes keys with dots), so only names that break the graph are refused.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeGuard

from rosproto.protocol.xmlrpc import DateTime

MAX_LENGTH = 4096  # of names, types and URIs, which the master stores

Check = Callable[[object, str], object]


class InvalidArgument(ValueError):
    """An argument is invalid; the text is returned to the caller with status -1."""


def is_text(value: object) -> TypeGuard[str]:
    """Whether a value is a string; a `DateTime`, which is one in Python, does not count."""
    return isinstance(value, str) and not isinstance(value, DateTime)


def resolve(name: str, node_name: str) -> str:
    """Resolve a name given by a node to its global canonical form (rosgraph.names.resolve_name).

    `rosproto.names.resolve` refuses illegal characters; a master must not, see above.
    """
    canonical = "/".join(part for part in name.split("/") if part)
    if name.startswith("/"):
        return "/" + canonical
    base = [part for part in node_name.split("/") if part]
    if canonical.startswith("~"):
        return "/" + "/".join([*base, *(part for part in canonical[1:].split("/") if part)])
    return "/" + "/".join([*base[:-1], canonical] if canonical else base[:-1])


def limit_length(value: str, what: str) -> str:
    """Refuse names so long that they could only fill the memory."""
    if len(value) > MAX_LENGTH:
        raise InvalidArgument(f"ERROR: parameter [{what}] is longer than {MAX_LENGTH} characters")
    return value


def key(value: object, caller_id: str) -> str:
    """Check a parameter key: a non-empty string; not resolved."""
    if not value:
        raise InvalidArgument("ERROR: parameter [key] must be specified and non-empty")
    if not is_text(value):
        raise InvalidArgument("ERROR: parameter [key] must be a string")
    return value


def resolved_key(value: object, caller_id: str) -> str:
    """Check and resolve a parameter key."""
    return resolve(limit_length(key(value, caller_id), "key"), caller_id)


def value(given: object, caller_id: str) -> object:
    """Check a parameter value: not nil (the tree refuses nil inside it)."""
    if given is None:
        raise InvalidArgument("ERROR: parameter [value] must be specified")
    return given


def graph_name(what: str) -> Check:
    """Resolve the name of a topic, service or node; `what` is the parameter's name in the error."""

    def check(value: object, caller_id: str) -> str:
        if not value or not is_text(value):
            raise InvalidArgument(f"ERROR: parameter [{what}] must be a non-empty string")
        if ":" in value or " " in value:  # typically a URI in the wrong argument
            raise InvalidArgument(f"ERROR: parameter [{what}] contains illegal chars")
        limit_length(value, what)
        return resolve(value, caller_id)

    return check


def resource(what: str) -> Check:
    """Check a topic or service name: `graph_name`, but not "/"."""
    name = graph_name(what)

    def check(value: object, caller_id: str) -> object:
        resolved = name(value, caller_id)
        if resolved == "/":
            raise InvalidArgument(f"ERROR: parameter [{what}] cannot be the global namespace")
        return resolved

    return check


def subgraph(value: object, caller_id: str) -> str:
    """Resolve a namespace; "" means everything."""
    if not is_text(value):
        raise InvalidArgument("ERROR: parameter [subgraph] must be a string")
    return resolve(value, caller_id) if value else ""


def type_name(value: object, caller_id: str) -> str:
    """Check a message type: "package/Type" or "*"."""
    if value == "*":
        return "*"
    if not value or not is_text(value):
        raise InvalidArgument("ERROR: parameter [topic_type] must be a non-empty string")
    if value.count("/") != 1:
        raise InvalidArgument("ERROR: parameter [topic_type] is not a valid package resource name")
    return limit_length(value, "topic_type")


def api_uri(what: str) -> Check:
    """Check the URI of a node's slave API or of a service: http:// or rosrpc://."""

    def check(value: object, caller_id: str) -> str:
        if not value or not is_text(value):
            raise InvalidArgument(f"ERROR: parameter [{what}] is not an XMLRPC URI")
        if not value.startswith(("http://", "rosrpc://")):
            raise InvalidArgument(f"ERROR: parameter [{what}] is not an RPC URI")
        return limit_length(value, what)

    return check
