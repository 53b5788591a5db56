"""The services of /rosapi registered at the master, for ROS programs that call them."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from rosproto.codec import message_class, service_class
from rosproto.errors import MasterError, ServiceError

if TYPE_CHECKING:
    from types import TracebackType

    from rosproto.gateway.rosbridge.rosapi.answers import Rosapi
    from rosproto.node import Node
    from rosproto.node.services.server import ServiceServer
    from rosproto.time import Time

__all__ = ["ProvidedRosapi", "provide"]


class ProvidedRosapi:
    """The registered services of /rosapi; close this, or the node, to unregister them."""

    def __init__(self, servers: list[ServiceServer]) -> None:
        self._servers = servers

    def __enter__(self) -> ProvidedRosapi:
        return self

    def __exit__(
        self,
        error_type: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Unregister them; may be called again."""
        while self._servers:
            self._servers.pop().close()


def provide(node: Node, rosapi: Rosapi) -> ProvidedRosapi:
    """Register all services of /rosapi; they are answered as for web clients.

    Raises:
        MasterError, ConnectionLost, RosTimeout: As `Node.service_server`.
        ServiceError: Somebody provides /rosapi already; a second one would take over its services.
    """
    try:
        node.master.lookup_service("/rosapi/topics")
    except MasterError as error:
        if error.code != -1:
            raise
    else:
        raise ServiceError(
            "/rosapi/topics", "another node provides it already; end that one, or leave /rosapi to it"
        )
    servers: list[ServiceServer] = []
    try:
        with node.registering():
            for name, type_name in rosapi.services.items():
                kind = service_class(type_name)
                servers.append(node.service_server(name, kind, partial(_answer, rosapi, name, kind)))
    except BaseException:
        for server in servers:
            server.close()
        raise
    return ProvidedRosapi(servers)


def _answer(rosapi: Rosapi, name: str, kind: Any, request: Any) -> Any:
    values = rosapi.call(name, {field: getattr(request, field) for field in kind.Request.__slots__})
    return kind.Response(**{field: _as_message(field, value) for field, value in values.items()})


def _as_message(field: str, value: Any) -> Any:
    return _CONVERTED[field](value) if field in _CONVERTED else value


def _typedefs(values: list[dict[str, object]]) -> list[Any]:
    typedef = message_class("rosapi/TypeDef")
    return [typedef(**value) for value in values]


def _time(value: dict[str, int]) -> Time:
    from rosproto.time import Time

    return Time(value["secs"], value["nsecs"])


_CONVERTED: dict[str, Callable[[Any], Any]] = {"typedefs": _typedefs, "time": _time}
