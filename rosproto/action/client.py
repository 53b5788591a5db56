"""ActionClient: sends goals to an action server and follows them.

`ActionClient` connects the topics with the goals. `GoalTracker` follows the goals; their states are in
`rosproto.protocol.goal_client`. The program gets a `GoalHandle` for each goal.

Source: wiki.ros.org/actionlib/DetailedDescription, actionlib/action_client.py.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from functools import partial
from typing import Any

from rosproto.action.goal_handle import GoalHandle
from rosproto.action.goal_tracker import GoalTracker
from rosproto.action.sent_goal import SentGoal
from rosproto.action.types import Part, part_from
from rosproto.action.types import action_type as classes_of
from rosproto.codec import DynamicMessage, Message, encode
from rosproto.coercion import as_float
from rosproto.errors import ConnectionLost, LocalProtocolError, RosTimeout
from rosproto.node import Node, Publisher, Subscriber
from rosproto.sentence import advice, both, led, say
from rosproto.time import Time
from rosproto.transport.deadline import SYSTEM, Clock, Deadline

# Shared by all clients of the process: two with the same node name must not generate the same id.
_counter = itertools.count(1)

STATUS_TIMEOUT = 5.0
ACK_TIMEOUT = 5.0
_POLL = 0.01  # seconds, as actionlib; no event reports new connections
_QUEUE = 1000  # messages; a server sends results to all clients, and none of a burst may be lost


class ActionClient:
    """A client of one action server.

    Args:
        node: The node that opens the topics.
        name: Name of the action: "/move_base".
        action_type: A `FooAction` class, "package/FooAction" or "package/Foo".
        status_timeout: Seconds without a status message, sent 5 times a second even when idle, after which a
            server counts as gone; None for no limit.
        ack_timeout: Seconds after which a goal is LOST if the server sends status without it: the server had
            dropped the connection. If the goal arrives later, it is cancelled. None for no limit (as
            actionlib).

    Raises:
        DefinitionError: The action type is unknown.
        LocalProtocolError: The node is closed, or has one of the topics with another type.
        MasterError: The master refused a registration.
        ConnectionLost, RosTimeout: The master cannot be reached, or did not answer in time.

    Attributes:
        name: Resolved name of the action.
        type: Message classes of the action: `client.type.goal` and so on.
    """

    def __init__(
        self,
        node: Node,
        name: str,
        action_type: type[Message] | str,
        *,
        status_timeout: float | None = STATUS_TIMEOUT,
        ack_timeout: float | None = ACK_TIMEOUT,
        clock: Clock = SYSTEM,
    ) -> None:
        self._node = node
        self._clock = clock
        self.type = classes_of(action_type, getattr(node, "definitions", None))
        self.name = node.resolve_name(name)
        self._goals = GoalTracker(
            self.name,
            clock,
            status_timeout=as_float(status_timeout),
            ack_timeout=as_float(ack_timeout),
            send_cancel=lambda goal_id: self._send_cancel(goal_id, Time()),
            receivers=lambda: self._goal.subscribers,
            node_closed=lambda: node.closed,
        )
        self._parts: list[Publisher | Subscriber] = []
        try:
            self._open()
        except BaseException:
            self.close()
            raise

    def _open(self) -> None:
        node, type_ = self._node, self.type

        def subscribe(
            part: str, kind: type[Message], callback: Callable[[DynamicMessage], None]
        ) -> Subscriber:
            subscriber = node.subscriber(f"{self.name}/{part}", kind, callback, queue_size=_QUEUE)
            self._parts.append(subscriber)
            return subscriber

        def publish(part: str, kind: type[Message], linger: bool = True) -> Publisher:
            publisher = node.publisher(f"{self.name}/{part}", kind, queue_size=_QUEUE, linger=linger)
            self._parts.append(publisher)
            return publisher

        # Subscribers first: a server may answer as soon as it sees our publishers.
        self._feedback = subscribe("feedback", type_.action_feedback, self._goals.feedback_received)
        self._result = subscribe("result", type_.action_result, self._goals.result_received)
        self._status = subscribe("status", type_.status_array, self._goals.status_received)
        # No client would follow a goal that arrives after this program has ended; a late cancel is harmless.
        self._goal = publish("goal", type_.action_goal, linger=False)
        self._cancel_out = publish("cancel", type_.goal_id)
        type_.goal()  # generates its constructor before `send_goal` needs it (publishers do the rest)
        node.add_closer(self.close)

    def __enter__(self) -> ActionClient:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<ActionClient {self.name} {self.type.name}, {len(self._goals.followed)} goals>"

    @property
    def servers(self) -> list[str]:
        """Caller ids of the servers that send status and are fully connected; there should be at most one."""
        return [server for server in self._goals.audible if not self._missing(server)]

    @property
    def revisions(self) -> dict[str, type[Message]]:
        """Goal class of each present server by caller id: `type.action_goal`, or a revision of it."""
        return self._goal.revisions

    def wait_for_server(self, timeout: float | None = 5.0) -> None:
        """Wait until a server is running and fully connected, so that no goal or answer is lost.

        Args:
            timeout: Seconds; None waits for ever.

        Raises:
            RosTimeout: No server is ready; the text has the missing parts.
            ConnectionLost: The client or its node was closed.
        """
        timeout = as_float(timeout)
        deadline = Deadline(timeout, self._clock)
        while True:
            self._check_open()
            servers = self._goals.audible
            if any(not self._missing(server) for server in servers):
                return
            left = deadline.remaining()
            if left is not None and left <= 0:
                raise RosTimeout(
                    say(
                        "{name}: no action server is ready after {seconds:g} s: {why}",
                        name=self.name,
                        seconds=timeout,
                        why=self._complaint(servers),
                    ),
                    what=f"action server {self.name}",
                    seconds=timeout,
                )
            self._goals.pause(_POLL if left is None else min(left, _POLL))

    def send_goal(
        self,
        goal: Part,
        *,
        feedback: Callable[[GoalHandle, Any], object] | None = None,
        transition: Callable[[GoalHandle], object] | None = None,
        goal_id: str = "",
    ) -> GoalHandle:
        """Send a goal and follow it.

        Args:
            goal: The goal message, or a dict of its fields.
            feedback: Called with the handle and each feedback message.
            transition: Called with the handle for each communication state of the goal. Both callbacks run in
                the client's own thread, one at a time and in order, possibly before `send_goal` returns.
                Their exceptions are logged.
            goal_id: An id from `new_goal_id`; "" generates one.

        Raises:
            ConnectionLost: No server is connected: call `wait_for_server` first.
            CodecError: `goal` is not a goal of this action, or a value does not fit its field.
            RuntimeError: The system starts no thread for the callbacks. Nothing was sent.
        """
        self._check_open()
        part = part_from(goal, self.type.goal, f"a goal of {self.name}")
        if self._goal.connections == 0:
            topic = self._goal.topic
            lost = say("no action server is connected to {topic}, the goal would be lost", topic=topic)
            raise ConnectionLost(led(self.name, both(lost, "call wait_for_server first")), peer=topic)
        goal_id = goal_id or self.new_goal_id()
        receivers = frozenset(self._goal.subscribers)
        sent = SentGoal(goal_id, part, self._clock.monotonic(), receivers)
        # Encode now: a cancel may be needed when Python can no longer import modules.
        cancel = encode(self.type.goal_id(id=goal_id))
        handle = GoalHandle(sent, self._goals, partial(self._write_cancel, cancel))
        sent.on_feedback = None if feedback is None else partial(feedback, handle)
        sent.on_transition = None if transition is None else partial(transition, handle)
        # Before publishing: the answer may arrive before publish returns (actionlib #66).
        self._goals.follow(sent)
        # The goal id's stamp stays zero: the server sets it, from its own clock. A simple server drops a goal
        # whose stamp is before the last goal's, and these two would come from different computers.
        message = self.type.action_goal(goal_id=self.type.goal_id(id=goal_id), goal=part)
        message.header.stamp = self._node.clock.now()  # for people: no server decides by it
        try:
            self._goal.publish(message)
        except BaseException:
            self._goals.forget(sent)
            raise
        return handle

    def new_goal_id(self) -> str:
        """Generate an id for `send_goal`, to know it before the goal is sent."""
        stamp = self._node.clock.now()
        return f"{self._node.name}-{next(_counter)}-{stamp.secs}.{stamp.nsecs:09d}"

    def cancel_all(self) -> None:
        """Ask the server to cancel all goals, also those of other clients.

        Raises:
            ConnectionLost: No server is connected to take the request.
        """
        self._send_cancel("", Time())

    def cancel_before(self, time: Time) -> None:
        """Ask the server to cancel every goal with a stamp at or before a time.

        The server sets the stamps of our goals, so give a time of its clock (a status message has one). Until
        its clock has passed that time, it also cancels goals that come later with an earlier stamp.

        Raises:
            ConnectionLost: No server is connected to take the request.
        """
        self._send_cancel("", time)

    def close(self) -> None:
        """Stop following goals; the server continues them. Waiting calls raise ConnectionLost. Idempotent."""
        if not self._goals.close():
            return
        for part in reversed(self._parts):
            part.close()
        self._goals.stop_callbacks()
        self._node.remove_closer(self.close)

    # -- outgoing ----------------------------------------------------------------------------

    def _send_cancel(self, goal_id: str, stamp: Time) -> None:
        self._write_cancel(self.type.goal_id(stamp=stamp, id=goal_id))

    def _write_cancel(self, message: Message | bytes) -> None:
        self._check_open()
        if self._cancel_out.connections == 0:
            topic = self._cancel_out.topic
            lost = say("no action server is connected to {topic}, the cancel would be lost", topic=topic)
            raise ConnectionLost(led(self.name, both(lost, "the goal may still be running")), peer=topic)
        self._cancel_out.publish(message)

    # -- servers -----------------------------------------------------------------------------

    def _missing(self, server: str) -> list[str]:
        """Topics not connected with this server yet, except status."""
        ours = (self._goal, self._cancel_out)
        theirs = (self._result, self._feedback)
        return [p.topic for p in ours if server not in p.subscribers] + [
            s.topic for s in theirs if server not in s.publishers
        ]

    def _complaint(self, servers: list[str]) -> str:
        if servers:
            text = "{server} sends status, but is not connected to {topics}"
            return both(*[say(text, server=s, topics=", ".join(self._missing(s))) for s in servers])
        publishers = self._status.publishers
        if publishers:
            text = "{servers} publishes {topic}, but no status message came"
            return say(text, servers=", ".join(publishers), topic=self._status.topic)
        if self._status.stats():
            text = "{topic} is published, but its publisher is not connected: {why}"
            return say(text, topic=self._status.topic, why=say(self._status.why_silent()))
        return advice(
            "nobody publishes {topic}; is the server running, and is the name right?",
            key="not-there",
            topic=self._status.topic,
        )

    def _check_open(self) -> None:
        if self._goals.closed:
            raise LocalProtocolError(led(self.name, "this action client is closed"))
