"""What the clients of a master and of a node's slave API share: one peer, one caller id, one reply shape.

Source: wiki.ros.org/ROS/Master_Slave_APIs (status code, statusMessage, value).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from rosproto.node.graph import replies
from rosproto.protocol.limits import Limits
from rosproto.transport import HostNames, XmlRpcClient, unpack

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

    def call(self, method: str, *params: object, timeout: float | None = None) -> object:
        """Any method of the peer with our caller id first; returns the value of its reply."""
        if timeout is None:
            timeout = self._timeout
        reply = self._client.call(method, self.caller_id, *params, timeout=timeout)
        return unpack(method, reply, self.uri)

    def _typed(
        self, convert: Callable[[object], T], method: str, *params: object, timeout: float | None
    ) -> T:
        return replies.checked(method, self.uri, self.call(method, *params, timeout=timeout), convert)
