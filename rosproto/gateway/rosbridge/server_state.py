"""What the sessions of one rosbridge server share."""

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

CALLS = 256  # service calls and goals of all clients; each takes a thread
LONG_CALLS = 8  # of those, with long arguments: each takes some megabytes until it has ended
LONG_MESSAGES = 2  # of all clients that are read and carried out at a time


@dataclass
class ServerState:
    """The server's parts, for its sessions.

    Attributes:
        node: Subscribes, publishes, calls.
        access: What clients may do.
        limits: What a client may cost.
        shared_subscriptions: Topics that are read.
        publications: Topics that are written.
        rosapi: Answers /rosapi; None where it does not.
        pool: Threads for what has to wait.
        tf: The tf republisher.
        authenticate: Clients have to send credentials of rosauth before anything else.
        json: Reads what clients send.
        long_messages: Entered while a long message is read and carried out, in the order in which they came.
        reading: Held while one of them is read.
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
        """While a thread waits for somebody else's answer.

        Args:
            long: The question is a long one.

        Raises:
            Refused: Too many do.
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
        """A client provides an action.

        Raises:
            Refused: Another one does.
        """
        with self._lock:
            if name in self._actions:
                raise Refused(f"{name} is provided by another client")
            self._actions.add(name)

    def leave_action(self, name: str) -> None:
        """It does not any more."""
        with self._lock:
            self._actions.discard(name)

    def message_class(self, name: str) -> type[Message]:
        """The class of a type as a client names it.

        Raises:
            DefinitionError: Nobody knows it.
        """
        name = definition_name(name)
        return message_class(name, self.node.revisions.library_for(name))

    def service_class(self, name: str) -> Any:
        """As `message_class`, of a service."""
        name = definition_name(name)
        return service_class(name, self.node.revisions.library_for(name, "srv"))

    def topic_type(self, topic: str) -> str | None:
        """The type that the master has for a topic; None when it has none.

        Raises:
            MasterError, ConnectionLost, RosTimeout: It cannot be asked.
        """
        known = self.node.master.get_topic_types().get(topic)
        return None if known in (None, "", "*") else known
