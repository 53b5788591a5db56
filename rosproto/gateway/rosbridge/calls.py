"""Service calls of one client: each waits in a thread of its own, and is answered by its id."""

from __future__ import annotations

import json
import threading
from contextlib import closing
from functools import partial
from typing import TYPE_CHECKING

from rosproto.errors import RosError
from rosproto.gateway.rosbridge.operations import CallService
from rosproto.gateway.rosbridge.rosapi import RosapiError
from rosproto.gateway.rosbridge.shared import Refused, Shared, insist
from rosproto.gateway.rosbridge.values import from_arguments, to_json
from rosproto.node.services.client import Cancellation
from rosproto.node.services.probe import probe
from rosproto.transport.deadline import Deadline

if TYPE_CHECKING:
    from rosproto.gateway.rosbridge.session import RosbridgeSession

__all__ = ["Calls"]

CANCEL_ALL = "/_action/cancel_goal"
"""Behind an action's name: ROS 2's service that cancels its goals."""


class Calls:
    """The unanswered service calls of one client."""

    def __init__(self, shared: Shared, session: RosbridgeSession) -> None:
        self._shared = shared
        self._session = session
        self._lock = threading.Lock()
        self._open: set[Cancellation] = set()
        self._closed = False

    def call(self, asked: CallService) -> None:
        """Start a call; its answer comes later, even if it fails."""
        cancellation = Cancellation()
        with self._lock:
            full = len(self._open) >= self._shared.limits.calls_per_client
            if self._closed:
                return
            if not full:
                self._open.add(cancellation)
        if full:
            text = f"{self._shared.limits.calls_per_client} calls have not been answered, which is the limit"
            self._fail(asked, text)
            return
        self._shared.pool.spawn(partial(self._run, asked, cancellation))

    def _run(self, asked: CallService, cancellation: Cancellation) -> None:
        """Runs in a thread of its own; must not raise."""
        try:
            with self._shared.waiting(long=asked.long):
                values = self._values(asked, cancellation)
            self._session.answer(self._session.protocol.service_response, asked, values)
        except (Refused, RosapiError, RosError, ValueError) as error:
            self._fail(asked, str(error))
        except Exception as error:
            self._fail(asked, f"an error of the gateway ({type(error).__name__})")
            raise
        finally:
            with self._lock:
                self._open.discard(cancellation)

    def _values(self, asked: CallService, cancellation: Cancellation) -> str:
        """The response's JSON text."""
        shared = self._shared
        if shared.rosapi is not None and shared.rosapi.answers(asked.service):
            return json.dumps(shared.rosapi.call(asked.service, asked.args))
        name = shared.node.resolve_name(asked.service)
        if name.endswith(CANCEL_ALL):
            return self._cancel_all(name[: -len(CANCEL_ALL)])
        insist(shared.access.may_read("service", name))
        is_tf = shared.tf.opens(name)
        limit = shared.limits.call_seconds
        deadline = Deadline(limit if asked.timeout is None else min(asked.timeout, limit))
        header = probe(shared.node, name, deadline.at_most(limit))
        type_name = header.get("type", "")
        if not is_tf:
            insist(shared.access.may_write("service", name, type_name))
        cls = shared.service_class(type_name)
        request = from_arguments(cls._request_class, asked.args, now=shared.node.clock.now())
        with shared.node.service_client(name, cls) as client:
            response = client.call_cancellable(cancellation, request, deadline.remaining())
        return to_json(response)

    def _cancel_all(self, action: str) -> str:
        """What roslib's `Action.cancelAllGoals` calls in ROS 2, said on the action's topic of ROS 1."""
        insist(self._shared.access.may_write("action", action))
        publications, goal_id = self._shared.publications, self._shared.message_class("actionlib_msgs/GoalID")
        cancel = publications.open(self._session, f"{action}/cancel", goal_id, latch=False, queue_size=1)
        with closing(cancel):
            cancel.publish(goal_id())
        return '{"return_code":0,"goals_canceling":[]}'

    def _fail(self, asked: CallService, text: str) -> None:
        self._session.answer(self._session.protocol.service_failure, asked, text)

    def close(self) -> None:
        """Cancel the calls when the client has gone and nobody waits for the answers."""
        with self._lock:
            self._closed = True
            waiting = list(self._open)
        for cancellation in waiting:
            cancellation.cancel()
