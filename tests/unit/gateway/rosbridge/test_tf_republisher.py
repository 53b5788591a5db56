"""The action /tf2_web_republisher: which transforms are sent, when again, and how it ends."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import closing

import pytest

from rosproto.action import ActionClient, GoalStatus
from rosproto.codec import service_class
from rosproto.errors import ServiceError
from rosproto.gateway.rosbridge import tf_republisher
from rosproto.gateway.rosbridge.tf_republisher import TfRepublisher
from rosproto.master import Master
from rosproto.node import Node
from rosproto.tf import StaticTransformBroadcaster, Transform, TransformBroadcaster
from rosproto.time import Duration
from tests.support.victim import eventually

Request = service_class("tf2_web_republisher/RepublishTFs").Request


@pytest.fixture
def nodes() -> Iterator[tuple[Node, Node]]:
    """A robot and the gateway."""
    with (
        Master() as master,
        Node("/robot", master_uri=master.uri, rosout=False) as robot,
        Node("/gateway", master_uri=master.uri, rosout=False) as gateway,
    ):
        yield robot, gateway


def a_goal(**changes: object) -> dict[str, object]:
    return {
        "source_frames": ["/base", "laser", "nowhere"], "target_frame": "/map",
        "angular_thres": 0.1, "trans_thres": 0.5, "rate": 100.0, **changes,
    }  # fmt: skip


def test_frames_are_sent_first_and_when_they_moved(nodes: tuple[Node, Node]) -> None:
    """All that are known at once, then those beyond a threshold; cancelling ends it."""
    robot, gateway = nodes
    with (
        StaticTransformBroadcaster(robot) as fixed,
        TransformBroadcaster(robot) as moving,
        closing(TfRepublisher(gateway)),
        ActionClient(robot, "/tf2_web_republisher", "tf2_web_republisher/TFSubscription") as client,
    ):
        client.wait_for_server(5)
        with robot.publisher("/tf", "tf2_msgs/TFMessage") as same:
            same.wait_for_connection(5)
        fixed.send(Transform.planar("base", "laser", 1.0, 0.0, 0.0))
        moving.send(Transform.planar("map", "base", 1.0, 0.0, 0.0, stamp=1.0))
        came: dict[str, list[object]] = {}
        goal = client.send_goal(
            a_goal(),
            feedback=lambda _, feedback: [
                came.setdefault(t.child_frame_id, []).append((t.header.frame_id, t.transform.translation.x))
                for t in feedback.transforms
            ],
        )
        eventually(lambda: came == {"base": [("map", 1.0)], "laser": [("map", 2.0)]})
        moving.send(Transform.planar("map", "base", 1.2, 0.0, 0.05, stamp=2.0))  # within both thresholds
        moving.send(Transform.planar("map", "base", 1.0, 0.0, math.pi / 2, stamp=3.0))
        eventually(lambda: len(came["base"]) == 2 and len(came["laser"]) == 2)
        moving.send(Transform.planar("map", "base", 9.0, 0.0, math.pi / 2, stamp=4.0))
        eventually(lambda: came["base"][2:] == [("map", 9.0)])
        goal.cancel()
        eventually(lambda: goal.status is GoalStatus.PREEMPTED)


def test_the_goals_of_a_client_that_left_end(nodes: tuple[Node, Node]) -> None:
    """A page that is closed cancels nothing; the others' goals go on."""
    robot, gateway = nodes
    with (
        closing(TfRepublisher(gateway)) as republisher,
        ActionClient(robot, "/tf2_web_republisher", "tf2_web_republisher/TFSubscription") as client,
    ):
        client.wait_for_server(5)
        first, second = client.send_goal(a_goal()), client.send_goal(a_goal())
        eventually(lambda: first.status is second.status is GoalStatus.ACTIVE)
        republisher.sent("page", first.goal_id)
        republisher.sent("another page", second.goal_id)
        republisher.gone("page")
        republisher.gone("a third page")
        eventually(lambda: first.status is GoalStatus.PREEMPTED)
        assert second.status is GoalStatus.ACTIVE


@pytest.mark.promise("64 of each at a time, 500 frames, 100 Hz at most")
@pytest.mark.parametrize(
    "change",
    [
        {"rate": 0.0}, {"rate": -1.0}, {"rate": float("nan")}, {"rate": 1e9}, {"angular_thres": -1.0},
        {"trans_thres": float("nan")}, {"target_frame": "/"}, {"source_frames": ["a"] * 501},
    ],
)  # fmt: skip
def test_a_goal_without_sense_is_rejected(nodes: tuple[Node, Node], change: dict[str, object]) -> None:
    """A rate that would never or always send, thresholds that are none, too many frames."""
    robot, gateway = nodes
    with (
        closing(TfRepublisher(gateway)),
        ActionClient(robot, "/tf2_web_republisher", "tf2_web_republisher/TFSubscription") as client,
    ):
        client.wait_for_server(5)
        goal = client.send_goal(a_goal(**change))
        eventually(lambda: goal.status is GoalStatus.REJECTED)
        assert goal.text
        assert "check" not in goal.text


def test_a_topic_for_clients_that_call_the_service(nodes: tuple[Node, Node]) -> None:
    """Each call gets a topic, whose new subscribers get all transforms; it closes without subscribers."""
    robot, gateway = nodes
    with StaticTransformBroadcaster(robot) as fixed, closing(TfRepublisher(gateway)):
        fixed.send(
            Transform.planar("map", "base", 1.0, 0.0, 0.0), Transform.planar("base", "laser", 1.0, 0.0, 0.0)
        )
        client = robot.service_client("/republish_tfs", "tf2_web_republisher/RepublishTFs")
        client.wait(5)
        asked = {**a_goal(), "timeout": Duration(0, 0)}
        name = client.call(Request(**asked), timeout=5).topic_name
        assert client.call(Request(**asked), timeout=5).topic_name != name
        for _ in range(2):
            with robot.subscriber(name, "tf2_web_republisher/TFArray") as topic:
                came = {t.child_frame_id: t.transform.translation.x for t in topic.next(5).transforms}
                assert came == {"base": 1.0, "laser": 2.0}
        with pytest.raises(ServiceError, match="rate"):
            client.call(Request(**{**asked, "rate": 0.0}), timeout=5)
        assert topics(robot)
        eventually(lambda: not topics(robot), 10)


def topics(node: Node) -> list[str]:
    """The topics in the graph that calls of the service have opened."""
    return [name for name in node.master.get_system_state().publishers if "/tf_repub_" in name]


@pytest.mark.promise("64 of each at a time, 500 frames, 100 Hz at most")
def test_topics_of_the_service_are_bounded(nodes: tuple[Node, Node], monkeypatch: pytest.MonkeyPatch) -> None:
    """No client opens topics without end; closing ends them."""
    monkeypatch.setattr(tf_republisher, "MAX_TOPICS", 2)
    robot, gateway = nodes
    with closing(TfRepublisher(gateway)):
        client = robot.service_client("/republish_tfs", "tf2_web_republisher/RepublishTFs")
        client.wait(5)
        asked = {**a_goal(), "timeout": Duration(50, 0)}
        for _ in range(2):
            client.call(Request(**asked), timeout=5)
        with pytest.raises(ServiceError, match="which is the limit"):
            client.call(Request(**asked), timeout=5)
        eventually(lambda: len(topics(robot)) == 2, 10)  # each is registered in a thread of its own
    assert not topics(robot)


@pytest.mark.promise("64 of each at a time, 500 frames, 100 Hz at most")
def test_goals_are_bounded(nodes: tuple[Node, Node], monkeypatch: pytest.MonkeyPatch) -> None:
    """One client, or many, send no goals without end."""
    monkeypatch.setattr(tf_republisher, "MAX_GOALS", 2)
    robot, gateway = nodes
    with (
        closing(TfRepublisher(gateway)),
        ActionClient(robot, "/tf2_web_republisher", "tf2_web_republisher/TFSubscription") as client,
    ):
        client.wait_for_server(5)
        goals = [client.send_goal(a_goal()) for _ in range(8)]
        eventually(lambda: sum(goal.status is GoalStatus.REJECTED for goal in goals) >= 5)
        assert sum(goal.status is GoalStatus.ACTIVE for goal in goals) <= 3
