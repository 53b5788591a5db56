"""Services that one client provides: calls of ROS programs go to the client, its answers go back to them."""

from __future__ import annotations

import itertools
import threading
from functools import partial
from typing import TYPE_CHECKING, Any

from rosproto.errors import CodecError, ServiceError
from rosproto.gateway.rosbridge.effects import AdvertiseService, ServiceResponse, UnadvertiseService
from rosproto.gateway.rosbridge.shared import Refused, Shared, insist
from rosproto.gateway.rosbridge.values import from_values, to_json

if TYPE_CHECKING:
    from rosproto.gateway.rosbridge.session import RosbridgeSession
    from rosproto.node import ServiceServer

__all__ = ["ProvidedServices"]


class _Call:
    """A call of a ROS program that the client has not answered yet.

    Attributes:
        service: The name that the client advertised.
        done: Set with the answer, or when there will be none.
        answer: The client's answer; None if it has gone, or no longer provides the service.
    """

    def __init__(self, service: str) -> None:
        self.service = service
        self.done = threading.Event()
        self.answer: ServiceResponse | None = None


class ProvidedServices:
    """The services that one client provides."""

    def __init__(self, shared: Shared, session: RosbridgeSession) -> None:
        self._shared = shared
        self._session = session
        self._lock = threading.Lock()
        self._servers: dict[str, ServiceServer] = {}
        self._calls: dict[str, _Call] = {}
        self._numbers = itertools.count(1)
        self._closed = False

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
        if len(self._servers) >= self._shared.limits.advertised_per_client:
            raise Refused(f"{len(self._servers)} services are provided, which is the limit for a client")
        handler = partial(self._called, asked.service, name, cls)
        server = self._shared.node.service_server(name, cls, handler)
        with self._lock:
            if not self._closed:
                self._servers[asked.service] = server
                return
        server.close()

    def unadvertise(self, asked: UnadvertiseService) -> None:
        """Stop providing a service; waiting calls fail."""
        with self._lock:
            server = self._servers.pop(asked.service, None)
        if server is not None:
            self._give_up(asked.service)
            server.close()

    def respond(self, given: ServiceResponse) -> None:
        """Pass on the client's answer to a call.

        Raises:
            Refused: No call waits for it.
        """
        with self._lock:
            call = self._calls.pop(str(given.id), None)
        if call is None:
            raise Refused(f"no call with the id {given.id!r} waits for an answer")
        call.answer = given
        call.done.set()

    def _called(self, service: str, name: str, cls: Any, request: Any) -> Any:
        """Called in the thread of the caller's connection."""
        limits = self._shared.limits
        id = f"service_request:{service}:{next(self._numbers)}"
        call = _Call(service)
        with self._lock:
            if self._closed or service not in self._servers:
                raise ServiceError(name, "the client that provides it has gone")
            if len(self._calls) >= limits.calls_per_client:
                raise ServiceError(name, "the client that provides it has too many calls to answer")
            self._calls[id] = call
        try:
            self._session.answer(self._session.protocol.call_service, id, service, to_json(request))
            if not call.done.wait(limits.call_seconds):
                raise ServiceError(
                    name, f"the client that provides it has not answered within {limits.call_seconds:g} s"
                )
        finally:
            with self._lock:
                self._calls.pop(id, None)
        answer = call.answer
        if answer is None:
            raise ServiceError(name, "the client that provides it has gone")
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

    def _give_up(self, service: str | None) -> None:
        with self._lock:
            ended = [call for call in self._calls.values() if service in (None, call.service)]
        for call in ended:
            call.done.set()

    def close(self) -> None:
        """The client has gone: stop providing its services; waiting calls fail."""
        with self._lock:
            self._closed = True
            servers, self._servers = list(self._servers.values()), {}
        self._give_up(None)
        for server in servers:
            server.close()
