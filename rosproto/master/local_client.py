"""A client of a master in the same process: the same answers, without XML, sockets and threads.

Twenty nodes that joined their own master over HTTP were a third of what the start of a simulated chassis cost
the processor. Only those who are given the master's object get here; everybody else, on this computer or not,
takes the port.
"""

from __future__ import annotations

from rosproto.master.server import Master
from rosproto.protocol.wire_limits import Limits
from rosproto.transport import HostNames, Peer
from rosproto.transport.xmlrpc_client import XmlRpcClient

_DIRECT = frozenset(
    {
        "getPid",
        "getParam",
        "registerPublisher",
        "unregisterPublisher",
        "registerSubscriber",
        "unregisterSubscriber",
        "registerService",
        "unregisterService",
        "lookupService",
        "getSystemState",
    }
)
"""What takes texts only and never waits; all else, a parameter's value for one, passes the wire's checks."""


class LocalClient(XmlRpcClient):
    """An `XmlRpcClient` of a master in this process; rare calls take the port, and all do once it has closed.

    A master that was closed, or this client in a fork, fails as it does over the network.

    Args:
        master: To be called.
        limits, timeout, hosts: As `XmlRpcClient` has them.
    """

    def __init__(
        self, master: Master, *, limits: Limits | None, timeout: float | None, hosts: HostNames | None
    ) -> None:
        super().__init__(master.uri, limits=limits, timeout=timeout, hosts=hosts)
        self._master = master

    def call(self, method: str, *params: object, timeout: float | None = None, retry: bool = True) -> object:
        """As `XmlRpcClient.call`."""
        if not self._closed and not self._master.closed:
            if method in _DIRECT:
                return self._directly(method, list(params))
            calls = _direct_calls(params) if method == "system.multicall" else None
            if calls is not None:
                return [[self._directly(name, arguments)] for name, arguments in calls]
        return super().call(method, *params, timeout=timeout, retry=retry)

    def _directly(self, method: str, params: list[object]) -> object:
        return _copied(self._master.answer(method, params, _HERE))


def _here() -> Peer:
    peer = Peer("this process")
    peer.host, peer.port, peer.local_host = "127.0.0.1", 0, ""
    return peer


_HERE = _here()


def _direct_calls(params: tuple[object, ...]) -> list[tuple[str, list[object]]] | None:
    """The calls of a multicall; None when one of them has to take the port."""
    structs = params[0] if len(params) == 1 else None
    calls = []
    for struct in structs if isinstance(structs, list) else ():
        method, arguments = struct.get("methodName"), struct.get("params")
        if method not in _DIRECT or not isinstance(arguments, list):
            return None
        calls.append((method, arguments))
    return calls or None


def _copied(value: object) -> object:
    """What the caller may keep: the master's own lists and namespaces change later."""
    if isinstance(value, (list, tuple)):
        return [_copied(item) for item in value]
    if isinstance(value, dict):
        return {key: _copied(item) for key, item in value.items()}
    return value
