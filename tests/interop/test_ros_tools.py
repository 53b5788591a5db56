"""ROS's own command line tools, unchanged, against our node, on our master and on Debian's."""

from __future__ import annotations

import re
import threading
from collections.abc import Iterator

import pytest

from rosproto.codec import message_class
from rosproto.node import Node
from tests.support import ros

String = message_class("std_msgs/String")


@pytest.fixture
def node(any_master: str) -> Iterator[Node]:
    with Node("/our_node", master_uri=any_master) as ours:
        yield ours


@pytest.fixture
def tool(any_master: str, genpy_packages):
    """Output of a tool that ends by itself."""
    return lambda *arguments: ros.ros_tool(arguments, any_master, packages=genpy_packages).stdout


class Ticker:
    """Publishes as fast as asked, until the end of the block."""

    def __init__(self, publisher, make, seconds: float) -> None:
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, args=(publisher, make, seconds), daemon=True)

    def _run(self, publisher, make, seconds: float) -> None:
        while not self._stop.wait(seconds):
            publisher.publish(make())

    def __enter__(self) -> Ticker:
        self._thread.start()
        return self

    def __exit__(self, *exc_info: object) -> None:
        self._stop.set()
        self._thread.join(5)


def test_rosnode(node, tool):
    node.publisher("/chatter", String)
    node.subscriber("/orders", String, callback=print)
    node.service_server("~trigger", "std_srvs/Trigger", lambda request: (True, ""))
    assert "/our_node" in tool("rosnode", "list").split()
    assert "/our_node" in tool("rosnode", "list", "-a")
    info = tool("rosnode", "info", "/our_node")
    assert "* /chatter [std_msgs/String]" in info
    assert "* /orders [" in info
    assert "* /our_node/trigger" in info
    assert f"contacting node {node.uri}" in info
    assert "cannot" not in info.lower()
    ping = tool("rosnode", "ping", "-c", "2", "/our_node")
    assert ping.count("xmlrpc reply from") == 2
    assert "/our_node" in tool("rosnode", "machine", "127.0.0.1")


def test_what_was_registered_in_one_request_is_all_there(node, tool):
    """On both masters: topics, services, and the links that follow from them."""
    with node.batch():
        publishers = [node.publisher(f"/many/{number}", String) for number in range(12)]
        node.subscriber("/orders", String, callback=print)
        node.service_server("~trigger", "std_srvs/Trigger", lambda request: (True, ""))
    assert not node.master._one_by_one  # neither lacks system.multicall
    info = tool("rosnode", "info", "/our_node")
    assert all(f"* /many/{number} [std_msgs/String]" in info for number in range(12))
    assert "* /orders [" in info
    assert "* /our_node/trigger" in info
    with Node("/hears", master_uri=node.master_uri, intraprocess=False) as hears:
        with hears.batch():
            heard = [hears.subscriber(f"/many/{number}", String) for number in range(12)]
        for publisher in publishers:
            publisher.wait_for_connection(60)
            publisher.publish(data=publisher.topic)
        assert [subscriber.next(timeout=60).data for subscriber in heard] == [p.topic for p in publishers]


def test_rosnode_info_shows_a_link_between_our_nodes(node, tool, any_master):
    with Node("/other", master_uri=any_master, intraprocess=False) as other:
        publisher = node.publisher("/chatter", String)
        other.subscriber("/chatter", String, callback=print)
        publisher.wait_for_connection(60)
        info = tool("rosnode", "info", "/our_node")
        assert re.search(
            r"topic: /chatter\s+\* to: /other\s+\* direction: outbound.*\s+\* transport: TCPROS", info
        ), info


def test_rosnode_kill_ends_our_node(any_master, tool):
    with Node("/victim", master_uri=any_master) as victim:
        assert "killed" in tool("rosnode", "kill", "/victim")
        assert victim.wait(60)


def test_rosservice(node, tool, genpy_packages):
    said = []

    def handler(request):
        said.append(request.data)
        if not request.data:
            raise ValueError("only upwards")
        return True, "lifted"

    node.service_server("/lift", "std_srvs/SetBool", handler)
    assert "/lift" in tool("rosservice", "list").split()
    assert tool("rosservice", "type", "/lift").strip() == "std_srvs/SetBool"
    assert tool("rosservice", "args", "/lift").strip() == "data"
    assert tool("rosservice", "node", "/lift").strip() == "/our_node"
    assert tool("rosservice", "find", "std_srvs/SetBool").split() == ["/lift"]
    info = tool("rosservice", "info", "/lift")
    assert "Type: std_srvs/SetBool" in info
    assert re.search(r"URI: rosrpc://\S+:\d+", info)
    assert "lifted" in tool("rosservice", "call", "/lift", "true")
    assert said == [True]
    failed = ros.ros_tool(
        ["rosservice", "call", "/lift", "data: false"], node.master_uri, packages=genpy_packages, check=False
    )
    assert failed.returncode != 0
    assert "only upwards" in failed.stdout + failed.stderr


def test_the_log_level_services_work_from_rosservice(node, tool):
    assert {"/our_node/get_loggers", "/our_node/set_logger_level"} <= set(tool("rosservice", "list").split())
    assert "rosproto.node" in tool("rosservice", "call", "/our_node/get_loggers")
    tool("rosservice", "call", "/our_node/set_logger_level", "rosproto.node", "warn")
    assert re.search(r'rosproto.node"\s+level: "warn"', tool("rosservice", "call", "/our_node/get_loggers"))


def test_rostopic_reads_what_we_publish(node, tool, any_master, genpy_packages):
    publisher = node.publisher("/chatter", String)
    assert "/chatter" in tool("rostopic", "list").split()
    assert tool("rostopic", "type", "/chatter").strip() == "std_msgs/String"
    assert "/chatter" in tool("rostopic", "find", "std_msgs/String").split()
    assert f"* /our_node ({node.uri})" in tool("rostopic", "info", "/chatter")
    with Ticker(publisher, lambda: String(data="Größe"), 0.02):
        assert "data: " in tool("rostopic", "echo", "-n", "3", "/chatter")
        with ros.start_tool(["rostopic", "hz", "/chatter"], any_master, packages=genpy_packages) as hz:
            rate = float(hz.wait_for(r"average rate: ([0-9.]+)").group(1))
            assert rate > 0
        with ros.start_tool(["rostopic", "bw", "/chatter"], any_master, packages=genpy_packages) as bw:
            bw.wait_for(r"average: ")


def test_a_late_rostopic_echo_gets_our_latched_message(node, tool):
    publisher = node.publisher("/state", "std_msgs/Int32", latch=True)
    publisher.publish(data=42)
    assert "data: 42" in tool("rostopic", "echo", "-n", "1", "/state")


def test_rostopic_pub_reaches_us(node, tool, any_master, genpy_packages):
    subscriber = node.subscriber("/cmd", "geometry_msgs/Twist")
    with ros.start_tool(
        [
            "rostopic",
            "pub",
            "-r",
            "20",
            "/cmd",
            "geometry_msgs/Twist",
            "{linear: {x: 0.25}, angular: {z: -1}}",
        ],
        any_master,
        packages=genpy_packages,
    ):
        message = subscriber.next(timeout=60)
    assert (message.linear.x, message.angular.z) == (0.25, -1.0)
    tool("rostopic", "pub", "-1", "/cmd", "geometry_msgs/Twist", "{linear: {x: 0.5}}")
    assert any(subscriber.next(timeout=60).linear.x == 0.5 for _ in range(1000))


def test_rosparam(node, tool):
    tool("rosparam", "set", "/our_node/speed", "0.75")
    assert node.params["~speed"] == 0.75
    node.params["~name"] = "bot"
    assert tool("rosparam", "get", "/our_node/name").strip() == "bot"
    assert "/our_node/name" in tool("rosparam", "list").split()
    tool("rosparam", "delete", "/our_node/name")
    assert "~name" not in node.params
