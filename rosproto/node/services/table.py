"""The services of one node: its providers by name, its clients, and dispatch of incoming connections.

Source: wiki.ros.org/ROS/TCPROS, wiki.ros.org/ROS/Master_API (registerService).
"""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable, Mapping

from rosproto.codec import Message, ServiceType, service_class
from rosproto.errors import LocalProtocolError, RosError, ServiceError
from rosproto.logs import get_logger
from rosproto.node.context import Context
from rosproto.node.definitions.known_definitions import KnownDefinitions
from rosproto.node.definitions.type_argument import ServiceTypeGiven, resolve_service_type
from rosproto.node.graph.listening import refuse
from rosproto.node.graph.master_client import CallerIdentity, MasterClient
from rosproto.node.graph.registrations import RegistrationCall
from rosproto.node.services import probe as service_probe
from rosproto.node.services.client import ServiceClient
from rosproto.node.services.server import ServiceServer
from rosproto.transport.deadline import Deadline
from rosproto.transport.uri import format_address

PROBE_SECONDS = 10.0


def ask_type(caller: CallerIdentity, definitions: KnownDefinitions, service: str) -> type[ServiceType]:
    """The service class that the current provider reports.

    Raises:
        ServiceError, ConnectionLost, RosTimeout: It does not answer.
        DefinitionError: Its type is unknown.
    """
    name = service_probe.probe(caller, service, Deadline(PROBE_SECONDS)).get("type", "")
    if not name or name == "*":
        raise ServiceError(service, "its provider does not report the type; specify it")
    return service_class(name, definitions.library_for(name, "srv"))


CLOSE_SECONDS = 1.0  # for answers in progress when the node closes

logger = get_logger("rosproto.node")


class ServiceRegistration:
    """Registration of one provider at the master (`registration.Registration`)."""

    kind = "service"

    def __init__(self, context: Context, name: str) -> None:
        self._context = context
        self.name = name
        self._registered_as = ""

    def registration_call(self) -> RegistrationCall:
        uri = self._context.listening.endpoints.rosrpc_uri
        return RegistrationCall(
            "registerService",
            (self.name, uri, self._context.uri),
            lambda _: setattr(self, "_registered_as", uri),
        )

    def unregister(self, master: MasterClient) -> int:
        # The master unregisters a service only with its current URI: another node may provide it by now.
        return master.unregister_service(
            self.name, self._registered_as or self._context.listening.endpoints.rosrpc_uri
        )


class Services:
    """Table of the service providers and clients of one node; safe from any thread."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self._lock = threading.Lock()
        self._servers: dict[str, tuple[ServiceServer, ServiceRegistration]] = {}
        self._clients: set[ServiceClient] = set()
        self._closed = False
        context.listening.endpoints.tcpros.on_service = self.on_service
        context.lifecycle.closers.append(self.close)

    def client(self, name: str, type_: ServiceTypeGiven, *, persistent: bool = False) -> ServiceClient:
        """A new client of the service with this resolved name.

        Args:
            name: Resolved name.
            type_: Service class or "package/Type"; None asks the provider, which must be running.
            persistent: Keep the connection between calls.
        """
        service_class = (
            ask_type(self._context, self._context.definitions, name)
            if type_ is None
            else resolve_service_type(type_, name, self._context.definitions)
        )
        client = ServiceClient(
            self._context, name, service_class, persistent=persistent, on_close=self.forget_client
        )
        with self._lock:
            self._refuse_when_closed(name)
            self._clients.add(client)
        return client

    def server(
        self,
        name: str,
        type_: ServiceTypeGiven,
        handler: Callable[[Message], object],
    ) -> ServiceServer:
        """Provide a service; it accepts calls when this returns.

        Raises:
            LocalProtocolError: This node already provides a service of that name.
            MasterError, ConnectionLost, RosTimeout: The registration failed; the service is not provided.
        """
        if not callable(handler):
            raise TypeError(f"service {name}: the handler is a {type(handler).__name__}, expected a callable")
        server = ServiceServer(
            self._context,
            name,
            resolve_service_type(type_, name, self._context.definitions),
            handler,
            on_close=self.forget_server,
        )
        registration = ServiceRegistration(self._context, name)
        with self._lock:
            self._refuse_when_closed(name)
            if name in self._servers:
                raise LocalProtocolError(
                    f"service {name}: this node already provides it as {self._servers[name][0].type_name};"
                    " close that server first"
                )
            self._servers[name] = (server, registration)
        try:
            self._context.registrations.register_in_batch(registration, undo=server.close)
        except BaseException:
            with self._lock:
                self._servers.pop(name, None)
            raise
        return server

    def _refuse_when_closed(self, name: str) -> None:
        if self._closed:
            raise LocalProtocolError(f"service {name}: node {self._context.name} is closed")

    def on_service(self, sock: socket.socket, fields: Mapping[str, str], peer: tuple[str, int]) -> None:
        """Serve one incoming connection; runs in its own thread and owns the socket until it returns."""
        name = fields.get("service", "")
        who = format_address(*peer[:2])
        with self._lock:
            entry = self._servers.get(name)
        try:
            if entry is None:
                text = f"[{self._context.name}] is not a provider of [{name}]"
                refuse(sock, text)
                logger.debug("! %s %s: %s", fields.get("callerid", ""), who, text)
            else:
                entry[0].accept(sock, fields, who)
        except RosError as error:
            logger.warning("! refused %s %s: %s", fields.get("callerid", "a client"), who, error)
        finally:
            sock.close()

    def forget_server(self, server: ServiceServer) -> None:
        """Remove and unregister a provider; called by its `close`."""
        with self._lock:
            entry = self._servers.get(server.name)
            if entry is None or entry[0] is not server:
                return
            del self._servers[server.name]
        self._context.registrations.remove(entry[1])

    def forget_client(self, client: ServiceClient) -> None:
        """Remove a client; called by its `close`."""
        with self._lock:
            self._clients.discard(client)

    def stats(self) -> dict[str, dict[str, dict[str, int]]]:
        """Counters of every provider and client, by service name (summed over clients of one service)."""
        with self._lock:
            servers = {name: entry[0].stats() for name, entry in self._servers.items()}
            clients: dict[str, dict[str, int]] = {}
            for client in self._clients:
                total = clients.setdefault(client.name, {})
                for key, count in client.stats().items():
                    total[key] = total.get(key, 0) + count
        return {"servers": servers, "clients": clients}

    def abandon(self) -> None:
        """Mark as closed in a forked process, without taking a lock."""
        self._closed, self._servers = True, {}
        for client in self._clients:
            client.abandon()

    def close(self) -> None:
        """End all clients, then all providers, within a second; the node unregisters them."""
        with self._lock:
            self._closed = True
            clients, servers = list(self._clients), [entry[0] for entry in self._servers.values()]
            self._servers.clear()
        for client in clients:
            client.close()
        for server in servers:
            server.finish()
        deadline = Deadline(CLOSE_SECONDS)
        for server in servers:
            server.join(deadline)
