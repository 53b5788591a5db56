"""Actions that one client provides: an action server of ROS 1 whose goals are carried to the client and back.

`advertise_action` is rosbridge's for ROS 2: every goal starts at once and ends as the client says, by its id.
When a client leaves or stops providing an action, its goals are aborted.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from rosproto.errors import CodecError, RosError
from rosproto.gateway.rosbridge.actions import ActionStatus, action_type
from rosproto.gateway.rosbridge.client_provided import GONE, ClientProvided, Request
from rosproto.gateway.rosbridge.operations import (
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
CANCEL_CHECK_SECONDS = 0.05  # between two checks whether a goal was cancelled


class _Goal(Request[ActionResult]):
    """A goal that the client works on."""

    def __init__(self, action: str, goal: ServerGoal) -> None:
        super().__init__(action)
        self.goal = goal


class ProvidedActions:
    """Actions that one client provides, and their goals."""

    def __init__(self, shared: Shared, session: RosbridgeSession) -> None:
        self._shared = shared
        self._session = session
        self._provided: ClientProvided[ActionServer, _Goal] = ClientProvided("action_goal")

    def advertise(self, asked: AdvertiseAction) -> None:
        """Provide an action; replaces the client's earlier one of that name.

        Raises:
            Refused, RosError: It cannot be provided.
        """
        from rosproto.action import ActionServer

        name = self._shared.node.resolve_name(asked.action)
        insist(self._shared.access.may_write("action", name))
        if is_tf_name(name):
            raise Refused(f"{name} is provided by the gateway itself")
        self.unadvertise(UnadvertiseAction(None, asked.action))
        if len(self._provided) >= ACTIONS:
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
        if not self._provided.add(asked.action, server):
            self._end(server)

    def unadvertise(self, asked: UnadvertiseAction) -> None:
        """Stop providing an action; its goals are aborted."""
        server = self._provided.remove(asked.action)
        if server is not None:
            self._end(server)

    def _end(self, server: ActionServer) -> None:
        server.close()
        self._shared.leave_action(server.name)

    def feedback(self, given: ActionFeedback) -> None:
        """The client reports progress of a goal.

        Raises:
            Refused, RosError: It works on no such goal, or the feedback does not fit.
        """
        found = self._provided.waiting(given.id)
        if found is None:
            raise Refused(f"no goal with the id {given.id!r} waits for an answer")
        server = self._provided.server(found.name)
        if server is not None:
            now = self._shared.node.clock.now()
            found.goal.publish_feedback(from_values(server.type.feedback, given.values, now=now))

    def result(self, given: ActionResult) -> None:
        """The client has ended a goal.

        Raises:
            Refused: It works on no such goal.
        """
        self._provided.answer(given.id, given, "goal")

    def _work(self, action: str, type_name: str, goal: ServerGoal) -> None:
        """Follows one goal to its end, in a thread of its own."""
        mine = _Goal(action, goal)
        problem = self._provided.begin(mine)
        if problem is not None:
            goal.abort(text=problem)
            return
        write = self._session.protocol
        try:
            self._session.answer(write.send_action_goal, mine.id, action, type_name, to_json(goal.goal))
            cancelled = False
            while not mine.done.wait(None if cancelled else CANCEL_CHECK_SECONDS):
                if goal.cancel_requested and not cancelled:
                    cancelled = True
                    self._session.answer(write.cancel_action_goal, mine.id, action)
        finally:
            self._provided.end(mine)
        self._conclude(mine)

    def _conclude(self, mine: _Goal) -> None:
        """End the goal with the client's result."""
        answer, goal = mine.answer, mine.goal
        server = self._provided.server(mine.name)
        if answer is None or server is None:
            goal.abort(text=GONE)
            return
        if not answer.result:
            goal.abort(text=answer.values[:1000] if isinstance(answer.values, str) else "the client says no")
            return
        try:
            values = {} if answer.values is None else answer.values
            result = from_values(server.type.result, values, now=self._shared.node.clock.now())
        except CodecError as error:
            self._session.status("error", f"action_result: {mine.name}: {error}", answer.id)
            goal.abort(text=f"the client's result does not fit: {error}")
            return
        ends = {ActionStatus.SUCCEEDED: goal.succeed, ActionStatus.CANCELED: goal.preempted}
        ends.get(ActionStatus(answer.status), goal.abort)(result)

    def close(self) -> None:
        """The client has gone: stop providing its actions; their goals are aborted."""
        for server in self._provided.close():
            try:
                self._end(server)
            except RosError:
                continue  # the others must end, too
