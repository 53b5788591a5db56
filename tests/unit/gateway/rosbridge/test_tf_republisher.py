"""The action /tf2_web_republisher: what is sent, when again, and that it ends."""

from __future__ import annotations

import math
from collections.abc import Iterator

import pytest

from rosproto.action import ActionClient, GoalStatus
from rosproto.gateway.rosbridge.tf_republisher import TfRepublisher
from rosproto.master import Master
from rosproto.node import Node
from rosproto.tf import StaticTransformBroadcaster, Transform, TransformBroadcaster
from tests.support.victim import eventually


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
        TfRepublisher(gateway),
        ActionClient(robot, "/tf2_web_republisher", "tf2_web_republisher/TFSubscription") as client,
    ):
        client.wait_for_server(5)
        moving._publisher.wait_for_connection(5)
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
        TfRepublisher(gateway) as republisher,
        ActionClient(robot, "/tf2_web_republisher", "tf2_web_republisher/TFSubscription") as client,
    ):
        client.wait_for_server(5)
        first, second = client.send_goal(a_goal()), client.send_goal(a_goal())
        eventually(lambda: len(republisher._server.goals) == 2)
        republisher.sent("page", first.goal_id)
        republisher.sent("another page", second.goal_id)
        republisher.gone("page")
        republisher.gone("a third page")
        eventually(lambda: first.status is GoalStatus.PREEMPTED)
        assert [goal.id for goal in republisher._server.goals] == [second.goal_id]


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
        TfRepublisher(gateway),
        ActionClient(robot, "/tf2_web_republisher", "tf2_web_republisher/TFSubscription") as client,
    ):
        client.wait_for_server(5)
        goal = client.send_goal(a_goal(**change))
        eventually(lambda: goal.status is GoalStatus.REJECTED)
        assert goal.text
        assert "check" not in goal.text
