"""`ServerState`: the parts of one rosbridge server that its sessions share."""

from __future__ import annotations

import asyncio
import threading

from rosproto.codec import Message, ServiceType, message_class, service_class
from rosproto.gateway.access import Access, Refused
from rosproto.gateway.client_limits import GatewayLimits
from rosproto.gateway.gateway_server import GatewayState
from rosproto.gateway.rosbridge.rosapi import Rosapi
from rosproto.gateway.rosbridge.tf_republisher import TfOnDemand
from rosproto.gateway.values import definition_name
from rosproto.logs import PeerLog
from rosproto.node import Node
from rosproto.watchdog import Watchdog

LONG_MESSAGES = 2  # of all clients, handled at a time


class ServerState(GatewayState):
    """The parts that the sessions share.

    Attributes:
        peer_log: Bounded log about clients.
        rosapi: Answers /rosapi; None if the server does not.
        tf: The tf republisher.
        authenticate: Clients must send credentials of rosauth first.
        long_messages: Held while a long message is read and carried out, in order of arrival.
        reading: Held while one of them is decoded.
    """

    def __init__(
        self,
        node: Node,
        access: Access,
        limits: GatewayLimits,
        watchdog: Watchdog | None,
        *,
        rosapi: bool,
        authenticate: bool,
    ) -> None:
        super().__init__(node, "rosbridge", access, limits, watchdog)
        self.peer_log = PeerLog("rosproto.gateway")
        self.rosapi = Rosapi(node, access) if rosapi else None
        self.tf = TfOnDemand(node, access)
        self.authenticate = authenticate
        self.long_messages = asyncio.Semaphore(LONG_MESSAGES)
        self.reading = asyncio.Lock()
        self._lock = threading.Lock()
        self._actions: set[str] = set()

    def close(self, timeout: float) -> None:
        """Release everything, after the sessions have ended."""
        self.tf.close()
        super().close(timeout)

    def take_action(self, name: str) -> None:
        """Reserve the name of an action for a client.

        Raises:
            Refused: Another client provides it.
        """
        with self._lock:
            if name in self._actions:
                raise Refused(f"{name} is provided by another client")
            self._actions.add(name)

    def leave_action(self, name: str) -> None:
        """Release the name of an action."""
        with self._lock:
            self._actions.discard(name)

    def message_class(self, name: str) -> type[Message]:
        """The class of a message type, in a client's spelling.

        Raises:
            DefinitionError: The type is unknown.
        """
        name = definition_name(name)
        return message_class(name, self.node.definitions.library_for(name))

    def service_class(self, name: str) -> type[ServiceType]:
        """As `message_class`, for a service."""
        name = definition_name(name)
        return service_class(name, self.node.definitions.library_for(name, "srv"))
