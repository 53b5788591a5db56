"""`rosproto master` in the place of roscore: rospy and roscpp log, Debian's tools read /rosout_agg."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.support import ros
from tests.unit.cli.test_master import command, first_line

LOGGER = """
import rospy
rospy.init_node("py_logger")
while not rospy.is_shutdown():
    rospy.logwarn("rospy says %d", 7)
    rospy.sleep(0.1)
"""


@pytest.fixture
def uri() -> Iterator[str]:
    ros.require_ros("rospy")
    with command("master", "--port", "0") as process:
        yield first_line(process)


@pytest.mark.interop
def test_rostopic_reads_the_log_of_a_rospy_node_from_rosout_agg(uri: str) -> None:
    with ros.start_rospy(LOGGER, uri):
        done = ros.ros_tool(["rostopic", "echo", "-n", "1", "/rosout_agg"], uri)
    assert 'name: "/py_logger"' in done.stdout
    assert 'msg: "rospy says 7"' in done.stdout


@pytest.mark.interop
def test_rosnode_and_rosservice_know_the_node(uri: str) -> None:
    """As Debian's /rosout shows itself."""
    info = ros.ros_tool(["rosnode", "info", "/rosout"], uri).stdout
    assert " * /rosout_agg [rosgraph_msgs/Log]" in info
    assert " * /rosout [" in info
    assert " * /rosout/get_loggers" in info
    assert " * /rosout/set_logger_level" in info
    loggers = ros.ros_tool(["rosservice", "call", "/rosout/get_loggers"], uri).stdout
    assert 'name: "root"' in loggers
    assert ros.ros_tool(["rosnode", "ping", "-c", "1", "/rosout"], uri).stdout.count("reply from") == 1


@pytest.mark.interop
def test_the_parameters_of_roscore_are_there(uri: str) -> None:
    """What tools read before they do anything."""
    assert ros.ros_tool(["rosparam", "get", "/rosdistro"], uri).stdout.strip("\n '") == "noetic"
    assert len(ros.ros_tool(["rosparam", "get", "/run_id"], uri).stdout.strip()) >= 36
