"""The base of `MasterClient` and `NodeClient`: calls with a caller id, and validation of the replies.

Source: wiki.ros.org/ROS/Master_Slave_APIs (status code, statusMessage, value).

Every reply is validated. Peers deviate: roscpp answers 0 in place of a list, some masters answer 0 or 1 for
a boolean; such values are accepted. Anything else is a RemoteProtocolError with the method, the peer and the
value.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from rosproto.errors import RemoteProtocolError
from rosproto.protocol.wire_limits import Limits
from rosproto.transport import HostNames, XmlRpcClient, unpack
from rosproto.transport.xmlrpc_client import LastReply

T = TypeVar("T")
Client = TypeVar("Client", bound="ApiClient")


class ApiClient:
    """Calls one XML-RPC API of ROS in the name of one node (or tool). Thread-safe.

    Args:
        uri: The peer's XML-RPC URI.
        caller_id: Our node name, or anything a human can recognise.
        timeout: Seconds per call.
        limits: Bounds for the answers.
        client: What carries the calls, in place of a new connection.
        hosts: Knows host names that the system does not (`Node.hosts`).

    Attributes:
        uri: The peer's URI in canonical form.
        caller_id: As given.
    """

    def __init__(
        self,
        uri: str,
        caller_id: str,
        *,
        timeout: float = 10.0,
        limits: Limits | None = None,
        client: XmlRpcClient | None = None,
        hosts: HostNames | None = None,
    ) -> None:
        self._client = client or XmlRpcClient(uri, limits=limits or Limits(), timeout=timeout, hosts=hosts)
        self._timeout: float | None = None
        self.uri = self._client.uri
        self.caller_id = caller_id

    def __enter__(self: Client) -> Client:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.uri} as {self.caller_id}>"

    def close(self) -> None:
        """Close the connections; running calls end with ConnectionLost."""
        self._client.close()

    def abandon(self) -> None:
        """In a fork of this process: closed, without touching the parent's connections."""
        self._client.abandon()

    def reconnect(self) -> None:
        """Make new connections from now on, because this computer's address changed."""
        self._client.reconnect()

    def within(self: Client, seconds: float) -> Client:
        """The same peer and connections, where a call without a timeout of its own takes `seconds`."""
        other = type(self)(self.uri, self.caller_id, client=self._client)
        other._timeout = seconds
        return other

    def call(
        self, method: str, *params: object, timeout: float | None = None, last: LastReply | None = None
    ) -> object:
        """Any method of the peer with our caller id first; returns the value of its reply.

        With `last`, the value is the same object as before while the peer's reply has the same bytes.
        """
        if timeout is None:
            timeout = self._timeout
        reply = self._client.call(method, self.caller_id, *params, timeout=timeout, last=last)
        return unpack(method, reply, self.uri)

    def _typed(
        self, convert: Callable[[object], T], method: str, *params: object, timeout: float | None
    ) -> T:
        return checked(method, self.uri, self.call(method, *params, timeout=timeout), convert)


def checked(method: str, uri: str, value: object, convert: Callable[[object], T]) -> T:
    """Return `convert(value)`; if it fails, the error contains the value.

    Raises:
        RemoteProtocolError: `convert` raised TypeError or ValueError.
    """
    try:
        return convert(value)
    except (TypeError, ValueError) as error:
        raise RemoteProtocolError(f"{method} at {uri}: answered {value!r:.80}, expected {error}") from None


def as_str(value: object) -> str:
    """A string."""
    if isinstance(value, str):
        return value
    raise TypeError("a string")


def as_int(value: object) -> int:
    """An integer; a boolean counts."""
    if isinstance(value, int):
        return int(value)
    raise TypeError("an integer")


def int_or_none(value: object) -> int | None:
    """An integer, or None for anything else; for informative counts."""
    return int(value) if isinstance(value, int) else None


def as_bool(value: object) -> bool:
    """A boolean; 0 and 1 count."""
    if isinstance(value, int) and value in (0, 1):
        return bool(value)
    raise TypeError("a boolean")


def as_list(value: object) -> list[object]:
    """An array; 0, "" and false, which several peers send for "nothing", count as empty."""
    if isinstance(value, (list, tuple)):
        return list(value)
    if value is None or (isinstance(value, (int, str)) and not value):
        return []
    raise TypeError("an array")


def as_str_list(value: object) -> list[str]:
    """An array of strings."""
    items = as_list(value)
    if all(isinstance(item, str) for item in items):
        return [str(item) for item in items]
    raise TypeError("an array of strings")


def as_pairs(value: object) -> list[tuple[str, str]]:
    """An array of [name, type]."""
    rows = [as_str_list(row) for row in as_list(value)]
    if any(len(row) != 2 for row in rows):
        raise TypeError("an array of [name, type]")
    return [(row[0], row[1]) for row in rows]


def as_rows(value: object) -> dict[str, list[str]]:
    """Rows [name, [node, ...]] of getSystemState."""
    found: dict[str, list[str]] = {}
    for row in as_list(value):
        cells = as_list(row)
        if len(cells) != 2 or not isinstance(cells[0], str):
            raise TypeError("rows [name, [node, ...]]")
        found[cells[0]] = as_str_list(cells[1])
    return found
