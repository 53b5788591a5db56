"""`TfOnDemand`: starts at the first use, allows its names without a pattern, and no others."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import pytest

from rosproto.gateway import Access, Rosbridge
from rosproto.master import Master
from rosproto.node import Node, Subscriber
from rosproto.tf import StaticTransformBroadcaster, Transform
from tests.support.victim import eventually

websockets = pytest.importorskip(
    "websockets.sync.client", reason='websockets is not installed: pip install ".[bridge]"'
)


@pytest.fixture
def nodes() -> Iterator[tuple[Node, Node]]:
    """A robot that knows a transform, and the gateway's node."""
    with (
        Master() as master,
        Node("/robot", master_uri=master.uri, rosout=False) as robot,
        Node("/gateway", master_uri=master.uri, rosout=False) as gateway,
        StaticTransformBroadcaster(robot) as fixed,
    ):
        fixed.send(Transform.planar("map", "base", 1.5, 0.0, 0.0))
        yield robot, gateway


def until(client: Any, op: str) -> dict[str, Any]:
    """The next message of an operation."""
    while True:
        came: dict[str, Any] = json.loads(client.recv(timeout=10))
        if came["op"] == op:
            return came


GOAL = {
    "goal_id": {"id": "mine", "stamp": {"secs": 0, "nsecs": 0}},
    "goal": {"source_frames": ["base"], "target_frame": "map", "angular_thres": 0.1, "trans_thres": 0.1, "rate": 50},
}  # fmt: skip


def running(status: Subscriber) -> list[str]:
    """The goals that are active or being cancelled in the next status."""
    return [each.goal_id.id for each in status.next(10).status_list if each.status in (0, 1, 6, 7)]


def say(client: Any, **message: Any) -> None:
    client.send(json.dumps(message))


def send_goal(client: Any) -> None:
    say(client, op="subscribe", topic="/tf2_web_republisher/feedback")
    goal = "tf2_web_republisher/TFSubscriptionActionGoal"
    say(client, op="advertise", topic="/tf2_web_republisher/goal", type=goal)
    say(client, op="publish", topic="/tf2_web_republisher/goal", msg=GOAL)


@pytest.mark.promise("They end with their client, and are not offered when `/tf` is hidden")
def test_it_begins_with_the_first_goal_and_ends_with_its_client(nodes: tuple[Node, Node]) -> None:
    """Nothing of it is in the graph before; a page that is gone leaves no goal."""
    robot, gateway = nodes
    with Rosbridge(gateway, port=0) as bridge:
        assert "/tf2_web_republisher/status" not in robot.master.get_topic_types()
        with websockets.connect(bridge.url) as client:
            send_goal(client)
            feedback = until(client, "publish")["msg"]["feedback"]["transforms"]
            assert feedback[0]["child_frame_id"] == "base"
            assert feedback[0]["transform"]["translation"]["x"] == 1.5
            with robot.subscriber(
                "/tf2_web_republisher/status", "actionlib_msgs/GoalStatusArray", queue_size=1
            ) as status:
                assert running(status) == ["mine"]
        with robot.subscriber(
            "/tf2_web_republisher/status", "actionlib_msgs/GoalStatusArray", queue_size=1
        ) as status:
            eventually(lambda: running(status) == [], 10)
    eventually(lambda: "/tf2_web_republisher" not in str(robot.master.get_system_state()), 10)


def test_the_action_operations_and_the_service_reach_it(nodes: tuple[Node, Node]) -> None:
    """roslib's client for ROS 2 names another package; roslibpy calls the service."""
    _, gateway = nodes
    with Rosbridge(gateway, port=0) as bridge, websockets.connect(bridge.url) as client:
        kind = "tf2_web_republisher_interfaces/TFSubscription"
        sent = {"action": "/tf2_web_republisher", "action_type": kind, "args": GOAL["goal"], "feedback": True}
        say(client, op="send_action_goal", id="a", **sent)
        assert until(client, "action_feedback")["values"]["transforms"][0]["child_frame_id"] == "base"
        say(client, op="cancel_action_goal", id="a", action="/tf2_web_republisher")
        assert until(client, "action_result")["status"] == 5  # cancelled
        args = {**GOAL["goal"], "timeout": {"secs": 5, "nsecs": 0}}  # type: ignore[dict-item]
        say(client, op="call_service", id="b", service="/republish_tfs", args=args)
        topic = until(client, "service_response")["values"]["topic_name"]
        say(client, op="subscribe", topic=topic)
        assert until(client, "publish")["msg"]["transforms"][0]["transform"]["translation"]["x"] == 1.5


@pytest.mark.promise("They end with their client, and are not offered when `/tf` is hidden")
@pytest.mark.parametrize("denied", ["/tf", "topic:/tf2_web_republisher/goal"])
def test_where_tf_is_hidden_it_is_not_there(nodes: tuple[Node, Node], denied: str) -> None:
    """A pattern that hides /tf, or the action, is no way around either."""
    robot, gateway = nodes
    with (
        Rosbridge(gateway, port=0, access=Access(deny=(denied,))) as bridge,
        websockets.connect(bridge.url) as client,
    ):
        send_goal(client)
        assert "refused" in (peer_log := until(client, "status")["msg"]) or "not open" in peer_log
        assert "/tf2_web_republisher/status" not in robot.master.get_topic_types()


@pytest.mark.promise("They end with their client, and are not offered when `/tf` is hidden")
def test_other_goals_stay_closed(nodes: tuple[Node, Node]) -> None:
    """Only this action is open without a pattern."""
    _, gateway = nodes
    with Rosbridge(gateway, port=0) as bridge, websockets.connect(bridge.url) as client:
        say(client, op="advertise", topic="/move_base/goal", type="move_base_msgs/MoveBaseActionGoal")
        assert "refused" in until(client, "status")["msg"]
        say(client, op="call_service", id="b", service="/robot/set_logger_level", args={})
        assert until(client, "service_response")["result"] is False


def test_it_leaves_a_real_one_alone(nodes: tuple[Node, Node]) -> None:
    """Where a tf2_web_republisher runs, goals go to that."""
    robot, gateway = nodes
    robot.publisher("/tf2_web_republisher/status", "actionlib_msgs/GoalStatusArray")
    with (
        robot.subscriber("/tf2_web_republisher/goal", None) as goals,
        Rosbridge(gateway, port=0) as bridge,
        websockets.connect(bridge.url) as client,
    ):
        kind = "tf2_web_republisher/TFSubscriptionActionGoal"
        say(client, op="advertise", topic="/tf2_web_republisher/goal", type=kind, latch=True)
        say(client, op="publish", topic="/tf2_web_republisher/goal", msg=GOAL)
        assert goals.next(10).goal_id.id == "mine"
        state = robot.master.get_system_state()
        assert state.publishers["/tf2_web_republisher/status"] == ["/robot"]
        assert "/republish_tfs" not in state.services
