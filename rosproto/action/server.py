"""ActionServer: receives goals, has a handler work on them, and reports their status.

The states of a goal and the list of goals are in `rosproto.protocol.goal_server`. Every change of the list
is published at once, and the whole list 5 times a second, even when it is empty, so that clients can tell an
idle server from a dead one. One lock covers the list and publishing: status messages are sent in the order
of the changes.

Source: wiki.ros.org/actionlib/DetailedDescription, actionlib/action_server.py and simple_action_server.py.
"""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from rosproto.action.types import Part, part_from
from rosproto.action.types import action_type as classes_of
from rosproto.codec import DynamicMessage, Message
from rosproto.deprecation import former_parameters
from rosproto.errors import LocalProtocolError, RosError
from rosproto.logs import get_logger
from rosproto.node import Node, Publisher, Subscriber
from rosproto.protocol.goal_server import GoalList, GoalRecord
from rosproto.protocol.goal_status import GoalStatus
from rosproto.time import Time
from rosproto.transport.deadline import SYSTEM, Clock, Deadline
from rosproto.transport.shared_threads import shared_threads

# -- a goal -------------------------------------------------------------------------------------------------


class ServerGoal:
    """What the handler of an `ActionServer` is called with. All methods may be called from any thread.

    Attributes:
        id: Goal id on the wire.
        stamp: When the client says it sent the goal; when it arrived, if the client gave no stamp.
        goal: The goal message.
        client: Caller id of the node that sent it.
    """

    def __init__(self, server: ActionServer, record: GoalRecord, goal: Any, stamp: Time, client: str) -> None:
        self._server = server
        self._record = record
        self._cancel = threading.Event()
        self.id = record.goal_id
        self.stamp = stamp
        self.goal = goal
        self.client = client

    def __repr__(self) -> str:
        return f"<ServerGoal {self.id} {self.status.name}>"

    @property
    def status(self) -> GoalStatus:
        """Status of the goal."""
        return self._record.status

    @property
    def _ended(self) -> bool:
        return self._record.status.is_terminal

    @property
    def cancel_requested(self) -> bool:
        """True when work should stop: a client cancelled it, a newer goal replaces it, the server closes."""
        return self._cancel.is_set()

    def wait_for_cancel(self, timeout: float) -> bool:
        """Pause for `timeout` seconds, or until `cancel_requested`; returns that."""
        return self._cancel.wait(timeout)

    def publish_feedback(self, feedback: Part) -> None:
        """Publish the progress: a feedback message, or a dict of its fields.

        Raises:
            LocalProtocolError: The goal has ended.
            CodecError: It is not this action's feedback.
        """
        self._server._publish_feedback(self, feedback)

    def succeed(self, result: Part | None = None, text: str = "") -> None:
        """End the goal: done.

        Args:
            result: Result message, or a dict of its fields; None for one with default values.
            text: Sent with it, for people.

        Raises:
            LocalProtocolError: It has ended already.
        """
        self._server._end(self, "succeed", result, text)

    def abort(self, result: Part | None = None, text: str = "") -> None:
        """End the goal: it cannot be done. Arguments and errors as for `succeed`."""
        self._server._end(self, "abort", result, text)

    def preempted(self, result: Part | None = None, text: str = "") -> None:
        """End the goal: it was cancelled. Arguments and errors as for `succeed`."""
        self._server._end(self, "cancel", result, text)


# -- the server ---------------------------------------------------------------------------------------------


_log = get_logger("rosproto.action")
_counter = itertools.count(1)

REPLACED = "canceled: another goal was received"
STATUS_SECONDS = 0.2
MAX_GOALS = 100
_QUEUE = 1000  # messages: after a dropped goal or result, a client would wait
_CLOSE_SECONDS = 2.0

Handler = Callable[[ServerGoal], object]


class ActionServer:
    """Provides an action.

    The handler is called with a `ServerGoal` in a thread of its own, and the goal is ACTIVE then. It ends
    the goal with `succeed`, `abort` or `preempted`; or returns a result (a message, or a dict of its
    fields), which means success. It should look at `cancel_requested` (or pause with `wait_for_cancel`).
    If it raises, the goal is aborted with the exception's text; if it returns without ending the goal,
    the goal is aborted, or preempted when a cancel was requested.

    One goal at a time, as actionlib's simple server: a newer goal asks the one under way to stop and starts
    when its handler has returned; of several that wait only the newest is kept, the others are recalled. A
    goal whose stamp is before that of the last one is recalled, also when that one has ended; a goal without
    a stamp gets the server's time. A goal that is cancelled while it waits ends, preempted, when its turn
    comes; its handler is not called. With `concurrent=True` every goal starts at once.

    Args:
        node: The node to do it with.
        name: The action: "/move_base".
        action_type: A `FooAction` class, "package/FooAction" or "package/Foo".
        handler: As above.
        concurrent: Work on many goals at once.
        check: Called with each new goal message, in the receiving thread, so it must be quick. Returns None
            to accept the goal, or why it is rejected.
        max_goals: More goals than this under way or waiting are rejected.

    Raises:
        DefinitionError: No such action type.
        LocalProtocolError: The node is closed, or has one of the topics with another type.
        MasterError: The master refused a registration.
        ConnectionLost, RosTimeout: The master cannot be reached, or did not answer in time.

    Attributes:
        name: Resolved name of the action.
        type: Its classes: `server.type.result` and so on.
    """

    @former_parameters(most_goals="max_goals")
    def __init__(
        self,
        node: Node,
        name: str,
        action_type: type[Message] | str,
        handler: Handler,
        *,
        concurrent: bool = False,
        check: Callable[[Any], str | None] | None = None,
        max_goals: int = MAX_GOALS,
        clock: Clock = SYSTEM,
    ) -> None:
        self._node = node
        self._handler = handler
        self._check = check
        self._concurrent = concurrent
        self._max_goals = max_goals
        self._clock = clock
        self.type = classes_of(action_type, getattr(node, "definitions", None))
        self.name = node.resolve_name(name)
        self._lock = threading.RLock()
        self._goals = GoalList()
        self._live: dict[str, ServerGoal] = {}
        self._newest = Time()  # simple policy: stamp of the last goal, which may have ended
        self._waiting: ServerGoal | None = None  # simple policy: the goal that starts next
        self._current: ServerGoal | None = None  # simple policy: the goal whose handler runs
        self._workers: set[threading.Thread] = set()
        self._closing = threading.Event()
        self._closed = False
        self._parts: list[Publisher | Subscriber] = []
        self._next_status: Future[None] | None = None
        try:
            self._open()
        except BaseException:
            self.close()
            raise

    def _open(self) -> None:
        node, type_ = self._node, self.type

        def publish(part: str, kind: type[Message], latch: bool = False) -> Publisher:
            publisher = node.publisher(f"{self.name}/{part}", kind, latch=latch, queue_size=_QUEUE)
            self._parts.append(publisher)
            return publisher

        def subscribe(part: str, kind: type[Message], callback: Callable[[DynamicMessage], None]) -> None:
            self._parts.append(node.subscriber(f"{self.name}/{part}", kind, callback, queue_size=_QUEUE))

        # Latched, as in actionlib: a new client sees the server at once.
        self._status_out = publish("status", type_.status_array, latch=True)
        self._result_out = publish("result", type_.action_result)
        self._feedback_out = publish("feedback", type_.action_feedback)
        subscribe("cancel", type_.goal_id, self._on_cancel)
        subscribe("goal", type_.action_goal, self._on_goal)
        node.add_closer(self.close)
        self._publish_status()
        self._plan_status()

    def __enter__(self) -> ActionServer:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<ActionServer {self.name} {self.type.name}, {len(self._live)} goals under way>"

    @property
    def goals(self) -> list[ServerGoal]:
        """Goals that have not ended, the oldest first."""
        with self._lock:
            return list(self._live.values())

    def close(self) -> None:
        """Ask handlers to stop, wait up to 2 s for them, abort the rest, unregister. May be called twice."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
            goals, workers = list(self._live.values()), list(self._workers)
        self._closing.set()
        if self._next_status is not None:
            self._next_status.cancel()
        for goal in goals:
            goal._cancel.set()
        deadline = Deadline(_CLOSE_SECONDS, self._clock)
        for worker in workers:
            if worker is not threading.current_thread():
                worker.join(deadline.remaining())
        for goal in goals:
            self._finish_quietly(goal, "the action server was closed")
        for part in reversed(self._parts):
            part.close()
        self._node.remove_closer(self.close)

    # -- what arrives ------------------------------------------------------------------------

    def _on_goal(self, message: DynamicMessage) -> None:
        header = message._connection_header or {}
        goal_id, sent = message.goal_id.id, message.goal_id.stamp
        # A server that makes the id makes the stamp, too (actionlib's StatusTracker).
        stamp = sent if goal_id and sent else self._node.clock.now()
        goal_id = goal_id or f"{self._node.name}-server-{next(_counter)}-{stamp.to_sec():.3f}"
        with self._lock:
            if self._closed:
                return
            record, new = self._goals.goal_received(
                goal_id, stamp.to_nsec(), self._clock.monotonic(), sent=sent.to_nsec()
            )
            if new:
                goal = ServerGoal(self, record, message.goal, stamp, header.get("callerid", ""))
                self._live[goal_id] = goal
                self._admit(goal)
            elif record.status is GoalStatus.RECALLED:
                self._publish_result(record, None)
            self._publish_status()

    def _on_cancel(self, message: DynamicMessage) -> None:
        with self._lock:
            if self._closed:
                return
            touched = self._goals.cancel_received(
                message.id, message.stamp.to_nsec(), self._clock.monotonic()
            )
            for record in touched:
                goal = self._live.get(record.goal_id)
                if goal is None:
                    continue
                goal._cancel.set()
            self._publish_status()

    def _admit(self, goal: ServerGoal) -> None:
        """Start a new goal, queue it, or reject it."""
        reason = self._reason_to_reject(goal)
        if reason is not None:
            self._apply(goal, "reject", None, reason)
        elif self._concurrent:
            self._start(goal)
        else:
            self._queue(goal)

    def _reason_to_reject(self, goal: ServerGoal) -> str | None:
        if len(self._live) > self._max_goals:
            return f"more than {self._max_goals} goals are under way"
        if self._check is None:
            return None
        try:
            return self._check(goal.goal)
        except Exception as problem:
            _log.exception("! %s: check raised", self.name)
            return f"the goal could not be checked: {problem}"

    def _queue(self, goal: ServerGoal) -> None:
        """The simple policy: the newest goal by stamp wins."""
        if goal.stamp < self._newest:
            self._apply(goal, "cancel", None, REPLACED)
            return
        self._newest = goal.stamp
        if self._waiting is not None:
            self._apply(self._waiting, "cancel", None, REPLACED)
        self._waiting = goal
        if self._current is not None:
            self._current._cancel.set()
        else:
            self._start_waiting()

    def _start_waiting(self) -> None:
        goal, self._waiting = self._waiting, None
        if goal is not None and goal.cancel_requested:
            self._apply(goal, "accept", None, None)
            self._apply(goal, "cancel", None, "canceled before it was started")
            goal = None
        self._current = goal
        if goal is not None:
            self._start(goal)

    # -- work --------------------------------------------------------------------------------

    def _start(self, goal: ServerGoal) -> None:
        self._apply(goal, "accept", None, "")
        worker = threading.Thread(
            target=self._work, args=(goal,), name=f"rosproto:action goal {self.name}", daemon=True
        )
        self._workers.add(worker)
        worker.start()

    def _work(self, goal: ServerGoal) -> None:
        """Call the handler, make sure that the goal ends, start the next one."""
        try:
            result = self._handler(goal)
            if result is not None:
                self._succeed_with(goal, result)
            self._finish_quietly(goal, "the handler returned without ending the goal")
        except BaseException as problem:  # a sys.exit() too: the client waits for an end
            _log.exception("! %s: the handler of goal %s raised", self.name, goal.id)
            self._finish_quietly(goal, f"{type(problem).__name__}: {problem}", aborted=True)
        finally:
            with self._lock:
                self._workers.discard(threading.current_thread())
                if self._current is goal:
                    self._current = None
                    if not self._closed and self._waiting is not None:
                        self._start_waiting()
                        self._publish_status()

    def _succeed_with(self, goal: ServerGoal, result: object) -> None:
        part = part_from(result, self.type.result, f"what the handler of {self.name} returns")
        if not goal._ended:
            goal.succeed(part)

    def _finish_quietly(self, goal: ServerGoal, text: str, *, aborted: bool = False) -> None:
        """End a goal that its handler left open."""
        with self._lock:
            if goal._ended:
                return
            canceled = goal._cancel.is_set() and not aborted and not self._closed
            waiting = goal.status in (GoalStatus.PENDING, GoalStatus.RECALLING)
            try:
                self._end(goal, "cancel" if canceled or waiting else "abort", None, "" if canceled else text)
            except RosError:
                _log.exception("! %s: goal %s could not be ended", self.name, goal.id)

    # -- what is sent ------------------------------------------------------------------------

    def _end(self, goal: ServerGoal, command: str, result: object, text: str) -> None:
        with self._lock:
            self._apply(goal, command, result, text)
            self._publish_status()

    def _apply(self, goal: ServerGoal, command: str, result: object, text: str | None) -> None:
        """Change a goal's state; when it ends, publish the result."""
        if result is not None:
            result = part_from(result, self.type.result, f"a result of {self.name}")
        self._goals.apply(goal._record, command, self._clock.monotonic(), text)
        if goal._ended:
            self._live.pop(goal.id, None)
            self._publish_result(goal._record, result)

    def _publish_result(self, record: GoalRecord, result: object) -> None:
        message = self.type.action_result(status=self._status_of(record))
        message.header.stamp = self._node.clock.now()
        if result is not None:
            message.result = result
        self._publish(self._result_out, message)

    def _publish_feedback(self, goal: ServerGoal, feedback: Part) -> None:
        with self._lock:
            if goal._ended:
                raise LocalProtocolError(
                    f"goal {goal.id} is {goal.status.name}: no feedback can follow the end"
                )
            part = part_from(feedback, self.type.feedback, f"feedback of {self.name}")
            message = self.type.action_feedback(status=self._status_of(goal._record), feedback=part)
            message.header.stamp = self._node.clock.now()
            self._publish(self._feedback_out, message)

    def _publish_status(self) -> None:
        with self._lock:
            self._goals.expire(self._clock.monotonic())
            message = self.type.status_array()
            message.header.stamp = self._node.clock.now()
            message.status_list = [self._status_of(record) for record in self._goals]
            self._publish(self._status_out, message)

    def _publish(self, publisher: Publisher, message: DynamicMessage) -> None:
        try:
            publisher.publish(message)
        except LocalProtocolError:
            if not self._closed and not self._node.closed:
                raise  # a handler may end while the server closes

    def _status_of(self, record: GoalRecord) -> DynamicMessage:
        stamp = Time.from_nsec(record.stamp)
        goal_id = self.type.goal_id(id=record.goal_id, stamp=stamp)
        return self.type.status(goal_id=goal_id, status=int(record.status), text=record.text)

    def _plan_status(self) -> None:
        """Publish the status soon; all servers of the process do so together, which wakes fewer threads."""
        if not self._closing.is_set():
            moment = STATUS_SECONDS - self._clock.monotonic() % STATUS_SECONDS
            self._next_status = shared_threads().add_later(moment, self._tick)

    def _tick(self) -> None:
        if self._closing.is_set():
            return
        try:
            self._publish_status()
        except RosError:
            if self._status_out.closed:
                # `Node.batch` has closed it and said why: the program was interrupted, or the
                # master refused it. A server that nobody can follow takes no goals.
                _log.debug("= %s: closed with its status topic", self.name)
                self.close()
                return
            _log.exception("! %s: status could not be published", self.name)
        self._plan_status()
