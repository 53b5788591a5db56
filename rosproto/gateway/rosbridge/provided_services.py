"""Services that one client provides: calls of ROS programs go to the client, its answers go back to them."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from rosproto.errors import CodecError, ServiceError
from rosproto.gateway.rosbridge.client_provided import GONE, ClientProvided, Request
from rosproto.gateway.rosbridge.operations import AdvertiseService, ServiceResponse, UnadvertiseService
from rosproto.gateway.rosbridge.shared import Refused, Shared, insist
from rosproto.gateway.rosbridge.values import from_values, to_json

if TYPE_CHECKING:
    from rosproto.gateway.rosbridge.session import RosbridgeSession
    from rosproto.node import ServiceServer

__all__ = ["ProvidedServices"]


class ProvidedServices:
    """The services that one client provides."""

    def __init__(self, shared: Shared, session: RosbridgeSession) -> None:
        self._shared = shared
        self._session = session
        self._provided: ClientProvided[ServiceServer, Request[ServiceResponse]] = ClientProvided(
            "service_request"
        )

    def advertise(self, asked: AdvertiseService) -> None:
        """Provide a service; replaces the client's earlier one of that name.

        Raises:
            Refused, RosError: It cannot be provided.
        """
        name = self._shared.node.resolve_name(asked.service)
        insist(self._shared.access.may_write("service", name))
        if self._shared.rosapi is not None and self._shared.rosapi.answers(name):
            raise Refused(f"{name} is answered by the gateway itself")
        cls = self._shared.service_class(asked.type)
        self.unadvertise(UnadvertiseService(None, asked.service))
        if len(self._provided) >= self._shared.limits.advertised_per_client:
            raise Refused(f"{len(self._provided)} services are provided, which is the limit for a client")
        handler = partial(self._called, asked.service, name, cls)
        server = self._shared.node.service_server(name, cls, handler)
        if not self._provided.add(asked.service, server):
            server.close()

    def unadvertise(self, asked: UnadvertiseService) -> None:
        """Stop providing a service; waiting calls fail."""
        server = self._provided.remove(asked.service)
        if server is not None:
            server.close()

    def respond(self, given: ServiceResponse) -> None:
        """Pass on the client's answer to a call.

        Raises:
            Refused: No call waits for it.
        """
        self._provided.answer(given.id, given, "call")

    def _called(self, service: str, name: str, cls: Any, request: Any) -> Any:
        """Called in the thread of the caller's connection."""
        limits = self._shared.limits
        call: Request[ServiceResponse] = Request(service)
        problem = self._provided.begin(call, limits.calls_per_client)
        if problem is not None:
            raise ServiceError(name, problem)
        try:
            self._session.answer(self._session.protocol.call_service, call.id, service, to_json(request))
            if not call.done.wait(limits.call_seconds):
                raise ServiceError(
                    name, f"the client that provides it has not answered within {limits.call_seconds:g} s"
                )
        finally:
            self._provided.end(call)
        answer = call.answer
        if answer is None:
            raise ServiceError(name, GONE)
        if not answer.result:
            raise ServiceError(name, str(answer.values)[:1000] if answer.values else "the client says no")
        try:
            return from_values(
                cls._response_class,
                {} if answer.values is None else answer.values,
                now=self._shared.node.clock.now(),
            )
        except CodecError as error:
            self._session.status("error", f"service_response: {service}: {error}", answer.id)
            raise ServiceError(name, f"the client's answer does not fit: {error}") from error

    def close(self) -> None:
        """The client has gone: stop providing its services; waiting calls fail."""
        for server in self._provided.close():
            server.close()
