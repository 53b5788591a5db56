"""A minimal node for tests of services and parameters: a real TCPROS server, a master in memory, no topics."""

from __future__ import annotations

from typing import Any

from rosproto.errors import MasterError
from rosproto.logs import PeerLog
from rosproto.names import resolve
from rosproto.node.definitions.known_definitions import KnownDefinitions
from rosproto.node.graph.listening import Listening, TcprosServer
from rosproto.node.graph.registrations import Registrations
from rosproto.node.parameters import Parameters
from rosproto.node.services.table import Services
from rosproto.node.shutdown import Lifecycle
from rosproto.protocol.wire_limits import Limits
from rosproto.transport import HostNames


class MemoryMaster:
    """The master calls of services and parameters, without a network.

    Attributes:
        calls: (method, first argument) of each call.
        services: Service name -> URI.
        params: Flat parameters, key -> value.
    """

    uri = "http://memory/"

    def __init__(self) -> None:
        self.calls: list[tuple[str, str]] = []
        self.services: dict[str, str] = {}
        self.params: dict[str, Any] = {}

    def _called(self, method: str, argument: str) -> None:
        self.calls.append((method, argument))

    def count(self, method: str) -> int:
        return sum(1 for called, _ in self.calls if called == method)

    def lookup_service(self, name: str, *, timeout: float | None = None) -> str:
        self._called("lookupService", name)
        if name not in self.services:
            raise MasterError("lookupService", -1, "no provider", uri=self.uri)
        return self.services[name]

    def batch(self, calls: Any, *, timeout: float | None = None) -> list[object]:
        return [self.call(method, *parameters) for method, parameters in calls]

    def call(self, method: str, first: str, second: str, *more: str) -> object:
        """The registration of a service or parameter."""
        if method == "registerService":
            return self.register_service(first, second)
        assert method == "subscribeParam"
        return self.subscribe_param(second)

    def register_service(self, name: str, service_api: str) -> int:
        self._called("registerService", name)
        self.services[name] = service_api
        return 1

    def unregister_service(self, name: str, service_api: str) -> int:
        self._called("unregisterService", name)
        if self.services.get(name) != service_api:
            return 0
        del self.services[name]
        return 1

    def get_param(self, key: str) -> Any:
        self._called("getParam", key)
        if key not in self.params:
            raise MasterError("getParam", -1, f"Parameter [{key}] is not set", uri=self.uri)
        return self.params[key]

    def set_param(self, key: str, value: Any) -> None:
        self._called("setParam", key)
        self.params[key] = value

    def delete_param(self, key: str) -> None:
        self._called("deleteParam", key)
        if key not in self.params:
            raise MasterError("deleteParam", -1, f"parameter [{key}] is not set", uri=self.uri)
        del self.params[key]

    def has_param(self, key: str) -> bool:
        return key in self.params

    def get_param_names(self) -> list[str]:
        return list(self.params)

    def search_param(self, key: str) -> str:
        self._called("searchParam", key)
        for found in self.params:
            if found.endswith(f"/{key}"):
                return found
        raise MasterError("searchParam", -1, "Cannot find parameter", uri=self.uri)

    def subscribe_param(self, key: str) -> Any:
        self._called("subscribeParam", key)
        return self.params.get(key, {})

    def unsubscribe_param(self, key: str, caller_api: str) -> None:
        self._called("unsubscribeParam", key)


class _Endpoints:
    def __init__(self, tcpros: TcprosServer) -> None:
        self.tcpros = tcpros
        self.rosrpc_uri = f"rosrpc://127.0.0.1:{tcpros.port}"


class SmallNode:
    """The parts of a node that `Services` and `Parameters` use; several may share one `MemoryMaster`."""

    uri = "http://127.0.0.1:1/"

    def __init__(
        self, name: str = "/small", master: MemoryMaster | None = None, limits: Limits | None = None
    ) -> None:
        self.name = name
        self.master = master or MemoryMaster()
        self.limits = limits or Limits()
        self.hosts = HostNames()
        self.definitions = KnownDefinitions()
        self.peer_log = PeerLog("rosproto.node")
        self.lifecycle = Lifecycle()
        self.registrations = Registrations(self.master)  # type: ignore[arg-type]
        self.listening = Listening(None)
        self.listening.endpoints = _Endpoints(  # type: ignore[assignment]
            TcprosServer("127.0.0.1", limits=self.limits, on_topic=lambda sock, fields, peer: sock.close())
        )
        self.services = Services(self)  # type: ignore[arg-type]
        self.params = Parameters(
            self.master,  # type: ignore[arg-type]
            self.registrations,
            own_uri=lambda: self.uri,
            resolve_name=self.resolve_name,
        )

    @property
    def tcpros_address(self) -> tuple[str, int]:
        return "127.0.0.1", self.listening.endpoints.tcpros.port

    def resolve_name(self, name: str) -> str:
        return resolve(name, self.name)

    def service_client(self, name: str, type: Any, *, persistent: bool = False) -> Any:
        return self.services.client(self.resolve_name(name), type, persistent=persistent)

    def service_server(self, name: str, type: Any, handler: Any) -> Any:
        return self.services.server(self.resolve_name(name), type, handler)

    def __enter__(self) -> SmallNode:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()

    def close(self) -> None:
        for closer in reversed(self.lifecycle.closers):
            closer()
        self.listening.endpoints.tcpros.close(2.0)
