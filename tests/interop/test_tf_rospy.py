"""Transforms with tf2_ros (rospy) over a graph: it listens to ours, we listen to its."""

from __future__ import annotations

import json
import math

import pytest

from rosproto.node import Node
from rosproto.tf import StaticTransformBroadcaster, Transform, TransformBroadcaster, TransformListener
from tests.support import ros

LISTEN = """
import json, rospy, tf2_ros
rospy.init_node("tf_listener", disable_signals=True)
buffer = tf2_ros.Buffer()
listener = tf2_ros.TransformListener(buffer)
print("listening", flush=True)
m = buffer.lookup_transform("map", "laser", rospy.Time(0), rospy.Duration(60))
t, r = m.transform.translation, m.transform.rotation
print("found", json.dumps([[t.x, t.y, t.z], [r.x, r.y, r.z, r.w], m.header.stamp.to_nsec()]), flush=True)
"""
SEND = """
import rospy, tf2_ros
from geometry_msgs.msg import TransformStamped
rospy.init_node("tf_sender", disable_signals=True)
def pose(parent, child, x, z):
    m = TransformStamped()
    m.header.stamp, m.header.frame_id, m.child_frame_id = rospy.Time.now(), parent, child
    m.transform.translation.x = x
    m.transform.rotation.z, m.transform.rotation.w = z, (1 - z * z) ** 0.5
    return m
static = tf2_ros.StaticTransformBroadcaster()
static.sendTransform(pose("base", "laser", 0.25, 0.0))
moving = tf2_ros.TransformBroadcaster()
rate = rospy.Rate(50)
while not rospy.is_shutdown():
    moving.sendTransform(pose("map", "base", 2.0, 0.6))
    rate.sleep()
"""


@pytest.fixture(autouse=True)
def _tf2_is_there():
    ros.require_ros("tf2_ros")


def test_tf2_ros_looks_up_what_we_send(any_master):
    with (
        Node("/ours", master_uri=any_master) as node,
        StaticTransformBroadcaster(node) as static,
        TransformBroadcaster(node) as moving,
    ):
        static.send(Transform.planar("base", "laser", 0.5, 0.0, 0.0))
        with ros.start_rospy(LISTEN, any_master) as listener:
            listener.wait_for("^listening")
            moving._publisher.wait_for_connection(60)
            now = node.clock.now()
            moving.send(Transform.planar("map", "base", 1.0, 2.0, math.pi / 2, stamp=now))
            translation, rotation, stamp = json.loads(listener.wait_for(r"^found (.*)").group(1))
    assert translation == pytest.approx([1.0, 2.5, 0.0])
    assert rotation == pytest.approx([0, 0, math.sin(math.pi / 4), math.cos(math.pi / 4)])
    assert abs(stamp - now.to_nsec()) < 200  # tf2's Python binding takes times through a double


def test_we_look_up_what_tf2_ros_sends(any_master):
    with (
        Node("/ours", master_uri=any_master) as node,
        TransformListener(node) as listener,
        ros.start_rospy(SEND, any_master),
    ):
        found = listener.buffer.lookup("map", "laser", timeout=60)
        assert found.translation == pytest.approx((2.0 + 0.25 * (1 - 2 * 0.36), 0.25 * 2 * 0.6 * 0.8, 0.0))
        assert found.rotation == pytest.approx((0.0, 0.0, 0.6, 0.8))
        assert listener.buffer.frames()["laser"]["static"]
        assert listener.buffer.frames()["base"]["authority"] == "/tf_sender"
        assert listener.refused == 0
