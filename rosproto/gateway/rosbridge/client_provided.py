"""What one client provides to the graph, and the requests it has not answered yet.

A service and an action differ in what is asked and answered. What they share is here: the server of each name
that the client advertises, requests that wait for the client's answer by their id, and the end of both when
the client stops providing a name or leaves.
"""

from __future__ import annotations

import itertools
import threading
from typing import Generic, TypeVar

from rosproto.gateway.rosbridge.shared import Refused

__all__ = ["GONE", "ClientProvided", "Request"]

Server = TypeVar("Server")
Answer = TypeVar("Answer")
R = TypeVar("R", bound="Request")  # type: ignore[type-arg]

GONE = "the client that provides it has gone"


class Request(Generic[Answer]):
    """What a ROS program has asked of the client.

    Attributes:
        name: As the client advertised it.
        id: Given by `ClientProvided.begin`.
        done: Set with the answer, or when there will be none.
        answer: The client's answer; None if it has gone, or no longer provides the name.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.id = ""
        self.done = threading.Event()
        self.answer: Answer | None = None


class ClientProvided(Generic[Server, R]):
    """The servers of one client's names, and its open requests.

    Args:
        kind: What the ids of requests begin with.
    """

    def __init__(self, kind: str) -> None:
        self._kind = kind
        self._lock = threading.Lock()
        self._servers: dict[str, Server] = {}
        self._requests: dict[str, R] = {}
        self._numbers = itertools.count(1)
        self._closed = False

    def __len__(self) -> int:
        """How many names the client provides."""
        return len(self._servers)

    def add(self, name: str, server: Server) -> bool:
        """Keep the server of a name; False if the client has gone meanwhile."""
        with self._lock:
            if not self._closed:
                self._servers[name] = server
            return not self._closed

    def server(self, name: str) -> Server | None:
        """The server of a name; None if the client does not provide it."""
        return self._servers.get(name)

    def remove(self, name: str) -> Server | None:
        """Take out the server of a name, for the caller to close; its requests end without an answer."""
        with self._lock:
            server = self._servers.pop(name, None)
        if server is not None:
            self._end_requests(name)
        return server

    def begin(self, request: R, most: int | None = None) -> str | None:
        """Give a request its id and let it wait; None, or a sentence that says why it cannot.

        Args:
            request: What is asked.
            most: How many may wait at a time.
        """
        with self._lock:
            if self._closed or request.name not in self._servers:
                return GONE
            if most is not None and len(self._requests) >= most:
                return "the client that provides it has too many calls to answer"
            request.id = f"{self._kind}:{request.name}:{next(self._numbers)}"
            self._requests[request.id] = request
        return None

    def waiting(self, id: object) -> R | None:
        """The request with this id, if it still waits for an answer."""
        with self._lock:
            found = self._requests.get(str(id))
        return None if found is None or found.done.is_set() else found

    def answer(self, id: object, answer: object, what: str) -> None:
        """The client answers the request with this id.

        Raises:
            Refused: None waits; `what` names it in the sentence.
        """
        with self._lock:
            found = self._requests.get(str(id))
            if found is None or found.done.is_set():
                raise Refused(f"no {what} with the id {id!r} waits for an answer")
            found.answer = answer
            found.done.set()

    def end(self, request: R) -> None:
        """The request waits no longer."""
        with self._lock:
            self._requests.pop(request.id, None)

    def _end_requests(self, name: str | None) -> None:
        with self._lock:
            ended = [request for request in self._requests.values() if name in (None, request.name)]
        for request in ended:
            request.done.set()

    def close(self) -> list[Server]:
        """The client has gone; returns its servers, for the caller to close. All requests end."""
        with self._lock:
            self._closed = True
            servers, self._servers = list(self._servers.values()), {}
        self._end_requests(None)
        return servers
