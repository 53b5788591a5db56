"""`ServerState`: the parts of one rosbridge server that its sessions share."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from rosproto.aio.pool import Pool
from rosproto.codec import Message, message_class, service_class
from rosproto.gateway.access import Access, Refused
from rosproto.gateway.client_limits import GatewayLimits
from rosproto.gateway.client_publications import ClientPublications
from rosproto.gateway.json_text import JsonReader
from rosproto.gateway.rosbridge.tf_on_demand import TfOnDemand
from rosproto.gateway.shared_subscriptions import SharedSubscriptions
from rosproto.gateway.values import definition_name
from rosproto.node import Node

if TYPE_CHECKING:
    from rosproto.gateway.rosbridge.rosapi import Rosapi

CALLS = 256  # service calls and goals of all clients; each has a thread
LONG_CALLS = 8  # of those, with long arguments: each takes some megabytes until it ends
LONG_MESSAGES = 2  # of all clients, handled at a time


@dataclass
class ServerState:
    """The parts that the sessions share.

    Attributes:
        node: Subscribes, publishes, calls.
        access: What clients may do.
        limits: Bounds for a client.
        shared_subscriptions: Topics that are read.
        publications: Topics that are written.
        rosapi: Answers /rosapi; None if the server does not.
        pool: Threads for work that waits.
        tf: The tf republisher.
        authenticate: Clients must send credentials of rosauth first.
        json: Reads messages of clients.
        long_messages: Held while a long message is read and carried out, in order of arrival.
        reading: Held while one of them is decoded.
    """

    node: Node
    access: Access
    limits: GatewayLimits
    shared_subscriptions: SharedSubscriptions
    publications: ClientPublications
    rosapi: Rosapi | None
    pool: Pool
    tf: TfOnDemand
    json: JsonReader
    authenticate: bool = False
    long_messages: asyncio.Semaphore = field(default_factory=lambda: asyncio.Semaphore(LONG_MESSAGES))
    reading: asyncio.Lock = field(default_factory=asyncio.Lock)
    _lock: threading.Lock = field(default_factory=threading.Lock)
    _waiting: int = 0
    _waiting_long: int = 0
    _actions: set[str] = field(default_factory=set)

    @contextmanager
    def waiting(self, *, long: bool = False) -> Iterator[None]:
        """Count a call or goal that waits for its answer.

        Args:
            long: Its arguments are long.

        Raises:
            Refused: Too many wait.
        """
        with self._lock:
            if self._waiting >= CALLS:
                raise Refused(
                    f"{CALLS} calls of all clients together have not been answered; try again later"
                )
            if long and self._waiting_long >= LONG_CALLS:
                raise Refused(
                    f"{LONG_CALLS} calls and goals with long arguments, of all clients together, "
                    "have not ended; try again later"
                )
            self._waiting += 1
            self._waiting_long += long
        try:
            yield
        finally:
            with self._lock:
                self._waiting -= 1
                self._waiting_long -= long

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
        return message_class(name, self.node.revisions.library_for(name))

    def service_class(self, name: str) -> Any:
        """As `message_class`, for a service."""
        name = definition_name(name)
        return service_class(name, self.node.revisions.library_for(name, "srv"))

    def topic_type(self, topic: str) -> str | None:
        """The type of a topic by the master; None if unknown.

        Raises:
            MasterError, ConnectionLost, RosTimeout: The master does not answer.
        """
        known = self.node.master.get_topic_types().get(topic)
        return None if known in (None, "", "*") else known
