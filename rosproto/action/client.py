"""ActionClient: sends goals to an action server and follows them.

The states of a goal are in `rosproto.protocol.goal_client`; this file joins them to topics. Messages arrive
in the node's threads and change the machines under one lock, at once; callbacks are called by the client's
own thread, without the lock, in the order of the changes (see `Dispatcher`). A waiter is woken after the
callback for DONE.

Source: wiki.ros.org/actionlib/DetailedDescription, actionlib/action_client.py.
"""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from rosproto.action.arrivals import MOST_SERVERS, Arrivals
from rosproto.action.dispatcher import Dispatcher
from rosproto.action.goal_handle import GoalHandle
from rosproto.action.types import action_type, part_from
from rosproto.errors import ConnectionLost, LocalProtocolError, RosTimeout
from rosproto.logs import PeerLog, get_logger
from rosproto.numbers import as_float
from rosproto.protocol.goal_client import CommState
from rosproto.time import Time
from rosproto.transport.clock import SYSTEM, Clock
from rosproto.transport.deadline import Deadline

if TYPE_CHECKING:
    from types import TracebackType

    from rosproto.codec import Message
    from rosproto.node import Node

__all__ = ["ActionClient"]

_log = get_logger("rosproto.action")
_counter = itertools.count(1)  # in all clients of the process: two with one node name must not make one id

STATUS_TIMEOUT = 5.0
ACK_TIMEOUT = 5.0
RESULT_TIMEOUT = 10.0  # seconds between the status that says a goal has ended, and its result
MOST_GOALS = 1000
_POLL = 0.01  # as actionlib; connections are not announced to us
_QUEUE = 1000  # messages; a server's results go to all of its clients, and none may be lost in a burst


class ActionClient:
    """A client of one action server.

    Args:
        node: The node to do it with.
        name: The action: "/move_base".
        action_type: A `FooAction` class, "package/FooAction" or "package/Foo".
        status_timeout: A server counts as gone when no status has come from it for this many seconds (it is
            sent 5 times a second, also when nothing happens); None never.
        ack_timeout: A goal is LOST when a server that is still heard from has not mentioned it for this many
            seconds: it was sent into a connection that the server had given up. Should it arrive later, it
            is cancelled. None never (as actionlib).

    Raises:
        DefinitionError: No such action type.
        LocalProtocolError, MasterError, ConnectionLost, RosTimeout: As `Node.publisher` and
            `Node.subscriber`.

    Attributes:
        name: Resolved name of the action.
        type: Its classes: `client.type.goal` and so on.
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
        self._status_timeout = as_float(status_timeout)
        self._ack_timeout = as_float(ack_timeout)
        self._arrivals = Arrivals()
        self.type = _resolve(action_type, getattr(node, "revisions", None))
        self.name = node.resolve_name(name)
        self._changed = threading.Condition(threading.RLock())
        self._handles: dict[str, GoalHandle] = {}
        self._heard: dict[str, float] = {}
        self._said = PeerLog("rosproto.action")
        self._dispatcher = Dispatcher(self.name)
        self._closed = False
        self._parts: list[Any] = []
        try:
            self._open()
        except BaseException:
            self.close()
            raise

    def _open(self) -> None:
        node, type_ = self._node, self.type

        def subscribe(part: str, kind: type[Message], callback: Callable[[Any], None]) -> Any:
            subscriber = node.subscriber(f"{self.name}/{part}", kind, callback, queue_size=_QUEUE)
            self._parts.append(subscriber)
            return subscriber

        def publish(part: str, kind: type[Message], **options: Any) -> Any:
            publisher = node.publisher(f"{self.name}/{part}", kind, queue_size=_QUEUE, **options)
            self._parts.append(publisher)
            return publisher

        # What brings answers first: a server may answer as soon as it sees our publishers.
        self._feedback = subscribe("feedback", type_.action_feedback, self._on_feedback)
        self._result = subscribe("result", type_.action_result, self._on_result)
        self._status = subscribe("status", type_.status_array, self._on_status)
        # A goal of a killed program would be followed by nobody when it arrives late; a cancel harms nobody.
        self._goal = publish("goal", type_.action_goal, linger=False)
        self._cancel_out = publish("cancel", type_.goal_id)
        node.add_closer(self.close)

    def __enter__(self) -> ActionClient:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<ActionClient {self.name} {self.type.name}, {len(self._handles)} goals>"

    @property
    def servers(self) -> list[str]:
        """Caller ids of the servers heard and fully connected now; there should not be more than one."""
        return [server for server in self._audible() if not self._missing(server)]

    @property
    def revisions(self) -> dict[str, type[Message]]:
        """What each present server takes goals as, by caller id: `type.action_goal`, or a revision of it."""
        return self._goal.revisions  # type: ignore[no-any-return]

    def wait_for_server(self, timeout: float | None = 5.0) -> None:
        """Wait until a server runs and every connection to it stands, so that no goal or answer is lost.

        Args:
            timeout: Seconds; None waits for ever.

        Raises:
            RosTimeout: There is none; the text says which part is missing.
            ConnectionLost: The client or its node was closed.
        """
        timeout = as_float(timeout)
        deadline = Deadline(timeout, self._clock)
        while True:
            self._check_open()
            servers = self._audible()
            if any(not self._missing(server) for server in servers):
                return
            left = deadline.remaining()
            if left is not None and left <= 0:
                raise RosTimeout(
                    f"{self.name}: no action server is ready after {timeout:g} s: {self._complaint(servers)}",
                    what=f"action server {self.name}",
                    seconds=timeout,
                )
            with self._changed:
                self._clock.wait(self._changed, _POLL if left is None else min(left, _POLL))

    def send_goal(
        self,
        goal: Message | Mapping[str, Any],
        *,
        feedback: Callable[[GoalHandle, Any], object] | None = None,
        transition: Callable[[GoalHandle], object] | None = None,
    ) -> GoalHandle:
        """Send a goal and follow it.

        Args:
            goal: The goal message, or a dict of its fields.
            feedback: Called with the handle and each feedback message.
            transition: Called with the handle for each communication state the goal passes. Both are called
                in the client's own thread, one at a time and in order; what they raise is logged. They may
                be called before `send_goal` returns.

        Raises:
            ConnectionLost: No server is connected: call `wait_for_server` first.
            CodecError: It is no goal of this action, or a value does not fit its field.
        """
        self._check_open()
        goal = part_from(goal, self.type.goal, f"a goal of {self.name}")
        if self._goal.connections == 0:
            raise ConnectionLost(
                f"{self.name}: no action server is connected to {self._goal.topic}, the goal would be lost; "
                "call wait_for_server first",
                peer=self._goal.topic,
            )
        stamp = self._node.clock.now()
        goal_id = f"{self._node.name}-{next(_counter)}-{stamp.secs}.{stamp.nsecs:09d}"
        carriers = frozenset(self._goal.subscribers)
        handle = GoalHandle(self, goal_id, goal, stamp, feedback, transition, carriers)
        # Before it is published: the answer may be faster than the return from publish (actionlib #66).
        self._register(handle)
        message: Any = self.type.action_goal(goal_id=self.type.goal_id(stamp=stamp, id=goal_id), goal=goal)
        message.header.stamp = stamp
        try:
            self._goal.publish(message)
        except BaseException:
            with self._changed:
                self._handles.pop(goal_id, None)
            raise
        return handle

    def cancel_all(self) -> None:
        """Ask the server to cancel every goal it has, also those of other clients.

        Raises:
            ConnectionLost: No server is connected to take the request.
        """
        self._send_cancel("", Time())

    def cancel_before(self, time: Time) -> None:
        """Ask the server to cancel every goal sent at or before a time, by the sender's clock.

        Raises:
            ConnectionLost: No server is connected to take the request.
        """
        self._send_cancel("", time)

    def close(self) -> None:
        """Stop following goals; they go on at the server. Waiters get ConnectionLost. May be called twice."""
        with self._changed:
            if self._closed:
                return
            self._closed = True
            self._changed.notify_all()
        for part in reversed(self._parts):
            part.close()
        self._dispatcher.close()
        self._node.remove_closer(self.close)

    # -- what arrives ------------------------------------------------------------------------

    def _on_status(self, message: Any) -> None:
        server = _caller(message)
        mentioned = {status.goal_id.id: status for status in message.status_list}
        with self._changed:
            now = self._hear(server)
            self._arrivals.heard(server, now)
            too_late = self._arrivals.too_late(mentioned, now)
            for handle in list(self._handles.values()):
                status = mentioned.get(handle.goal_id)
                if status is not None:
                    path = handle._machine.status_received(status.status, status.text, server)
                else:
                    path = handle._machine.unmentioned(server) or self._not_arrived(handle, server, now)
                self._report(handle, path + self._missed_result(handle))
            self._changed.notify_all()
        for goal_id in too_late:
            self._cancel_late(goal_id, server)

    def _hear(self, server: str) -> float:
        """Note that status came, and from whom; anybody may publish it, under any number of names."""
        heard = self._heard
        if server not in heard and heard:
            text = "= %s: status also from %s, before from %s"
            self._said.info(self.name, text, self.name, server, list(heard)[-3:])
        now = heard[server] = self._clock.monotonic()
        if len(heard) > MOST_SERVERS:
            needed = {server, *(handle.server for handle in self._handles.values())}
            others = [(at, other) for other, at in heard.items() if other not in needed]
            del heard[min(others or [(0.0, next(iter(heard)))])[1]]
        return now

    def _not_arrived(self, handle: GoalHandle, server: str, now: float) -> tuple[CommState, ...]:
        """End a goal that a server which takes goals and is heard does not know (see `arrivals`)."""
        timeout = self._ack_timeout
        if timeout is None or handle.acknowledged or now - handle._sent_at < timeout:
            return ()
        speaks = server in handle._carriers or handle._carriers.isdisjoint(self._goal.subscribers)
        if not speaks or not self._arrivals.is_steady(server, now):
            return ()
        self._arrivals.give_up(handle.goal_id, now)
        return handle._machine.lose(
            f"{server} has not mentioned it in {now - handle._sent_at:.1f} s, though it sends its status;"
            " most likely it went into a connection that had ended; should it arrive late, it is cancelled"
        )

    def _give_up(self, handle: GoalHandle) -> bool:
        with self._changed:
            if handle.acknowledged:
                return False
            self._arrivals.give_up(handle.goal_id, self._clock.monotonic())
            self._report(handle, handle._machine.lose("it was given up before any server had mentioned it"))
            self._changed.notify_all()
        return True

    def _cancel_late(self, goal_id: str, server: str) -> None:
        text = "! %s: %s has got goal %s after it was given up; cancelling it"
        self._said.warning(self.name, text, self.name, server, goal_id)
        try:
            self._send_cancel(goal_id, Time())
        except (ConnectionLost, LocalProtocolError) as error:
            _log.warning("! %s: not cancelled, tried again with the next status: %s", self.name, error)

    def _missed_result(self, handle: GoalHandle) -> tuple[CommState, ...]:
        """End a goal whose result was sent into a connection that died: it is sent once, and never again."""
        if handle.state is not CommState.WAITING_FOR_RESULT:
            return ()
        now = self._clock.monotonic()
        if handle._ended_at is None:
            handle._ended_at = now
        if now - handle._ended_at < RESULT_TIMEOUT:
            return ()
        ended = handle.status.name
        return handle._machine.lose(
            f"the server says it ended ({ended}), but its result did not come within {RESULT_TIMEOUT:g} s;"
            " it was lost with a connection"
        )

    def _on_result(self, message: Any) -> None:
        status = message.status
        with self._changed:
            handle = self._handles.get(status.goal_id.id)
            if handle is None:
                return  # another client's, or one that is done
            path = handle._machine.result_received(
                message.result, status.status, status.text, _caller(message)
            )
            self._report(handle, path)
            self._changed.notify_all()

    def _on_feedback(self, message: Any) -> None:
        with self._changed:
            handle = self._handles.get(message.status.goal_id.id)
            if handle is None or handle.done or not handle._machine.is_from(_caller(message)):
                return
            callback = handle._on_feedback
            dropped = callback is None and len(handle._kept) == handle._kept.maxlen
            handle._kept.append(message.feedback)
            if callback is not None:
                dropped = not self._dispatcher.call(
                    lambda: callback(handle, message.feedback), droppable=True
                )
            handle.feedback_dropped += dropped
            self._changed.notify_all()

    def _report(self, handle: GoalHandle, path: tuple[CommState, ...]) -> None:
        """Have the callbacks called for the states passed; the end wakes waiters after the last of them."""
        for state in path:
            _log.debug("= %s: %s %s", self.name, handle.goal_id, state.name)
            if handle._on_transition is not None:
                self._dispatcher.call(lambda state=state: self._call_transition(handle, state))  # type: ignore[misc]
        if handle.done:
            self._handles.pop(handle.goal_id, None)
            if handle._on_transition is None:
                handle._finished = True

    def _call_transition(self, handle: GoalHandle, state: CommState) -> None:
        handle._seen = state
        assert handle._on_transition is not None
        try:
            handle._on_transition(handle)
        finally:
            if state is CommState.DONE:
                with self._changed:
                    handle._finished = True
                    self._changed.notify_all()

    # -- what is sent ------------------------------------------------------------------------

    def _register(self, handle: GoalHandle) -> None:
        with self._changed:
            if len(self._handles) >= MOST_GOALS:
                oldest = self._handles[next(iter(self._handles))]
                self._report(oldest, oldest._machine.lose(f"more than {MOST_GOALS} goals are followed"))
            self._handles[handle.goal_id] = handle

    def _cancel(self, handle: GoalHandle) -> bool:
        with self._changed:
            if not handle._machine.cancel_helps:
                return False
        self._send_cancel(handle.goal_id, Time())
        with self._changed:
            self._report(handle, handle._machine.cancel_sent())
            self._changed.notify_all()
        return True

    def _send_cancel(self, goal_id: str, stamp: Time) -> None:
        self._check_open()
        if self._cancel_out.connections == 0:
            raise ConnectionLost(
                f"{self.name}: no action server is connected to {self._cancel_out.topic}, the cancel request "
                "would be lost; the goal may still be running",
                peer=self._cancel_out.topic,
            )
        self._cancel_out.publish(self.type.goal_id(stamp=stamp, id=goal_id))

    # -- whether anybody is there ------------------------------------------------------------

    def _audible(self) -> list[str]:
        """Servers whose status came lately, the latest last."""
        with self._changed:
            now = self._clock.monotonic()
            limit = self._status_timeout
            heard = [(at, server) for server, at in self._heard.items() if limit is None or now - at <= limit]
        return [server for _, server in sorted(heard)]

    def _missing(self, server: str) -> list[str]:
        """Topics not connected with this server yet (status aside: it was heard)."""
        ours = (self._goal, self._cancel_out)
        theirs = (self._result, self._feedback)
        return [p.topic for p in ours if server not in p.subscribers] + [
            s.topic for s in theirs if server not in s.publishers
        ]

    def _complaint(self, servers: list[str]) -> str:
        if servers:
            parts = [
                f"{s} sends status, but is not connected to {', '.join(self._missing(s))}" for s in servers
            ]
            return "; ".join(parts)
        publishers = self._status.publishers
        if publishers:
            return f"{', '.join(publishers)} publishes {self._status.topic}, but no status message came"
        if self._status.stats():
            return f"{self._status.topic} is published, and cannot be reached: {self._status.why_silent()}"
        return f"nobody publishes {self._status.topic}; is the server running, and is the name right?"

    def _why_cut_off(self, handle: GoalHandle) -> ConnectionLost | None:
        if self._closed or self._node.closed:
            what = "client" if self._closed else "node"
            return ConnectionLost(
                f"{self.name}: the {what} was closed while goal {handle.goal_id} was under way"
            )
        if self._status_timeout is None:
            return None
        heard = self._heard
        server = handle.server
        last = heard.get(server, 0.0) if server else max(heard.values(), default=0.0)
        silence = self._clock.monotonic() - max(last, handle._sent_at)
        if silence <= self._status_timeout:
            return None
        return ConnectionLost(
            f"{self.name}: no status from {server or 'any server'} for {silence:.1f} s while goal "
            f"{handle.goal_id} is {handle.state.name}; the server or the link is down, "
            "the goal may still be running",
            peer=server,
        )

    def _check_open(self) -> None:
        if self._closed:
            raise LocalProtocolError(f"{self.name}: this action client is closed")


def _caller(message: Any) -> str:
    header: dict[str, str] = message._connection_header or {}
    return header.get("callerid", "")


_resolve = action_type
