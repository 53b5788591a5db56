"""ROS's own tools, rospy and roscpp nodes run unmodified on our master (and, as a check of the test, on Debian's)."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from rosproto.master import Master
from rosproto.node.graph.master_client import MasterClient
from tests.support import ros

TALKER = """
import rospy, sys
from std_msgs.msg import String
rospy.init_node(sys.argv[1])
pub = rospy.Publisher("chatter", String, queue_size=10)
rate = rospy.Rate(20)
while not rospy.is_shutdown():
    pub.publish("hello from " + sys.argv[1])
    rate.sleep()
"""

LISTENER = """
import rospy
from std_msgs.msg import String
rospy.init_node("listener")
rospy.Subscriber("chatter", String, lambda m: print("heard", m.data, flush=True))
print("listening", flush=True)
rospy.spin()
"""

SERVER = """
import rospy
from std_srvs.srv import SetBool, SetBoolResponse
rospy.init_node("server")
rospy.Service("/switch", SetBool, lambda request: SetBoolResponse(request.data, "switched"))
print("serving", flush=True)
rospy.spin()
"""


def client(uri: str) -> MasterClient:
    return MasterClient(uri, "/test")


def test_talker_and_listener_find_each_other_in_either_order(any_master: str) -> None:
    """Listener first, then talker; a second talker joins, and the first one leaves in order."""
    with ros.start_rospy(LISTENER, any_master) as listener:
        listener.wait_for("^listening")
        with ros.start_rospy(TALKER, any_master, "one") as one:
            listener.wait_for("heard hello from one")
            with ros.start_rospy(TALKER, any_master, "two"):
                listener.wait_for("heard hello from two")
                one.interrupt()
                one.wait()
                with client(any_master) as me:
                    assert me.get_system_state().publishers["/chatter"] == ["/two"]
    with client(any_master) as me:
        state = me.get_system_state()
        assert "/chatter" not in state.publishers
        assert state.nodes == []


def test_a_second_node_of_the_same_name_ends_the_first(any_master: str) -> None:
    """rospy's own rule, carried by the master's shutdown call."""
    with (
        ros.start_rospy(TALKER, any_master, "same") as first,
        ros.start_rospy(LISTENER, any_master) as listener,
    ):
        listener.wait_for("heard")
        with ros.start_rospy(TALKER, any_master, "same") as second:
            first.wait(60)
            assert "new node registered with same name" in first.output
            assert second.running, second.output


FIXED_PORT = """
import rospy, sys
rospy.init_node(sys.argv[1], xmlrpc_port=int(sys.argv[2]))
print("up", flush=True)
rospy.spin()
"""


def test_an_innocent_node_on_a_dead_nodes_port_lives_on(our_master: Master) -> None:
    """/old dies, /innocent (of another master) gets its port, /old comes back elsewhere (ros_comm#2241)."""
    port, other_port = str(ros.free_port()), str(ros.free_port())
    with Master() as other_master, client(our_master.uri) as me:
        with ros.start_rospy(FIXED_PORT, our_master.uri, "old", port) as old:
            old.wait_for("up")
            old.kill()
        with ros.start_rospy(FIXED_PORT, other_master.uri, "innocent", port) as innocent:
            innocent.wait_for("up")
            assert me.lookup_node("/old").endswith(f":{port}/")
            with ros.start_rospy(FIXED_PORT, our_master.uri, "old", other_port) as again:
                again.wait_for("up")
                assert our_master.flush()
                assert me.lookup_node("/old").endswith(f":{other_port}/")
                ping = ros.ros_tool(["rosnode", "ping", "-c1", "/innocent"], other_master.uri)
                assert "xmlrpc reply" in ping.stdout
                assert "shutdown" not in innocent.output


def test_a_roscpp_node_works_and_can_be_replaced(
    any_master: str, roscpp_peer: Path, request: pytest.FixtureRequest
) -> None:
    """Topics both ways, parameters and cached parameters, then a second node of its name."""
    is_ours = request.node.callspec.params["any_master"] == "ours"
    with client(any_master) as me, ros.start_program(roscpp_peer, any_master, "cpp_node") as node:
        node.wait_for("^cpp up")
        with ros.start_rospy(TALKER, any_master, "talker"):
            node.wait_for("cpp heard hello from talker")
        assert me.get_param("/cpp/set") == 42
        me.set_param("/cpp/watched", "seen")
        node.wait_for("cpp param seen")
        echo = ros.ros_tool(["rostopic", "echo", "-n1", "/cpp_chatter"], any_master)
        assert "latched by cpp" in echo.stdout
        with ros.start_program(roscpp_peer, any_master, "cpp_node") as second:
            node.wait_for("cpp down")
            # The first one's last log line makes rosmaster end the second as well (registry.py); ours does not.
            if is_ours:
                second.wait_for("cpp up")
                me.set_param("/cpp/watched", "by the second")
                second.wait_for("cpp param by the second")
                assert second.running


def test_rosnode(any_master: str) -> None:
    """list, info, ping, kill."""
    with ros.start_rospy(TALKER, any_master, "talker"), ros.start_rospy(LISTENER, any_master) as listener:
        listener.wait_for("heard")
        assert ros.ros_tool(["rosnode", "list"], any_master).stdout.split() == ["/listener", "/talker"]
        info = ros.ros_tool(["rosnode", "info", "/talker"], any_master).stdout
        assert "* /chatter [std_msgs/String]" in info
        assert "to: /listener" in info
        assert "xmlrpc reply" in ros.ros_tool(["rosnode", "ping", "-c1", "/talker"], any_master).stdout
        assert "killed" in ros.ros_tool(["rosnode", "kill", "/listener"], any_master).stdout
        listener.wait()
        assert ros.ros_tool(["rosnode", "list"], any_master).stdout.split() == ["/talker"]


def test_rosnode_cleanup(any_master: str) -> None:
    """What a killed node left behind is unregistered by the tool."""
    with ros.start_rospy(TALKER, any_master, "talker") as talker, client(any_master) as me:
        with ros.start_rospy(LISTENER, any_master) as listener:
            listener.wait_for("heard")
        talker.kill()
        assert me.get_system_state().nodes == ["/talker"]
        code = "import io, rosnode, sys; sys.stdin = io.StringIO('y\\n'); rosnode.rosnodemain(['rosnode', 'cleanup'])"
        ros.run_rospy(code, any_master)
        assert me.get_system_state().nodes == []


def test_rostopic(any_master: str) -> None:
    """list, info, type, find, echo, hz, pub."""
    with ros.start_rospy(TALKER, any_master, "talker"), ros.start_rospy(LISTENER, any_master) as listener:
        listener.wait_for("heard")

        def rostopic(*words: str) -> str:
            return ros.ros_tool(["rostopic", *words], any_master).stdout

        assert rostopic("list").split() == ["/chatter", "/rosout"]
        assert "Publishers: \n * /talker" in rostopic("info", "/chatter")
        assert rostopic("type", "/chatter").strip() == "std_msgs/String"
        assert rostopic("find", "std_msgs/String").strip() == "/chatter"
        assert "hello from talker" in rostopic("echo", "-n1", "/chatter")
        with ros.start_tool(["rostopic", "hz", "/chatter"], any_master) as hz:
            rate = float(hz.wait_for(r"average rate: ([0-9.]+)").group(1))
            assert rate > 0  # how fast: test_cli_rates
        with ros.start_tool(
            ["rostopic", "pub", "-r10", "/chatter", "std_msgs/String", "from pub"], any_master
        ):
            listener.wait_for("heard from pub")


def test_rosservice(any_master: str, genpy_packages: Path) -> None:
    """list, info, type, uri, call; and gone with its node."""
    with ros.start_rospy(SERVER, any_master, packages=genpy_packages) as server:
        server.wait_for("^serving")

        def rosservice(*words: str) -> str:
            return ros.ros_tool(["rosservice", *words], any_master, packages=genpy_packages).stdout

        assert "/switch" in rosservice("list").split()
        assert "Node: /server" in rosservice("info", "/switch")
        assert rosservice("type", "/switch").strip() == "std_srvs/SetBool"
        assert rosservice("uri", "/switch").startswith("rosrpc://127.0.0.1:")
        assert 'message: "switched"' in rosservice("call", "/switch", "true")
    with client(any_master) as me:
        assert me.get_system_state().services == {}


def test_rosparam(any_master: str, tmp_path: Path) -> None:
    """set, get, list, delete, dump, load."""

    def rosparam(*words: str) -> str:
        return ros.ros_tool(["rosparam", *words], any_master).stdout

    rosparam("set", "/robot/speed", "0.5")
    rosparam("set", "/robot/gains", "{p: 1, i: [2, 3.5], name: text, flag: true}")
    assert float(rosparam("get", "/robot/speed")) == 0.5
    listed = set(rosparam("list").split())
    assert {"/robot/speed", "/robot/gains/p", "/robot/gains/name"} <= listed
    rosparam("dump", str(tmp_path / "dump.yaml"), "/robot")
    rosparam("delete", "/robot/gains")
    assert "/robot/gains/p" not in rosparam("list")
    rosparam("load", str(tmp_path / "dump.yaml"), "/copy")
    with client(any_master) as me:
        assert me.get_param("/copy") == {
            "speed": 0.5,
            "gains": {"p": 1, "i": [2, 3.5], "name": "text", "flag": True},
        }
        assert me.get_param("/robot") == {"speed": 0.5}


def test_rospy_sees_parameters_change(any_master: str) -> None:
    """get_param_cached subscribes at the master: the cache follows."""
    code = """
import rospy, time
rospy.init_node("watcher")
def read():
    try: return rospy.client.get_param_cached("/watched")
    except KeyError: return None
old = object()
while not rospy.is_shutdown():
    new = read()
    if new != old: print("watched", new, flush=True); old = new
    time.sleep(0.02)
"""
    with client(any_master) as me, ros.start_rospy(code, any_master) as watcher:
        watcher.wait_for("watched None")
        me.set_param("/watched", 1)
        watcher.wait_for("watched 1")
        me.set_param("/watched", {"deep": "value"})
        watcher.wait_for("watched .*deep.*value")


@pytest.mark.promise("roslaunch refuses a master without `/run_id`")
def test_roslaunch_takes_the_master(any_master: str, tmp_path: Path) -> None:
    """It checks /run_id, sets parameters, starts a node, and cleans up."""
    script = tmp_path / "talker.py"
    script.write_text(f"#!{ros.PYTHON}\n{TALKER}")
    script.chmod(0o755)
    launch = ElementTree.Element("launch")
    ElementTree.SubElement(launch, "param", name="/launched/x", value="5", type="int")
    file = tmp_path / "test.launch"
    ElementTree.ElementTree(launch).write(file)
    with (
        client(any_master) as me,
        ros.start_tool(["roslaunch", "--wait", "--no-summary", str(file)], any_master) as launcher,
    ):
        launcher.wait()
        output = launcher.output
        assert me.get_param("/launched/x") == 5, output
        assert re.search(r"ROS_MASTER_URI=" + re.escape(any_master.rstrip("/")), output), output
        assert any(key.startswith("/roslaunch/uris/") for key in me.get_param_names()) or "process" in output


def test_roslaunch_refuses_another_run_id(our_master: Master, tmp_path: Path) -> None:
    """The check that needs /run_id is really made against our master."""
    file = tmp_path / "empty.launch"
    file.write_text("<launch><param name='/x' value='1'/></launch>")
    done = ros.ros_tool(
        ["roslaunch", "--wait", "--run_id", "not-yours", str(file)], our_master.uri, check=False
    )
    assert done.returncode != 0
    assert "run_id on parameter server does not match" in done.stdout + done.stderr


def test_rosout_aggregates_on_our_master(any_master: str) -> None:
    """roscore's C++ logger node subscribes /rosout and publishes /rosout_agg."""
    program = Path("/usr/lib/rosout/rosout")
    ros.require(program.exists(), f"there is no {program}")
    code = """
import rospy
rospy.init_node("logger")
while not rospy.is_shutdown():
    rospy.loginfo("a line for everybody"); rospy.sleep(0.1)
"""
    with (
        ros.start_program(program, any_master),
        ros.start_rospy(code, any_master),
        ros.start_tool(["rostopic", "echo", "/rosout_agg/msg"], any_master) as echo,
    ):
        echo.wait_for("a line for everybody")
