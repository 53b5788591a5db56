"""Many goals at once between two real nodes: every one comes to its end."""

from __future__ import annotations

import pytest

from rosproto.action import ActionClient, ActionServer, GoalStatus
from rosproto.master import Master
from rosproto.node import Node

GOALS = 90  # fewer than the server takes; more than any queue once held


@pytest.mark.parametrize("intraprocess", [True, False], ids=["local", "tcp"])
def test_no_goal_and_no_result_of_a_burst_is_lost(intraprocess: bool) -> None:
    """A goal that a full queue drops would leave its client waiting, and nobody would know why."""
    with (
        Master() as master,
        Node("/s", master_uri=master.uri, intraprocess=intraprocess, rosout=False) as serving,
        Node("/c", master_uri=master.uri, intraprocess=intraprocess, rosout=False) as asking,
        ActionServer(
            serving, "/do", "actionlib/Test", lambda goal: {"result": goal.goal.goal}, concurrent=True
        ),
        # None: a busy computer may need longer than the five seconds after which a goal counts as lost.
        ActionClient(asking, "/do", "actionlib/Test", ack_timeout=None) as client,
    ):
        client.wait_for_server(20)
        handles = [client.send_goal({"goal": number}) for number in range(GOALS)]
        assert [handle.wait(60).result for handle in handles] == list(range(GOALS))
        assert {handle.status for handle in handles} == {GoalStatus.SUCCEEDED}
