"""Service calls and action goals that one client sends to ROS programs, each in its own thread.

A goal continues when its client leaves, as it does when a rospy program ends; calls are cancelled.
`advertised_by_client.py` is the other direction.
"""

from __future__ import annotations

import json
import threading
from contextlib import closing
from functools import partial

from rosproto.action import ActionClient
from rosproto.action.goal_handle import GoalHandle
from rosproto.codec import Message
from rosproto.errors import RosError
from rosproto.gateway.access import Refused, insist
from rosproto.gateway.client_channel import ClientChannel
from rosproto.gateway.rosbridge.action_mapping import action_status, action_type
from rosproto.gateway.rosbridge.fields import Id
from rosproto.gateway.rosbridge.operations import CallService, CancelActionGoal, SendActionGoal
from rosproto.gateway.rosbridge.protocol import Protocol
from rosproto.gateway.rosbridge.server_state import ServerState
from rosproto.gateway.rosbridge.tf_republisher import ACTION_TYPE, is_tf_name
from rosproto.gateway.values import from_arguments, to_json
from rosproto.node.services.link import Cancellation
from rosproto.node.services.probe import probe
from rosproto.transport.deadline import Deadline

CANCEL_ALL = "/_action/cancel_goal"
"""Suffix of an action's name: ROS 2's service that cancels its goals."""


class ServiceCalls:
    """The unanswered service calls of one client."""

    def __init__(self, state: ServerState, protocol: Protocol, channel: ClientChannel) -> None:
        self._state = state
        self._protocol = protocol
        self._channel = channel
        self._lock = threading.Lock()
        self._open: set[Cancellation] = set()
        self._closed = False

    def call(self, asked: CallService) -> None:
        """Start a call; its answer comes later, even if it fails."""
        cancellation = Cancellation()
        with self._lock:
            full = len(self._open) >= self._state.limits.calls_per_client
            if self._closed:
                return
            if not full:
                self._open.add(cancellation)
        if full:
            text = f"{self._state.limits.calls_per_client} calls have not been answered, which is the limit"
            self._fail(asked, text)
            return
        self._state.pool.spawn(partial(self._run, asked, cancellation))

    def _run(self, asked: CallService, cancellation: Cancellation) -> None:
        """Runs in its own thread."""
        try:
            with self._state.waiting(long=asked.long):
                values = self._values(asked, cancellation)
            self._channel.answer(self._protocol.service_response(asked, values))
        except (Refused, RosError, ValueError) as error:
            self._fail(asked, str(error))
        except Exception as error:
            self._fail(asked, f"an error of the gateway ({type(error).__name__})")
            raise
        finally:
            with self._lock:
                self._open.discard(cancellation)

    def _values(self, asked: CallService, cancellation: Cancellation) -> str:
        """The response's JSON text."""
        state = self._state
        if state.rosapi is not None and state.rosapi.answers(asked.service):
            return json.dumps(state.rosapi.call(asked.service, asked.args))
        name = state.node.resolve_name(asked.service)
        if name.endswith(CANCEL_ALL):
            return self._cancel_all(name[: -len(CANCEL_ALL)])
        insist(state.access.may_read("service", name))
        is_tf = state.tf.opens(name)
        limit = state.limits.call_seconds
        deadline = Deadline(limit if asked.timeout is None else min(asked.timeout, limit))
        header = probe(state.node, name, deadline.at_most(limit))
        type_name = header.get("type", "")
        if not is_tf:
            insist(state.access.may_write("service", name, type_name))
        cls = state.service_class(type_name)
        request = from_arguments(cls._request_class, asked.args, now=state.node.clock.now())
        with state.node.service_client(name, cls) as client:
            response = client.call_cancellable(cancellation, request, deadline.remaining())
        return to_json(response)

    def _cancel_all(self, action: str) -> str:
        """Cancel all goals of an action, for roslib's `Action.cancelAllGoals`, made for ROS 2."""
        insist(self._state.access.may_write("action", action))
        goal_id = self._state.message_class("actionlib_msgs/GoalID")
        cancel = self._state.publications.open(self, f"{action}/cancel", goal_id, queue_size=1)
        with closing(cancel):
            cancel.publish(goal_id())
        return '{"return_code":0,"goals_canceling":[]}'

    def _fail(self, asked: CallService, text: str) -> None:
        self._channel.answer(self._protocol.service_failure(asked, text))

    def close(self) -> None:
        """Cancel the calls; the client has gone."""
        with self._lock:
            self._closed = True
            waiting = list(self._open)
        for cancellation in waiting:
            cancellation.cancel()


SERVER_SECONDS = 5.0
ACTIONS = 16  # used by one client at a time; each has five topics


class ActionGoals:
    """Goals of one client that have not ended."""

    def __init__(self, state: ServerState, protocol: Protocol, channel: ClientChannel) -> None:
        self._state = state
        self._protocol = protocol
        self._channel = channel
        self._lock = threading.Lock()
        self._opening = threading.Lock()
        self._clients: dict[tuple[str, str], ActionClient] = {}
        self._goals: dict[tuple[str, Id], GoalHandle | None] = {}
        self._cancelled: set[tuple[str, Id]] = set()
        self._closed = False

    def send(self, asked: SendActionGoal) -> None:
        """Start a goal; its result comes later, even if it cannot be sent."""
        try:
            name = self._state.node.resolve_name(asked.action)
            if not is_tf_name(name):
                insist(self._state.access.may_write("action", name))
            self._enter(name, asked)
        except (Refused, ValueError) as error:
            self._fail(asked, str(error))
            return
        self._state.pool.spawn(partial(self._run, name, asked))

    def _enter(self, name: str, asked: SendActionGoal) -> None:
        with self._lock:
            if self._closed:
                raise Refused("the connection has ended")
            if len(self._goals) >= self._state.limits.goals_per_client:
                raise Refused(f"{len(self._goals)} goals have not ended, which is the limit for a client")
            if (name, asked.id) in self._goals:
                raise Refused(f"a goal of {name} with the id {asked.id!r} has not ended; give another id")
            self._goals[name, asked.id] = None

    def _run(self, name: str, asked: SendActionGoal) -> None:
        """Runs in its own thread until the goal ends."""
        key = name, asked.id
        try:
            with self._state.waiting(long=asked.long):
                self._follow(key, asked)
        except (Refused, RosError, ValueError) as error:
            self._fail(asked, str(error))
        except Exception as error:
            self._fail(asked, f"an error of the gateway ({type(error).__name__})")
            raise
        finally:
            with self._lock:
                self._goals.pop(key, None)
                self._cancelled.discard(key)

    def _follow(self, key: tuple[str, Id], asked: SendActionGoal) -> None:
        kind = asked.action_type
        if self._state.tf.opens(key[0]):
            kind = ACTION_TYPE  # a page written for ROS 2 names another package
        else:
            insist(self._state.access.may_write("action", key[0]))
        client = self._client(key[0], kind)
        goal = from_arguments(client.type.goal, asked.args, now=self._state.node.clock.now())
        client.wait_for_server(SERVER_SECONDS)
        with self._lock:
            if key in self._cancelled:
                raise Refused("it was cancelled before it was sent")
        handle = client.send_goal(goal, feedback=partial(self._feedback, asked) if asked.feedback else None)
        with self._lock:
            self._goals[key] = handle
            cancelled = key in self._cancelled
        if cancelled:
            handle.cancel()
        result = handle.wait(None)
        status = action_status(handle.status)
        self._channel.answer(self._protocol.action_result(asked, to_json(result), status))

    def _client(self, name: str, type_name: str) -> ActionClient:
        kind = action_type(type_name)
        with self._opening:
            client = self._clients.get((name, kind))
            if client is None:
                if len(self._clients) >= ACTIONS:
                    raise Refused(f"{ACTIONS} actions are in use, which is the limit for a client")
                client = ActionClient(self._state.node, name, kind)
                with self._lock:
                    closed = self._closed
                    self._clients[name, kind] = client
                if closed:
                    client.close()
                    raise Refused("the connection has ended")
            return client

    def _feedback(self, asked: SendActionGoal, _: object, feedback: Message) -> None:
        self._channel.answer(self._protocol.action_feedback(asked, to_json(feedback)))

    def cancel(self, asked: CancelActionGoal) -> None:
        """Ask the action server to cancel a goal; its result follows.

        Raises:
            Refused, RosError: The client may not, or there is no such goal.
        """
        name = self._state.node.resolve_name(asked.action)
        if not is_tf_name(name):
            insist(self._state.access.may_write("action", name))
        key = name, asked.id
        with self._lock:
            if key not in self._goals:
                raise Refused(f"no goal of {name} with the id {asked.id!r} is under way")
            self._cancelled.add(key)
            handle = self._goals[key]
        if handle is not None:
            handle.cancel()

    def _fail(self, asked: SendActionGoal, text: str) -> None:
        self._channel.answer(self._protocol.action_failure(asked, text))

    def close(self) -> None:
        """The client has gone: its goals continue, except those that only send it transforms."""
        with self._lock:
            self._closed = True
            clients = list(self._clients.values())
            for (name, _), handle in self._goals.items():
                if handle is not None and is_tf_name(name):
                    handle.cancel()
        for client in clients:
            client.close()
