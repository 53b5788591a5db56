"""GoalTracker: the goals of one client that are under way, and the servers it hears.

A message that arrives changes the goals at once, under one lock, in the node's threads. Callbacks run in the
client's `CallbackThread`, without the lock, in the order of the changes. A waiter is woken after the callback
for DONE.

No topics here: `ActionClient` passes in what arrived, and sends.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Collection

from rosproto.action.sent_goal import GivenUpGoals, SentGoal
from rosproto.codec import DynamicMessage
from rosproto.errors import ConnectionLost, LocalProtocolError
from rosproto.logs import PeerLog, get_logger
from rosproto.protocol.goal_client import CommState
from rosproto.transport.deadline import Clock, Deadline

_log = get_logger("rosproto.action")

MAX_WAITING = 100  # callbacks
RESULT_TIMEOUT = 10.0  # seconds between the status that says a goal has ended, and its result
MAX_GOALS = 1000
STEADY_SECONDS = 2.0  # that a server must be heard without a gap until its silence about a goal counts
GAP_SECONDS = 1.0  # seconds without a status array that make a gap; five are sent each second
MAX_SERVERS = 64  # node names that send status for one action; peers choose their names
_LOOK_AGAIN = 0.25  # seconds between looks at how long the server has been silent


class CallbackThread:
    """Calls functions in order, in a separate thread that starts with `start` or the first call.

    Status, result and feedback arrive in three threads. Callbacks run in this one, in the order of the goal's
    states, one at a time, and without a lock held, so they may call anything.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._ready = threading.Condition()
        self._queue: deque[Callable[[], object]] = deque()
        self._thread: threading.Thread | None = None
        self._closed = False

    @property
    def is_current(self) -> bool:
        """True when called from a callback."""
        return threading.current_thread() is self._thread

    def start(self) -> None:
        """Start the thread, if it has not been started.

        Raises:
            RuntimeError: The system starts no more threads.
        """
        with self._ready:
            if self._thread is None and not self._closed:
                thread = threading.Thread(
                    target=self._run, name=f"rosproto:action callbacks {self._name}", daemon=True
                )
                thread.start()
                self._thread = thread

    def call(self, function: Callable[[], object], *, droppable: bool = False) -> bool:
        """Queue a call of `function`.

        Args:
            function: Called without arguments.
            droppable: Drop the call when `MAX_WAITING` are queued.

        Returns:
            False if it will not be called: dropped, or after `close`.
        """
        with self._ready:
            if self._closed or (droppable and len(self._queue) >= MAX_WAITING):
                return False
            self._queue.append(function)
            self.start()
            self._ready.notify()
        return True

    def close(self, timeout: float = 1.0) -> None:
        """Stop after the current call; wait for that call unless called from it."""
        with self._ready:
            self._closed = True
            self._queue.clear()
            self._ready.notify()
        if self._thread is not None and not self.is_current:
            self._thread.join(timeout)

    def _run(self) -> None:
        while True:
            with self._ready:
                while not self._queue and not self._closed:
                    self._ready.wait()
                if self._closed:
                    return
                function = self._queue.popleft()
            try:
                function()
            except BaseException:  # sys.exit() would end this thread and prevent later callbacks
                _log.exception("! %s: a callback raised", self._name)


class GoalTracker:
    """Follows goals from sending to their end.

    Args:
        name: The action, for messages.
        clock: For times and waiting.
        status_timeout, ack_timeout: As for `ActionClient`.
        send_cancel: Asks the server to cancel the goal of an id.
        receivers: Caller ids of the nodes connected to the goal topic now.
        node_closed: Says whether the node is closed.

    Attributes:
        followed: The goals under way by id, the oldest first.
        heard: Since when each server is heard without a gap, and when it was heard last, by caller id.
        given_up: Goals that were given up before they arrived.
        closed: Set by `close`.
    """

    def __init__(
        self,
        name: str,
        clock: Clock,
        *,
        status_timeout: float | None,
        ack_timeout: float | None,
        send_cancel: Callable[[str], object],
        receivers: Callable[[], Collection[str]],
        node_closed: Callable[[], bool],
    ) -> None:
        self.name = name
        self.followed: dict[str, SentGoal] = {}
        self.heard: dict[str, tuple[float, float]] = {}
        self.given_up = GivenUpGoals()
        self.closed = False
        self._clock = clock
        self._status_timeout = status_timeout
        self._ack_timeout = ack_timeout
        self._send_cancel = send_cancel
        self._receivers = receivers
        self._node_closed = node_closed
        self._changed = threading.Condition(threading.RLock())
        self._callbacks = CallbackThread(name)
        self._said = PeerLog("rosproto.action")

    @property
    def in_callback(self) -> bool:
        """True when called from a callback."""
        return self._callbacks.is_current

    def state(self, goal: SentGoal) -> CommState:
        """Where a goal is; in a transition callback the state it was called for."""
        if goal.on_transition is not None and self.in_callback:
            return goal.reported
        return goal.machine.state

    @property
    def audible(self) -> list[str]:
        """Servers whose status arrived recently, the latest last."""
        with self._changed:
            now = self._clock.monotonic()
            limit = self._status_timeout
            heard = [
                (at, server) for server, (_, at) in self.heard.items() if limit is None or now - at <= limit
            ]
        return [server for _, server in sorted(heard)]

    def close(self) -> bool:
        """Stop following and wake all waiters; False if already closed."""
        with self._changed:
            if self.closed:
                return False
            self.closed = True
            self._changed.notify_all()
        return True

    def stop_callbacks(self) -> None:
        """Call no more callbacks; waits for the one under way."""
        self._callbacks.close()

    # -- goals -------------------------------------------------------------------------------

    def follow(self, goal: SentGoal) -> None:
        """Follow a goal, before it is sent; beyond `MAX_GOALS` the oldest becomes LOST.

        Raises:
            RuntimeError: The system starts no thread for the goal's callbacks.
        """
        if goal.on_transition is not None or goal.on_feedback is not None:
            self._callbacks.start()  # the goal's first answer may come when no thread can be started any more
        with self._changed:
            if len(self.followed) >= MAX_GOALS:
                oldest = self.followed[next(iter(self.followed))]
                self._report(oldest, oldest.machine.lose(f"more than {MAX_GOALS} goals are followed"))
            self.followed[goal.goal_id] = goal

    def forget(self, goal: SentGoal) -> None:
        """Do not follow a goal that could not be sent."""
        with self._changed:
            self.followed.pop(goal.goal_id, None)

    def cancel(self, goal: SentGoal) -> bool:
        """Ask the server to cancel a goal; False when that cannot help."""
        with self._changed:
            if not goal.machine.cancel_helps:
                return False
        self._send_cancel(goal.goal_id)
        with self._changed:
            self._report(goal, goal.machine.cancel_sent())
            self._changed.notify_all()
        return True

    def give_up(self, goal: SentGoal) -> bool:
        """Consider a goal that no server has acknowledged as lost; False when one has."""
        with self._changed:
            if goal.acknowledged:
                return False
            self.given_up.give_up(goal.goal_id, self._clock.monotonic())
            self._report(goal, goal.machine.lose("it was given up before any server had mentioned it"))
            self._changed.notify_all()
        return True

    def take_feedback(self, goal: SentGoal) -> DynamicMessage | None:
        """The oldest feedback message kept, or None."""
        with self._changed:
            return goal.feedback.popleft() if goal.feedback else None

    # -- waiting -----------------------------------------------------------------------------

    def deadline(self, timeout: float | None) -> Deadline:
        """A deadline by the client's clock."""
        return Deadline(timeout, self._clock)

    def pause(self, seconds: float) -> None:
        """Wait for the next change, at most `seconds`."""
        with self._changed:
            self._clock.wait(self._changed, seconds)

    def wait_for(self, goal: SentGoal, condition: Callable[[], bool], deadline: Deadline) -> bool:
        """Wait until `condition` holds.

        Returns:
            False when time is up.

        Raises:
            ConnectionLost: It cannot become true: see `connection_error`.
        """
        with self._changed:
            while not condition():
                error = self.connection_error(goal)
                if error is not None:
                    raise error
                left = deadline.remaining()
                if left is not None and left <= 0:
                    return False
                self._clock.wait(self._changed, _LOOK_AGAIN if left is None else min(left, _LOOK_AGAIN))
        return True

    def connection_error(self, goal: SentGoal) -> ConnectionLost | None:
        """Why a goal cannot progress at present, or None."""
        if goal.done:
            return None
        if self.closed or self._node_closed():
            what = "client" if self.closed else "node"
            return ConnectionLost(
                f"{self.name}: the {what} was closed while goal {goal.goal_id} was under way"
            )
        if self._status_timeout is None:
            return None
        server = goal.machine.server
        of_interest = [server] if server else list(self.heard)
        last = max((self.heard[one][1] for one in of_interest if one in self.heard), default=0.0)
        silence = self._clock.monotonic() - max(last, goal.sent_at)
        if silence <= self._status_timeout:
            return None
        return ConnectionLost(
            f"{self.name}: no status from {server or 'any server'} for {silence:.1f} s while goal "
            f"{goal.goal_id} is {self.state(goal).name}; the server or the link is down, "
            "the goal may still be running",
            peer=server,
        )

    # -- what arrives ------------------------------------------------------------------------

    def status_received(self, message: DynamicMessage) -> None:
        """An actionlib_msgs/GoalStatusArray arrived."""
        server = _caller(message)
        mentioned = {status.goal_id.id: status for status in message.status_list}
        with self._changed:
            now = self._hear(server)
            too_late = self.given_up.too_late(mentioned, now)
            for goal in list(self.followed.values()):
                status = mentioned.get(goal.goal_id)
                if status is not None:
                    path = goal.machine.status_received(status.status, status.text, server)
                else:
                    path = goal.machine.unmentioned(server) or self._not_arrived(goal, server, now)
                self._report(goal, path + self._missed_result(goal))
            self._changed.notify_all()
        for goal_id in too_late:
            self._cancel_late(goal_id, server)

    def result_received(self, message: DynamicMessage) -> None:
        """A result arrived; it may be of another client's goal, or of one that is done."""
        status = message.status
        with self._changed:
            goal = self.followed.get(status.goal_id.id)
            if goal is None:
                return
            path = goal.machine.result_received(message.result, status.status, status.text, _caller(message))
            self._report(goal, path)
            self._changed.notify_all()

    def feedback_received(self, message: DynamicMessage) -> None:
        """Feedback arrived."""
        with self._changed:
            goal = self.followed.get(message.status.goal_id.id)
            if goal is None or goal.done or not goal.machine.is_from(_caller(message)):
                return
            callback = goal.on_feedback
            taken = goal.keep_feedback(message.feedback)
            if callback is not None:
                taken = self._callbacks.call(lambda: callback(message.feedback), droppable=True)
            goal.feedback_dropped += not taken
            self._changed.notify_all()

    def _hear(self, server: str) -> float:
        """Record a status and its sender; the number of senders is limited, as peers choose their names."""
        heard = self.heard
        if server not in heard and heard:
            text = "= %s: status also from %s, before from %s"
            self._said.info(self.name, text, self.name, server, list(heard)[-3:])
        now = self._clock.monotonic()
        since, last = heard.get(server, (now, now))
        heard[server] = (now if now - last > GAP_SECONDS else since, now)
        if len(heard) > MAX_SERVERS:
            needed = {server, *(goal.machine.server for goal in self.followed.values())}
            others = [(at, other) for other, (_, at) in heard.items() if other not in needed]
            del heard[min(others or [(0.0, next(iter(heard)))])[1]]
        return now

    def _not_arrived(self, goal: SentGoal, server: str, now: float) -> tuple[CommState, ...]:
        """End a goal that is unknown to a server which takes goals and is heard (see `GivenUpGoals`)."""
        timeout = self._ack_timeout
        if timeout is None or goal.acknowledged or now - goal.sent_at < timeout:
            return ()
        takes_goals = server in goal.receivers or goal.receivers.isdisjoint(self._receivers())
        since, _ = self.heard.get(server, (now, now))
        if not takes_goals or now - since < STEADY_SECONDS:
            return ()
        self.given_up.give_up(goal.goal_id, now)
        return goal.machine.lose(
            f"{server} has not mentioned it in {now - goal.sent_at:.1f} s, though it sends its status;"
            " most likely it went into a connection that had ended; should it arrive late, it is cancelled"
        )

    def _missed_result(self, goal: SentGoal) -> tuple[CommState, ...]:
        """End a goal whose result was lost with a connection: a result is sent once and never again."""
        if goal.waited_for_result(self._clock.monotonic()) < RESULT_TIMEOUT:
            return ()
        ended = goal.machine.status.name
        return goal.machine.lose(
            f"the server says it ended ({ended}), but its result did not come within {RESULT_TIMEOUT:g} s;"
            " it was lost with a connection"
        )

    def _cancel_late(self, goal_id: str, server: str) -> None:
        text = "! %s: %s has got goal %s after it was given up; cancelling it"
        self._said.warning(self.name, text, self.name, server, goal_id)
        try:
            self._send_cancel(goal_id)
        except (ConnectionLost, LocalProtocolError) as error:
            _log.warning("! %s: cancel not sent, trying again with the next status: %s", self.name, error)

    def _report(self, goal: SentGoal, path: tuple[CommState, ...]) -> None:
        """Have the callbacks called for the states passed; the end wakes waiters after the last of them."""
        for state in path:
            _log.debug("= %s: %s %s", self.name, goal.goal_id, state.name)
            if goal.on_transition is not None:
                self._callbacks.call(lambda state=state: self._call_transition(goal, state))  # type: ignore[misc]
        if goal.done:
            self.followed.pop(goal.goal_id, None)
            if goal.on_transition is None:
                goal.finished = True

    def _call_transition(self, goal: SentGoal, state: CommState) -> None:
        goal.reported = state
        assert goal.on_transition is not None
        try:
            goal.on_transition()
        finally:
            if state is CommState.DONE:
                with self._changed:
                    goal.finished = True
                    self._changed.notify_all()


def _caller(message: DynamicMessage) -> str:
    return (message._connection_header or {}).get("callerid", "")
