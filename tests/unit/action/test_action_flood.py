"""Strangers may speak on an action's topics under any number of names and goal ids: what is kept is bounded."""

from __future__ import annotations

import pytest

from rosproto.action.client import ActionClient
from rosproto.action.goal_tracker import MAX_SERVERS
from rosproto.protocol.goal_server import MAX_ENDED, GoalList
from tests.support.clock import FakeClock
from tests.unit.action.fakegraph import Goal, Graph

ACTIVE = 1


@pytest.mark.promise("is bounded in number and length")
def test_servers_under_invented_names_are_forgotten(
    graph: Graph, client: ActionClient, clock: FakeClock
) -> None:
    """All but the one that has our goal: its silence is what counts."""
    handle = client.send_goal(Goal())
    graph.status((handle.goal_id, ACTIVE), server="/srv")
    for number in range(1000):
        clock.advance(0.001)
        graph.connect_server(f"/stranger{number}")
        graph.status(server=f"/stranger{number}")
    assert len(client.servers) == MAX_SERVERS
    assert "/srv" in client.servers


@pytest.mark.promise("is bounded in number and length")
def test_goals_that_have_ended_are_told_of_within_bounds() -> None:
    """A flood of refused goals does not make each status array longer for five seconds."""
    goals = GoalList()
    for number in range(3 * MAX_ENDED):
        record, new = goals.goal_received(f"goal{number}", number + 1, now=0.0)
        assert new
        goals.apply(record, "reject", 0.0, "no")
    running, _ = goals.goal_received("running", 1 << 40, now=0.0)
    goals.expire(0.1)
    assert len(goals) == MAX_ENDED + 1
    assert running in list(goals)
