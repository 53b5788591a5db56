"""`rosproto topic|node|service|param|msg|srv` beside rostopic, rosnode, rosservice, rosparam and rosmsg.

One graph, both tools, the same words: what they print must be the same text.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from msgdefs.geometry_msgs.msg import Point, Pose
from msgdefs.std_msgs.msg import Float64, Header, String
from rosproto import BagWriter, Master, Node
from rosproto.time import Time
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
        publisher.wait_for_connection(timeout=60)
        publisher.publish(publisher.message_class())
        a.publisher("/marks", "geometry_msgs/PoseArray", latch=True).publish(
            header=Header(stamp=Time(12, 34), frame_id="map"),
            poses=[Pose(), Pose(position=Point(1.5, -2.0, 0.25))],
        )
        a.publisher("/array", "std_msgs/Float32MultiArray", latch=True).publish(data=[1.0, 2.5, 0.1])
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
        timeout=300,
        check=False,
    )


SAME = [
    ("rostopic list", "topic list"),
    ("rostopic list /cmd", "topic list /cmd"),
    ("rostopic list -v", "topic list -v"),
    ("rostopic list -p", "topic list -p"),
    ("rostopic list -s", "topic list -s"),
    ("rostopic list -v -p", "topic list -v -p"),
    ("rostopic list --host", "topic list --host"),
    ("rostopic list -b {bag} /t", "topic list -b {bag} /t"),
    ("rostopic list -b {bag}", "topic list -b {bag}"),
    ("rostopic info /cmd", "topic info /cmd"),
    ("rostopic type /cmd", "topic type /cmd"),
    ("rostopic type /cmd/linear/x", "topic type /cmd/linear/x"),
    ("rostopic find geometry_msgs/Twist", "topic find geometry_msgs/Twist"),
    ("rostopic find geometry_msgs/Pose", "topic find geometry_msgs/Pose"),
    ("rostopic echo -n 1 /cmd", "topic echo -n 1 /cmd"),
    ("rostopic echo -n 1 /cmd/linear", "topic echo -n 1 /cmd/linear"),
    ("rostopic echo -n 1 /cmd/linear/x", "topic echo -n 1 /cmd/linear/x"),
    ("rostopic echo -n 1 -w 6 /cmd", "topic echo -n 1 -w 6 /cmd"),
    ("rostopic echo -n 1 /marks", "topic echo -n 1 /marks"),
    ("rostopic echo -n 1 -w 5 /marks", "topic echo -n 1 -w 5 /marks"),
    ("rostopic echo -n 1 -p /marks", "topic echo -n 1 -p /marks"),
    ("rostopic echo -n 1 --noarr /marks", "topic echo -n 1 --noarr /marks"),
    ("rostopic echo -n 1 --nostr /marks", "topic echo -n 1 --nostr /marks"),
    ("rostopic echo -n 1 --noarr --nostr /marks", "topic echo -n 1 --noarr --nostr /marks"),
    ("rostopic echo -n 1 /marks/poses[0]/position", "topic echo -n 1 /marks/poses[0]/position"),
    ("rostopic echo -n 1 /marks/header", "topic echo -n 1 /marks/header"),
    ("rostopic echo -n 1 /marks/header/stamp", "topic echo -n 1 /marks/header/stamp"),
    ("rostopic echo -n 1 /array/data", "topic echo -n 1 /array/data"),
    ("rostopic echo -n 1 /array/data[1]", "topic echo -n 1 /array/data[1]"),
    ("rostopic echo -n 1 /array/data[0:2]", "topic echo -n 1 /array/data[0:2]"),
    ("rostopic echo -b {bag} /t", "topic echo -b {bag} /t"),
    ("rostopic echo -b {bag} -n 2 /t", "topic echo -b {bag} -n 2 /t"),
    ("rostopic echo -b {bag} -p /t", "topic echo -b {bag} -p /t"),
    ("rostopic echo -b {bag} -a /", "topic echo -b {bag} -a /"),
    ("rostopic echo -b {bag} --filter str(m.data)>'1' /u", "topic echo -b {bag} --filter str(m.data)>'1' /u"),
    ("rosnode list", "node list"),
    ("rosnode list -a", "node list -a"),
    ("rosnode list -u", "node list -u"),
    ("rosnode info /a", "node info /a"),
    ("rosnode info /ns/b", "node info /ns/b"),
    ("rosnode machine", "node machine"),
    ("rosnode machine 127.0.0.1", "node machine 127.0.0.1"),
    ("rosservice list", "service list"),
    ("rosservice list -n", "service list -n"),
    ("rosservice list /set", "service list /set"),
    ("rosservice type /set", "service type /set"),
    ("rosservice find roscpp/GetLoggers", "service find roscpp/GetLoggers"),
    ("rosservice uri /set", "service uri /set"),
    ("rosservice args /a/set_logger_level", "service args /a/set_logger_level"),
    ("rosservice info /a/set_logger_level", "service info /a/set_logger_level"),
    ("rosservice call /a/get_loggers", "service call /a/get_loggers"),
    (
        "rosservice call /a/set_logger_level {{logger:\\x20root,\\x20level:\\x20info}}",
        "service call /a/set_logger_level {{logger:\\x20root,\\x20level:\\x20info}}",
    ),
    (
        "rosservice call --wait /a/set_logger_level root warn",
        "service call --wait /a/set_logger_level root warn",
    ),
    ("rosparam list", "param list"),
    ("rosparam list /ns", "param list /ns"),
    ("rosparam get /x", "param get /x"),
    ("rosparam get /ns", "param get /ns"),
    ("rosparam get -p /ns/dict", "param get -p /ns/dict"),
    ("rosparam get /ns/list", "param get /ns/list"),
    ("rosparam get /ns/dict/b/c", "param get /ns/dict/b/c"),
    ("rosparam dump /dev/stdout /ns", "param dump /dev/stdout /ns"),
    ("rosmsg show sensor_msgs/LaserScan", "msg show sensor_msgs/LaserScan"),
    ("rosmsg show Pose", "msg show Pose"),
    ("rosmsg info std_msgs/Header", "msg info std_msgs/Header"),
    ("rosmsg show -b {bag} std_msgs/String", "msg show -b {bag} std_msgs/String"),
    ("rosmsg show actionlib_msgs/GoalStatus", "msg show actionlib_msgs/GoalStatus"),
    ("rosmsg md5 geometry_msgs/Pose", "msg md5 geometry_msgs/Pose"),
    ("rosmsg package geometry_msgs", "msg package geometry_msgs"),
    ("rosmsg package -s std_msgs", "msg package -s std_msgs"),
    ("rossrv show std_srvs/SetBool", "srv show std_srvs/SetBool"),
    ("rossrv show -r roscpp/SetLoggerLevel", "srv show -r roscpp/SetLoggerLevel"),
    ("rossrv md5 roscpp/GetLoggers", "srv md5 roscpp/GetLoggers"),
    ("rossrv package std_srvs", "srv package std_srvs"),
    ("rossrv package -s nav_msgs", "srv package -s nav_msgs"),
]


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A bag of two topics."""
    path = tmp_path_factory.mktemp("bag") / "t.bag"
    with BagWriter(path) as writer:
        for number in range(3):
            writer.write("/t", String(data=f"word {number}"), Time(10 + number, 5))
            writer.write("/u", Float64(data=float(number)), Time(10 + number, 6))
    return path


BLANK_LINES = ("rosparam", "rossrv show -r", "rostopic find geometry_msgs/Pose")
"""These end with one empty line more or less than ours; all else is the same to the last character."""


def _words(line: str, bag: Path) -> list[str]:
    """`\\x20` is a blank inside a word."""
    return [word.replace("\\x20", " ") for word in line.format(bag=bag).split()]


@pytest.mark.parametrize(("theirs", "ours"), SAME, ids=[ours for _, ours in SAME])
def test_same_text(ros_installed: None, graph: str, bag: Path, theirs: str, ours: str) -> None:
    """Programs that read ROS's tools can read ours."""
    expected = ros.ros_tool(_words(theirs, bag), graph)
    found = run_ours(_words(ours, bag), graph)
    assert expected.returncode == 0, expected.stderr
    assert found.returncode == 0, found.stderr
    if theirs.startswith(BLANK_LINES):
        assert found.stdout.rstrip() == expected.stdout.rstrip()
    else:
        assert found.stdout == expected.stdout


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
    """`rosproto topic pub` beside `rostopic echo`, latched until its end; with -1 it ends after three seconds."""
    pub = [sys.executable, "-m", "rosproto", "topic", "pub", "/say", "std_msgs/String", "hello"]
    with (
        ros.start_tool(["rostopic", "echo", "-n", "1", "/say"], our_master.uri) as echo,
        ros.RosProcess(pub, ros.environment(our_master.uri)),
    ):
        echo.wait_for('data: "hello"')
    with (
        Node("/ours", master_uri=our_master.uri) as node,
        node.subscriber("/once", "std_msgs/String") as heard,
    ):
        assert (
            run_ours(["topic", "pub", "-1", "/once", "std_msgs/String", "bye"], our_master.uri).returncode
            == 0
        )
        assert heard.next(60).data == "bye"


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
