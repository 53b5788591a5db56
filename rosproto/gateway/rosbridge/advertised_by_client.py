"""Services and actions that one client provides: calls and goals of ROS programs go to it, its answers back.

`AdvertisedByClient` is what both have in common: the ROS server of each name that the client advertises, and
the requests that wait for the client's answer. `calls_and_goals.py` is the other direction.
"""

from __future__ import annotations

import itertools
import threading
from abc import ABC, abstractmethod
from functools import partial
from typing import Generic, TypeVar

from rosproto.action import ActionServer, ServerGoal
from rosproto.codec import Message, ServiceType
from rosproto.errors import CodecError, RosError, ServiceError
from rosproto.gateway.access import Refused, insist
from rosproto.gateway.client_channel import ClientChannel
from rosproto.gateway.rosbridge.action_mapping import ActionStatus, action_type
from rosproto.gateway.rosbridge.operations import (
    ActionFeedback,
    ActionResult,
    AdvertiseAction,
    AdvertiseService,
    ServiceResponse,
    UnadvertiseAction,
    UnadvertiseService,
)
from rosproto.gateway.rosbridge.protocol import Protocol
from rosproto.gateway.rosbridge.server_state import ServerState
from rosproto.gateway.rosbridge.tf_republisher import is_tf_name
from rosproto.gateway.values import from_values, to_json
from rosproto.node import ServiceServer

Server = TypeVar("Server")
Answer = TypeVar("Answer")
R = TypeVar("R", bound="PendingRequest")  # type: ignore[type-arg]

GONE = "the client that provides it has gone"


class PendingRequest(Generic[Answer]):
    """A call or goal of a ROS program that waits for the client's answer.

    Attributes:
        name: As the client advertised it.
        id: Set by `AdvertisedByClient.begin`.
        done: Set with the answer, or when there will be none.
        answer: The client's answer; None if it has gone, or no longer provides the name.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.id = ""
        self.done = threading.Event()
        self.answer: Answer | None = None


class AdvertisedByClient(ABC, Generic[Server, R]):
    """The ROS servers of one client's names, and its pending requests.

    Attributes:
        kind: What a request is, in a sentence; `prefix` begins the ids of requests.
    """

    kind: str
    prefix: str

    def __init__(self, state: ServerState, protocol: Protocol, channel: ClientChannel) -> None:
        self._state = state
        self._protocol = protocol
        self._channel = channel
        self._lock = threading.Lock()
        self._servers: dict[str, Server] = {}
        self._requests: dict[str, R] = {}
        self._numbers = itertools.count(1)
        self._closed = False

    @abstractmethod
    def end(self, server: Server) -> None:
        """Close a server."""

    def add(self, name: str, server: Server) -> None:
        """Keep the server of a name; end it if the client has gone in the meantime."""
        with self._lock:
            closed = self._closed
            if not closed:
                self._servers[name] = server
        if closed:
            self.end(server)

    def remove(self, name: str) -> None:
        """End the server of a name, if there is one; its requests end without an answer."""
        with self._lock:
            server = self._servers.pop(name, None)
        if server is not None:
            self._end_requests(name)
            self.end(server)

    def begin(self, request: R, limit: int | None = None) -> str | None:
        """Register a request and set its id. Return None, or a sentence if it cannot be passed on.

        Args:
            request: The request.
            limit: Most requests at a time.
        """
        with self._lock:
            if self._closed or request.name not in self._servers:
                return GONE
            if limit is not None and len(self._requests) >= limit:
                return "the client that provides it has too many calls to answer"
            request.id = f"{self.prefix}:{request.name}:{next(self._numbers)}"
            self._requests[request.id] = request
        return None

    def waiting(self, id: object) -> R | None:
        """The pending request with this id, or None."""
        with self._lock:
            found = self._requests.get(str(id))
        return None if found is None or found.done.is_set() else found

    def answer(self, given: ServiceResponse | ActionResult) -> None:
        """Set the client's answer to the request with its id.

        Raises:
            Refused: There is no such request.
        """
        with self._lock:
            found = self._requests.get(str(given.id))
            if found is None or found.done.is_set():
                raise Refused(f"no {self.kind} with the id {given.id!r} is waiting for an answer")
            found.answer = given
            found.done.set()

    def forget(self, request: R) -> None:
        """Remove a request."""
        with self._lock:
            self._requests.pop(request.id, None)

    def _end_requests(self, name: str | None) -> None:
        with self._lock:
            ended = [request for request in self._requests.values() if name in (None, request.name)]
        for request in ended:
            request.done.set()

    def close(self) -> None:
        """The client has gone: end all requests, which then fail, and all servers."""
        with self._lock:
            self._closed = True
            servers, self._servers = list(self._servers.values()), {}
        self._end_requests(None)
        for server in servers:
            try:
                self.end(server)
            except RosError:
                continue  # end the others


class AdvertisedServices(AdvertisedByClient[ServiceServer, PendingRequest[ServiceResponse]]):
    """The services that one client provides."""

    kind, prefix = "call", "service_request"

    def advertise(self, asked: AdvertiseService) -> None:
        """Provide a service; replaces the client's earlier one of that name.

        Raises:
            Refused, RosError: It cannot be provided.
        """
        name = self._state.node.resolve_name(asked.service)
        insist(self._state.access.may_write("service", name))
        if self._state.rosapi is not None and self._state.rosapi.answers(name):
            raise Refused(f"{name} is answered by the gateway itself")
        cls = self._state.service_class(asked.type)
        self.remove(asked.service)
        if len(self._servers) >= self._state.limits.advertised_per_client:
            raise Refused(f"{len(self._servers)} services are provided, which is the limit for a client")
        handler = partial(self._called, asked.service, name, cls)
        self.add(asked.service, self._state.node.service_server(name, cls, handler))

    def unadvertise(self, asked: UnadvertiseService) -> None:
        """Stop providing a service; waiting calls fail."""
        self.remove(asked.service)

    def end(self, server: ServiceServer) -> None:
        server.close()

    def _called(self, service: str, name: str, cls: type[ServiceType], request: Message) -> Message:
        """Called in the thread of the caller's connection."""
        limits = self._state.limits
        call: PendingRequest[ServiceResponse] = PendingRequest(service)
        problem = self.begin(call, limits.calls_per_client)
        if problem is not None:
            raise ServiceError(name, problem)
        try:
            self._channel.answer(self._protocol.call_service(call.id, service, to_json(request)))
            if not call.done.wait(limits.call_seconds):
                raise ServiceError(
                    name, f"the client that provides it has not answered within {limits.call_seconds:g} s"
                )
        finally:
            self.forget(call)
        answer = call.answer
        if answer is None:
            raise ServiceError(name, GONE)
        if not answer.result:
            raise ServiceError(
                name, str(answer.values)[:1000] if answer.values else "the client reported failure"
            )
        try:
            return from_values(
                cls._response_class,
                {} if answer.values is None else answer.values,
                now=self._state.node.clock.now(),
            )
        except CodecError as error:
            self._channel.answer(
                self._protocol.status("error", f"service_response: {service}: {error}", answer.id)
            )
            raise ServiceError(name, f"the client's answer does not fit: {error}") from error


ACTIONS = 16  # of one client; each has five topics
CANCEL_CHECK_SECONDS = 0.05  # between two checks whether a goal was cancelled


class _Goal(PendingRequest[ActionResult]):
    """A goal that the client executes."""

    def __init__(self, action: str, goal: ServerGoal) -> None:
        super().__init__(action)
        self.goal = goal


class AdvertisedActions(AdvertisedByClient[ActionServer, _Goal]):
    """The actions that one client provides, and their goals."""

    kind, prefix = "goal", "action_goal"

    def advertise(self, asked: AdvertiseAction) -> None:
        """Provide an action; replaces the client's earlier one of that name.

        Raises:
            Refused, RosError: It cannot be provided.
        """
        name = self._state.node.resolve_name(asked.action)
        insist(self._state.access.may_write("action", name))
        if is_tf_name(name):
            raise Refused(f"{name} is provided by the gateway itself")
        self.remove(asked.action)
        if len(self._servers) >= ACTIONS:
            raise Refused(f"{ACTIONS} actions are provided, which is the limit for a client")
        self._state.take_action(name)
        try:
            server = ActionServer(
                self._state.node,
                name,
                action_type(asked.type),
                partial(self._work, asked.action, asked.type),
                concurrent=True,
                max_goals=self._state.limits.goals_per_client,
            )
        except BaseException:
            self._state.leave_action(name)
            raise
        self.add(asked.action, server)

    def unadvertise(self, asked: UnadvertiseAction) -> None:
        """Stop providing an action; its goals are aborted."""
        self.remove(asked.action)

    def end(self, server: ActionServer) -> None:
        server.close()
        self._state.leave_action(server.name)

    def feedback(self, given: ActionFeedback) -> None:
        """Publish the client's feedback on a goal.

        Raises:
            Refused, RosError: There is no such goal, or the feedback does not fit.
        """
        found = self.waiting(given.id)
        if found is None:
            raise Refused(f"no goal with the id {given.id!r} is waiting for an answer")
        server = self._servers.get(found.name)
        if server is not None:
            now = self._state.node.clock.now()
            found.goal.publish_feedback(from_values(server.type.feedback, given.values, now=now))

    def _work(self, action: str, type_name: str, goal: ServerGoal) -> None:
        """Send one goal to the client and wait for its result; runs in its own thread."""
        mine = _Goal(action, goal)
        problem = self.begin(mine)
        if problem is not None:
            goal.abort(text=problem)
            return
        try:
            self._channel.answer(
                self._protocol.send_action_goal(mine.id, action, type_name, to_json(goal.goal))
            )
            cancelled = False
            while not mine.done.wait(None if cancelled else CANCEL_CHECK_SECONDS):
                if goal.cancel_requested and not cancelled:
                    cancelled = True
                    self._channel.answer(self._protocol.cancel_action_goal(mine.id, action))
        finally:
            self.forget(mine)
        self._conclude(mine)

    def _conclude(self, mine: _Goal) -> None:
        """End the goal with the client's result."""
        answer, goal = mine.answer, mine.goal
        server = self._servers.get(mine.name)
        if answer is None or server is None:
            goal.abort(text=GONE)
            return
        if not answer.result:
            goal.abort(
                text=answer.values[:1000] if isinstance(answer.values, str) else "the client reported failure"
            )
            return
        try:
            values = {} if answer.values is None else answer.values
            result = from_values(server.type.result, values, now=self._state.node.clock.now())
        except CodecError as error:
            self._channel.answer(
                self._protocol.status("error", f"action_result: {mine.name}: {error}", answer.id)
            )
            goal.abort(text=f"the client's result does not fit: {error}")
            return
        ends = {ActionStatus.SUCCEEDED: goal.succeed, ActionStatus.CANCELED: goal.preempted}
        ends.get(ActionStatus(answer.status), goal.abort)(result)
