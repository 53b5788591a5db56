"""Topics between us and rospy, both directions, on our master and on Debian's."""

from __future__ import annotations

import re
import time
from pathlib import Path

import pytest

from rosproto.node import Node
from tests.interop.topic_samples import TYPES, exchange, sample, wire
from tests.support import ros

ECHO = """
import sys, rospy, roslib.message
cls = roslib.message.get_message_class(sys.argv[1])
rospy.init_node("echo", disable_signals=True)
pub = rospy.Publisher("/out", cls, queue_size=10)
rospy.Subscriber("/in", cls, pub.publish)
print("up", flush=True)
rospy.spin()
"""


@pytest.mark.parametrize("type_name", TYPES)
def test_a_message_comes_back_from_rospy_as_it_was(
    any_master: str, genpy_packages: Path, type_name: str
) -> None:
    """Our publisher -> rospy's subscriber -> rospy's publisher -> our subscriber, byte for byte."""
    with (
        ros.start_rospy(ECHO, any_master, type_name, packages=genpy_packages),
        Node("/ours", master_uri=any_master) as node,
    ):
        received = node.subscriber("/out", type_name)
        publisher = node.publisher("/in", type_name)
        publisher.wait_for_connection(60)
        received.wait_for_connection(60)
        message = sample(type_name)
        back = exchange(publisher, received, message)
        assert wire(back) == wire(message)
        assert back._connection_header["callerid"] == "/echo"


def test_a_raw_relay_keeps_every_byte(any_master: str, genpy_packages: Path) -> None:
    """Bytes from rospy are published again without decoding; header.seq is not touched."""
    type_name = "sensor_msgs/LaserScan"
    with (
        ros.start_rospy(ECHO, any_master, type_name, packages=genpy_packages),
        Node("/ours", master_uri=any_master) as node,
    ):
        raw = node.subscriber("/out", raw=True)
        publisher = node.publisher("/in", type_name)
        publisher.wait_for_connection(60)
        raw.wait_for_connection(60)
        first = exchange(publisher, raw, sample(type_name))
        second = exchange(publisher, raw, first)
        assert second._buff[4:] == first._buff[4:]
        assert second._connection_header["type"] == type_name


LATCHED = """
import sys, rospy
from std_msgs.msg import String
rospy.init_node("latcher", disable_signals=True)
pub = rospy.Publisher("/latched", String, queue_size=10, latch=True)
pub.publish("kept")
print("up", flush=True)
rospy.spin()
"""
WAIT = """
import rospy
from std_msgs.msg import String
rospy.init_node("waiter", anonymous=True, disable_signals=True)
print("got", rospy.wait_for_message("/ours_latched", String, timeout=60).data, flush=True)
"""


def test_latched_messages_reach_late_subscribers(any_master: str) -> None:
    """rospy's latched message reaches us, also a second subscriber of the node; ours reaches rospy."""
    with ros.start_rospy(LATCHED, any_master) as latcher, Node("/ours", master_uri=any_master) as node:
        latcher.wait_for("up")
        first = node.subscriber("/latched", "std_msgs/String")
        assert first.next(60).data == "kept"
        assert node.subscriber("/latched").next(60).data == "kept"
        ours = node.publisher("/ours_latched", "std_msgs/String", latch=True)
        ours.publish(data="held")
        assert "got held" in ros.run_rospy(WAIT, any_master).stdout


def test_rostopic_and_rosnode_understand_us(any_master: str) -> None:
    """`rostopic echo` takes our type from the header, `rosnode info` reads getBusInfo, `rosnode kill` ends us."""
    with Node("/ours", master_uri=any_master) as node:
        publisher = node.publisher("/words", "std_msgs/String", latch=True)
        publisher.publish(data="hello")
        echo = ros.ros_tool(["rostopic", "echo", "-n", "1", "/words"], any_master)
        assert 'data: "hello"' in echo.stdout
        node.subscriber("/rosout_agg", "rosgraph_msgs/Log")
        info = ros.ros_tool(["rosnode", "info", "/ours"], any_master).stdout
        assert "* /words [std_msgs/String]" in info
        assert "* /rosout_agg" in info
        ros.ros_tool(["rosnode", "kill", "/ours"], any_master)
        assert node.wait(5)
        assert "/rosnode" in node.close_reason


PUBLISHER = """
import sys, rospy
from std_msgs.msg import String
rospy.init_node("talker", disable_signals=True)
pub = rospy.Publisher("/talk", String, queue_size=10)
rate = rospy.Rate(50)
while True:
    pub.publish(sys.argv[1]); rate.sleep()
"""


def test_a_killed_and_restarted_rospy_publisher_is_found_again(any_master: str) -> None:
    """kill -9 leaves the old URI at the master; the new process is connected all the same."""
    with Node("/ours", master_uri=any_master) as node:
        heard = node.subscriber("/talk", "std_msgs/String", queue_size=1)
        with ros.start_rospy(PUBLISHER, any_master, "one") as first:
            assert heard.next(60).data == "one"
            first.kill()
        with ros.start_rospy(PUBLISHER, any_master, "two"):
            end = time.monotonic() + 60
            while heard.next(60).data != "two":
                assert time.monotonic() < end


def test_another_md5sum_is_refused_and_told(any_master: str) -> None:
    """rospy refuses us; the error is observable, and named when `next` times out."""
    with ros.start_rospy(PUBLISHER, any_master, "x"), Node("/ours", master_uri=any_master) as node:
        told: list[Exception] = []
        wrong = node.subscriber("/talk", "std_msgs/Int32", on_error=told.append)
        end = time.monotonic() + 60
        while not any(re.search("md5sum|types do not match", str(error)) for error in wrong.errors):
            assert time.monotonic() < end, wrong.errors
            time.sleep(0.02)
        with pytest.raises(TimeoutError, match=r"md5sum|types do not match"):
            wrong.next(0.1)
        assert told
        assert told[0] in wrong.errors
