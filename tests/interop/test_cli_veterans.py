"""`rosproto log`, `service node`, `tf` and `dynparam` beside Debian's tools and rospy's nodes."""

from __future__ import annotations

import json

import pytest

from rosproto.cli import main
from tests.support import ros

SPEAKER = """
import rospy, tf2_ros
from geometry_msgs.msg import TransformStamped
from roscpp.srv import Empty
rospy.init_node("speaker", disable_signals=True)
rospy.Service("/lamp", Empty, lambda request: [])
moving = tf2_ros.TransformBroadcaster()
m = TransformStamped()
m.header.frame_id, m.child_frame_id, m.transform.rotation.w = "map", "base", 1.0
print("ready", flush=True)
rate = rospy.Rate(20)
while not rospy.is_shutdown():
    m.header.stamp = rospy.Time.now()
    moving.sendTransform(m)
    rospy.logwarn("the battery is low")
    rospy.loginfo("all is well")
    rate.sleep()
"""


@pytest.fixture
def speaker(any_master):
    ros.require_ros("tf2_ros")
    with ros.start_rospy(SPEAKER, any_master) as process:
        process.wait_for("ready")
        yield any_master


def test_log_reads_rospy_and_sets_its_levels_as_rosconsole_does(speaker, capsys):
    at = ("--master", speaker)
    assert main(["log", "echo", "-l", "warn", "--node", "/speaker", "-n", "3", "--json", *at]) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert {(line["level"], line["text"]) for line in lines} == {("warn", "the battery is low")}
    assert main(["log", "list", "/speaker", *at]) == 0
    ours = sorted(line.split()[0] for line in capsys.readouterr().out.splitlines())
    assert ours == sorted(ros.ros_tool(["rosconsole", "list", "/speaker"], speaker).stdout.split())
    assert main(["log", "set", "/speaker", "rosout", "error", *at]) == 0
    found = ros.ros_tool(["rosconsole", "get", "/speaker", "rosout"], speaker).stdout
    assert found.strip().lower() == "error"


def test_service_node_as_rosservice(speaker, capsys):
    assert main(["service", "node", "/lamp", "--master", speaker]) == 0
    assert capsys.readouterr().out == ros.ros_tool(["rosservice", "node", "/lamp"], speaker).stdout


def test_tf_monitor_and_frames_of_tf2_ros(speaker, capsys, tmp_path):
    at = ("--master", speaker)
    assert main(["tf", "monitor", "-n", "2", "--json", *at]) == 0
    (base,) = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert (base["frame"], base["parent"], base["sender"]) == ("base", "map", "/speaker")
    assert 10.0 < base["rate"] < 30.0
    assert main(["tf", "frames", "-o", str(tmp_path / "f.svg"), "--seconds", "1", *at]) == 0
    assert "/speaker, " in (tmp_path / "f.svg").read_text()
