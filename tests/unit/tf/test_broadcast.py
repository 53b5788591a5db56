"""Transforms over real nodes: broadcaster to listener, static ones for late subscribers, invalid ones."""

from __future__ import annotations

import logging
from collections.abc import Iterator

import pytest

from rosproto.codec import message_class
from rosproto.master import Master
from rosproto.node import Node
from rosproto.tf import (
    StaticTransformBroadcaster,
    Transform,
    TransformBroadcaster,
    TransformListener,
)
from rosproto.time import Time
from tests.support.victim import eventually

TFMessage = message_class("tf2_msgs/TFMessage")


@pytest.fixture(params=[True, False], ids=["intraprocess", "tcp"])
def nodes(request) -> Iterator[tuple[Node, Node]]:
    with (
        Master() as master,
        Node("/robot", master_uri=master.uri, rosout=False, intraprocess=request.param) as robot,
        Node("/laptop", master_uri=master.uri, rosout=False, intraprocess=request.param) as laptop,
    ):
        yield robot, laptop


def test_what_is_sent_can_be_looked_up_at_its_exact_time(nodes):
    robot, laptop = nodes
    stamp = Time(1_700_000_000, 123_456_789)
    with TransformListener(laptop) as listener, TransformBroadcaster(robot) as broadcaster:
        with robot.publisher("/tf", TFMessage) as same:
            same.wait_for_connection(20)
        message = Transform.planar("odom", "base", 3.0, 0.0, 0.0, stamp=stamp).to_message()
        broadcaster.send(Transform.planar("map", "odom", 1.0, 2.0, 0.5, stamp=stamp), message)
        found = listener.buffer.lookup("map", "base", stamp, timeout=20)
        assert found.stamp == stamp
        assert found.translation == pytest.approx(
            Transform.planar("map", "odom", 1.0, 2.0, 0.5).point((3.0, 0.0, 0.0))
        )
        assert listener.buffer.frames()["base"]["authority"] == "/robot"


def test_static_transforms_accumulate_and_reach_those_who_come_later(nodes):
    robot, laptop = nodes
    with StaticTransformBroadcaster(robot) as broadcaster:
        broadcaster.send(Transform.planar("base", "laser", 0.1, 0, 0))
        broadcaster.send(Transform.planar("base", "camera", 0.2, 0, 0))
        broadcaster.send(Transform.planar("base", "laser", 0.3, 0, 0))
        with TransformListener(laptop) as listener:
            assert listener.buffer.lookup("base", "camera", 99.0, timeout=20).translation[0] == 0.2
            assert listener.buffer.lookup("base", "laser", 5.0).translation[0] == 0.3


def test_nonsense_is_not_sent(nodes):
    robot, _ = nodes
    with TransformBroadcaster(robot) as broadcaster, pytest.raises(ValueError, match="own parent"):
        broadcaster.send(Transform("a", "b"), Transform("c", "c"))


def test_nonsense_from_the_wire_is_counted_and_named_once(nodes, caplog):
    robot, laptop = nodes
    caplog.set_level(logging.WARNING)
    bad = Transform("a", "b").to_message()
    bad.transform.rotation.w = 0.0
    with TransformListener(laptop) as listener, robot.publisher("/tf", TFMessage) as publisher:
        publisher.wait_for_connection(20)
        for _ in range(3):
            publisher.publish(transforms=[bad])
        publisher.publish(transforms=[Transform.planar("/map", "/good", 1.0, 0, 0, stamp=1.0).to_message()])
        listener.buffer.wait("map", "good", timeout=20)
        assert listener.refused == 3
    assert sum("transform of b from /robot" in record.getMessage() for record in caplog.records) == 1


def test_a_clock_that_jumps_back_clears_what_moves(nodes, monkeypatch):
    robot, laptop = nodes
    now = [100.0]
    monkeypatch.setattr(laptop.clock, "now", lambda: Time.from_sec(now[0]))
    listener = TransformListener(laptop)
    with StaticTransformBroadcaster(robot) as fixed, robot.publisher("/tf", TFMessage) as moving:
        fixed.send(Transform.planar("base", "laser", 1.0, 0, 0))
        moving.wait_for_connection(20)
        moving.publish(transforms=[Transform.planar("map", "base", 1.0, 0, 0, stamp=100.0).to_message()])
        listener.buffer.wait("map", "laser", timeout=20)
        now[0] = 10.0
        moving.publish(transforms=[])
        eventually(lambda: list(listener.buffer.frames()) == ["laser"])
    listener.close()
    listener.close()
