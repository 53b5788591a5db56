"""Call a master in the same process directly, without XML, sockets and threads.

Over HTTP, twenty nodes that registered with their own master took a third of the processor time of a
simulated chassis's start. Only code that has the master object uses this; all other clients, also on this
computer, use the port.
"""

from __future__ import annotations

from rosproto.master.server import Master
from rosproto.protocol.wire_limits import Limits
from rosproto.transport import HostNames, Peer
from rosproto.transport.xmlrpc_client import LastReply, XmlRpcClient

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
        "lookupNode",
        "lookupService",
        "getSystemState",
    }
)
"""Methods with text arguments that never wait; others (a parameter's value) need the checks of the wire."""


class LocalClient(XmlRpcClient):
    """An `XmlRpcClient` for a master in this process. Rare calls use the port, and all calls do after the
    master has closed.

    A closed master, or this client in a fork, fails as it would over the network.

    Args:
        master: The master.
        limits, timeout, hosts: As for `XmlRpcClient`.
    """

    def __init__(
        self, master: Master, *, limits: Limits | None, timeout: float | None, hosts: HostNames | None
    ) -> None:
        super().__init__(master.uri, limits=limits, timeout=timeout, hosts=hosts)
        self._master = master

    def call(
        self,
        method: str,
        *params: object,
        timeout: float | None = None,
        retry: bool = True,
        last: LastReply | None = None,
    ) -> object:
        """As `XmlRpcClient.call`."""
        if not self._closed and not self._master.closed:
            if method in _DIRECT:
                return self._directly(method, list(params))
            calls = _direct_calls(params) if method == "system.multicall" else None
            if calls is not None:
                return [[self._directly(name, arguments)] for name, arguments in calls]
        return super().call(method, *params, timeout=timeout, retry=retry, last=last)

    def _directly(self, method: str, params: list[object]) -> object:
        return _copied(self._master.answer(method, params, _HERE))


def _here() -> Peer:
    peer = Peer("this process")
    peer.host, peer.port, peer.local_host = "127.0.0.1", 0, ""
    return peer


_HERE = _here()


def _direct_calls(params: tuple[object, ...]) -> list[tuple[str, list[object]]] | None:
    """The calls of a multicall; None if one of them must use the port."""
    structs = params[0] if len(params) == 1 else None
    calls = []
    for struct in structs if isinstance(structs, list) else ():
        method, arguments = struct.get("methodName"), struct.get("params")
        if method not in _DIRECT or not isinstance(arguments, list):
            return None
        calls.append((method, arguments))
    return calls or None


def _copied(value: object) -> object:
    """A copy that the caller may keep: the master's own lists and namespaces change later."""
    if isinstance(value, (list, tuple)):
        return [_copied(item) for item in value]
    if isinstance(value, dict):
        return {key: _copied(item) for key, item in value.items()}
    return value
