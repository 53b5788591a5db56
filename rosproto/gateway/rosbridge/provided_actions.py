"""Actions that one client provides: an action server of ROS 1 whose goals are carried to the client and back.

As rosbridge for ROS 2 has it (`advertise_action`): every goal starts at once, and its end is what the client
says by its id. A client that leaves, or gives the action up, aborts what is under way.
"""

from __future__ import annotations

import itertools
import threading
from functools import partial
from typing import TYPE_CHECKING

from rosproto.errors import CodecError, RosError
from rosproto.gateway.rosbridge.actions import ActionStatus, action_type
from rosproto.gateway.rosbridge.effects import (
    ActionFeedback,
    ActionResult,
    AdvertiseAction,
    UnadvertiseAction,
)
from rosproto.gateway.rosbridge.shared import Refused, Shared, insist
from rosproto.gateway.rosbridge.tf_on_demand import is_tf_name
from rosproto.gateway.rosbridge.values import from_values, to_json

if TYPE_CHECKING:
    from rosproto.action import ActionServer, ServerGoal
    from rosproto.gateway.rosbridge.session import RosbridgeSession

__all__ = ["ProvidedActions"]

ACTIONS = 16  # that one client may provide; each is five topics
GLANCE_SECONDS = 0.05  # between two looks at whether a goal was cancelled


class _Goal:
    """A goal that the client works on."""

    def __init__(self, action: str, goal: ServerGoal) -> None:
        self.action = action
        self.goal = goal
        self.done = threading.Event()
        self.answer: ActionResult | None = None


class ProvidedActions:
    """Actions that one client provides, and their goals."""

    def __init__(self, shared: Shared, session: RosbridgeSession) -> None:
        self._shared = shared
        self._session = session
        self._lock = threading.Lock()
        self._servers: dict[str, ActionServer] = {}
        self._goals: dict[str, _Goal] = {}
        self._numbers = itertools.count(1)
        self._closed = False

    def advertise(self, asked: AdvertiseAction) -> None:
        """Provide an action; in place of the one of that name that the client had.

        Raises:
            Refused, RosError: It cannot.
        """
        from rosproto.action import ActionServer

        name = self._shared.node.resolve_name(asked.action)
        insist(self._shared.access.may_write("action", name))
        if is_tf_name(name):
            raise Refused(f"{name} is provided by the gateway itself")
        self.unadvertise(UnadvertiseAction(None, asked.action))
        if len(self._servers) >= ACTIONS:
            raise Refused(f"{ACTIONS} actions are provided, which is the limit for a client")
        self._shared.take_action(name)
        try:
            server = ActionServer(
                self._shared.node,
                name,
                action_type(asked.type),
                partial(self._work, asked.action, asked.type),
                concurrent=True,
                most_goals=self._shared.limits.goals_per_client,
            )
        except BaseException:
            self._shared.leave_action(name)
            raise
        with self._lock:
            if not self._closed:
                self._servers[asked.action] = server
                return
        self._end(server)

    def unadvertise(self, asked: UnadvertiseAction) -> None:
        """Provide it no more; goals under way are aborted."""
        with self._lock:
            server = self._servers.pop(asked.action, None)
        if server is not None:
            self._give_up(asked.action)
            self._end(server)

    def _end(self, server: ActionServer) -> None:
        server.close()
        self._shared.leave_action(server.name)

    def feedback(self, given: ActionFeedback) -> None:
        """The client tells how far a goal is.

        Raises:
            Refused, RosError: It works on no such goal, or the feedback does not fit.
        """
        found = self._goal(given.id)
        server = self._servers.get(found.action)
        if server is not None:
            now = self._shared.node.clock.now()
            found.goal.publish_feedback(from_values(server.type.feedback, given.values, now=now))

    def result(self, given: ActionResult) -> None:
        """The client has ended a goal.

        Raises:
            Refused: It works on no such goal.
        """
        found = self._goal(given.id)
        found.answer = given
        found.done.set()

    def _goal(self, id: object) -> _Goal:
        with self._lock:
            found = self._goals.get(str(id))
        if found is None or found.answer is not None:
            raise Refused(f"no goal with the id {id!r} waits for this client")
        return found

    def _work(self, action: str, type_name: str, goal: ServerGoal) -> None:
        """To the end of one goal, in a thread of its own."""
        id = f"action_goal:{action}:{next(self._numbers)}"
        mine = _Goal(action, goal)
        with self._lock:
            gone = self._closed or action not in self._servers
            if not gone:
                self._goals[id] = mine
        if gone:
            goal.abort(text="the client that provides it has gone")
            return
        write = self._session.protocol
        try:
            self._session.answer(write.send_action_goal, id, action, type_name, to_json(goal.goal))
            cancelled = False
            while not mine.done.wait(None if cancelled else GLANCE_SECONDS):
                if goal.cancel_requested and not cancelled:
                    cancelled = True
                    self._session.answer(write.cancel_action_goal, id, action)
        finally:
            with self._lock:
                self._goals.pop(id, None)
        self._conclude(mine)

    def _conclude(self, mine: _Goal) -> None:
        """End the goal as the client has said."""
        answer, goal = mine.answer, mine.goal
        server = self._servers.get(mine.action)
        if answer is None or server is None:
            goal.abort(text="the client that provides it has gone")
            return
        if not answer.result:
            goal.abort(text=answer.values[:1000] if isinstance(answer.values, str) else "the client says no")
            return
        try:
            values = {} if answer.values is None else answer.values
            result = from_values(server.type.result, values, now=self._shared.node.clock.now())
        except CodecError as error:
            self._session.status("error", f"action_result: {mine.action}: {error}", answer.id)
            goal.abort(text=f"the client's result does not fit: {error}")
            return
        ends = {ActionStatus.SUCCEEDED: goal.succeed, ActionStatus.CANCELED: goal.preempted}
        ends.get(ActionStatus(answer.status), goal.abort)(result)

    def _give_up(self, action: str | None) -> None:
        with self._lock:
            ended = [mine for mine in self._goals.values() if action in (None, mine.action)]
        for mine in ended:
            mine.done.set()

    def close(self) -> None:
        """The client has gone."""
        with self._lock:
            self._closed = True
            servers, self._servers = list(self._servers.values()), {}
        self._give_up(None)
        for server in servers:
            try:
                self._end(server)
            except RosError:
                continue  # the others, too
