"""Actions between us and roscpp's actionlib, both ways."""

from __future__ import annotations

from pathlib import Path

import rosproto
from rosproto.action import ActionClient, ActionServer, GoalStatus
from rosproto.master import Master
from tests.interop.test_actions_rospy import handler_for
from tests.support import ros

ACTION = "woosh_msgs/StepControl"


def test_our_client_with_roscpps_simple_server(roscpp_peer: Path, our_master: Master) -> None:
    with (
        ros.start_program(roscpp_peer, our_master.uri, "action_server") as server,
        rosproto.Node("/ours", master_uri=our_master.uri, host="127.0.0.1") as node,
        ActionClient(node, "/act", ACTION) as client,
    ):
        server.wait_for("up")
        client.wait_for_server(60)
        handle = client.send_goal(client.type.goal(mode=1))
        assert handle.wait(60).percent == 7
        assert (handle.status, handle.text) == (GoalStatus.SUCCEEDED, "well")

        handle = client.send_goal(client.type.goal(mode=2))
        assert next(handle.feedback(60)).percent == 0.5
        assert handle.cancel()
        assert handle.wait(60).percent == 9
        assert (handle.status, handle.text) == (GoalStatus.PREEMPTED, "as you wish")

        handle = client.send_goal(client.type.goal(mode=4))
        handle.wait(60)
        assert (handle.status, handle.text) == (GoalStatus.ABORTED, "cannot")


NOT_YET_KNOWN = "Got a callback on a goalHandle that we're not tracking."
"""What roscpp logs for feedback that its other thread takes before `sendGoal` has stored the handle of the goal."""


def test_roscpps_simple_client_with_our_server(roscpp_peer: Path, our_master: Master) -> None:
    with (
        rosproto.Node("/ours", master_uri=our_master.uri, host="127.0.0.1") as node,
        ActionServer(node, "/act", ACTION, handler_for(ACTION)),
        ros.start_program(roscpp_peer, our_master.uri, "action_client") as client,
    ):
        assert client.wait(60) == 0, client.output
        lines = [
            line
            for line in client.output.splitlines()
            if not line.startswith("[") and NOT_YET_KNOWN not in line
        ]
    assert lines == ["SUCCEEDED 7 well", "ABORTED 0 RuntimeError: ours broke", "PREEMPTED as you wish"]
