"""`rosproto topic|node|service|param|msg|srv` beside rostopic, rosnode, rosservice, rosparam and rosmsg.

One graph, both tools, the same words: what they print must be the same text.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator

import pytest

from rosproto import Master, Node
from tests.support import ros


@pytest.fixture(scope="module")
def graph() -> Iterator[str]:
    """Master URI of a graph with two nodes, a topic, a service and parameters; nothing in it changes."""
    with (
        Master() as master,
        Node("/a", master_uri=master.uri) as a,
        Node("/ns/b", master_uri=master.uri) as b,
        a.publisher("/cmd", "geometry_msgs/Twist", latch=True) as publisher,
        b.subscriber("/cmd", "geometry_msgs/Twist"),
        a.service_server("/set", "std_srvs/SetBool", lambda r: {"success": r.data, "message": "as told"}),
    ):
        publisher.wait_for_connection(timeout=5)
        publisher.publish(publisher.message_class())
        a.params["/x"] = 3
        a.params["/ns/list"] = [1, 2.5, "s", True, "two words", "7", "yes", ""]
        a.params["/ns/dict"] = {"a": 1, "b": {"c": "x", "empty": {}, "none": []}, "f": 1e-7}
        yield master.uri


def run_ours(words: list[str], master_uri: str) -> subprocess.CompletedProcess[str]:
    """The `rosproto` command in a process of its own."""
    return subprocess.run(
        [sys.executable, "-m", "rosproto", *words],
        env=ros.environment(master_uri),
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


SAME = [
    ("rostopic list", "topic list"),
    ("rostopic list /cmd", "topic list /cmd"),
    ("rostopic list -v", "topic list -v"),
    ("rostopic info /cmd", "topic info /cmd"),
    ("rostopic type /cmd", "topic type /cmd"),
    ("rostopic type /cmd/linear/x", "topic type /cmd/linear/x"),
    ("rostopic find geometry_msgs/Twist", "topic find geometry_msgs/Twist"),
    ("rostopic echo -n 1 /cmd", "topic echo -n 1 /cmd"),
    ("rostopic echo -n 1 /cmd/linear", "topic echo -n 1 /cmd/linear"),
    ("rostopic echo -n 1 /cmd/linear/x", "topic echo -n 1 /cmd/linear/x"),
    ("rosnode list", "node list"),
    ("rosnode list -a", "node list -a"),
    ("rosnode info /a", "node info /a"),
    ("rosnode info /ns/b", "node info /ns/b"),
    ("rosnode machine", "node machine"),
    ("rosservice list", "service list"),
    ("rosservice list -n", "service list -n"),
    ("rosservice type /set", "service type /set"),
    ("rosservice uri /set", "service uri /set"),
    ("rosparam list", "param list"),
    ("rosparam list /ns", "param list /ns"),
    ("rosparam get /x", "param get /x"),
    ("rosparam get /ns", "param get /ns"),
    ("rosparam get /ns/list", "param get /ns/list"),
    ("rosparam get /ns/dict/b/c", "param get /ns/dict/b/c"),
    ("rosmsg show sensor_msgs/LaserScan", "msg show sensor_msgs/LaserScan"),
    ("rosmsg show Pose", "msg show Pose"),
    ("rosmsg show actionlib_msgs/GoalStatus", "msg show actionlib_msgs/GoalStatus"),
    ("rosmsg md5 geometry_msgs/Pose", "msg md5 geometry_msgs/Pose"),
    ("rosmsg package geometry_msgs", "msg package geometry_msgs"),
    ("rossrv show std_srvs/SetBool", "srv show std_srvs/SetBool"),
    ("rossrv package std_srvs", "srv package std_srvs"),
]


@pytest.mark.parametrize(("theirs", "ours"), SAME, ids=[ours for _, ours in SAME])
def test_same_text(ros_installed: None, graph: str, theirs: str, ours: str) -> None:
    """Programs that read ROS's tools can read ours."""
    expected = ros.ros_tool(theirs.split(), graph)
    found = run_ours(ours.split(), graph)
    assert expected.returncode == 0, expected.stderr
    assert found.returncode == 0, found.stderr
    # rosparam ends blocks with one empty line more
    assert found.stdout.rstrip() == expected.stdout.rstrip()


@pytest.mark.parametrize(
    ("theirs", "ours"),
    [
        ("rostopic type /nope", "topic type /nope"),
        ("rosnode info /nope", "node info /nope"),
        ("rosparam get /nope", "param get /nope"),
        ("rosmsg show std_msgs/Nope", "msg show std_msgs/Nope"),
        ("rosservice type /nope", "service type /nope"),
    ],
)
def test_what_is_not_there_is_an_error_in_both(
    ros_installed: None, graph: str, theirs: str, ours: str
) -> None:
    """A name that nobody knows is one sentence on stderr and a non-zero exit code; never a traceback."""
    found = run_ours(ours.split(), graph)
    assert found.returncode == 1
    assert found.stderr.count("\n") == 1
    assert found.stderr.startswith("rosproto ")


def test_what_we_publish_rostopic_echoes(ros_installed: None, our_master: Master) -> None:
    """`rosproto topic pub` beside `rostopic echo`."""
    echo = ros.start_tool(["rostopic", "echo", "-n", "1", "/say"], our_master.uri)
    with echo:
        found = run_ours(["topic", "pub", "-1", "/say", "std_msgs/String", "hello"], our_master.uri)
        assert found.returncode == 0, found.stderr
        echo.wait_for('data: "hello"', timeout=20)


def test_a_parameter_we_set_rosparam_gets(ros_installed: None, our_master: Master) -> None:
    """Types survive: numbers, text, lists, dicts."""
    for value, text in [
        ("5", "5"),
        ("[1, 2.5]", "- 1\n- 2.5"),
        ("{a: {b: yes}}", "a:\n  b: true"),
        ("'5'", "'5'"),
    ]:
        assert run_ours(["param", "set", "/p", value], our_master.uri).returncode == 0
        assert ros.ros_tool(["rosparam", "get", "/p"], our_master.uri).stdout.strip() == text
