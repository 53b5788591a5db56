"""Checks of a master and nodes: two of this process, and one beside real ROS 1, where it is installed."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from rosproto.errors import RosError, RosTimeout
from rosproto.selftest.checking import CheckFailed, NotApplicable, expect
from rosproto.sentence import say

if TYPE_CHECKING:
    from rosproto.action import ServerGoal
    from rosproto.codec import DynamicMessage
    from rosproto.node import Node, Subscriber

_WAIT = 5.0  # seconds for each step: on one machine each takes milliseconds


def check_master() -> str:
    """Call a master over HTTP, as other programs do."""
    from rosproto.master import Master
    from rosproto.node import MasterClient

    with Master(host="127.0.0.1", port=0) as master, MasterClient(master.uri, "/selftest") as client:
        client.set_param("/selftest", [1, 2.5, "三"])
        expect("a parameter", client.get_param("/selftest"), [1, 2.5, "三"])
        client.register_publisher("/selftest", "std_msgs/String", "http://127.0.0.1:1/")
        expect("the topics", client.get_topic_types(), {"/selftest": "std_msgs/String"})
        return say("it answered at {uri}", uri=master.uri)


def check_nodes() -> str:
    """Let two nodes of this process communicate over real sockets."""
    from rosproto.master import Master
    from rosproto.node import Node

    with (
        Master(host="127.0.0.1", port=0) as master,
        Node("/selftest_a", master_uri=master.uri, host="127.0.0.1", rosout=False) as one,
        Node("/selftest_b", master_uri=master.uri, host="127.0.0.1", rosout=False) as other,
    ):
        _topic(one, other)
        _service(one, other)
        one.params["/selftest/number"] = 42
        expect("a parameter", other.params["/selftest/number"], 42)
        _action(one, other)
    return "a topic, a service, a parameter and an action between two nodes"


def _topic(one: Node, other: Node) -> None:
    image = bytes(range(256)) * 4096  # 1 MiB: more than a socket takes at once
    with (
        other.subscriber("/selftest/data", "std_msgs/UInt8MultiArray") as messages,
        one.publisher("/selftest/data", "std_msgs/UInt8MultiArray", queue_size=2) as publisher,
    ):
        publisher.wait_for_connection(timeout=_WAIT)
        publisher.publish(data=image)
        late = say("a message did not arrive within {seconds:g} s", seconds=_WAIT)
        heard = bytes(_next(messages, _WAIT, late).data)
    expect("a message of 1 MiB", len(heard), len(image))
    expect("the message's bytes", heard == image, True)


def _next(messages: Subscriber, seconds: float, late: str) -> DynamicMessage:
    try:
        heard: DynamicMessage = messages.next(timeout=seconds)
    except RosTimeout as error:
        raise CheckFailed(late) from error
    return heard


def _service(one: Node, other: Node) -> None:
    def answer(request: DynamicMessage) -> dict[str, object]:
        return {"success": request.data, "message": "好"}

    with (
        one.service_server("/selftest/set", "std_srvs/SetBool", answer),
        other.service_client("/selftest/set", "std_srvs/SetBool") as client,
    ):
        reply = client.call(data=True, timeout=_WAIT)
    expect("a service's answer", (reply.success, reply.message), (True, "好"))


def _action(one: Node, other: Node) -> None:
    from rosproto.action import ActionClient, ActionServer

    def work(goal: ServerGoal) -> None:
        goal.succeed({"result": goal.goal.goal * 2})

    with (
        ActionServer(one, "/selftest/work", "actionlib/TestAction", work),
        ActionClient(other, "/selftest/work", "actionlib/TestAction") as client,
    ):
        client.wait_for_server(timeout=_WAIT)
        handle = client.send_goal({"goal": 21})
        expect("an action's result", handle.wait(timeout=_WAIT).result, 42)


_PATIENCE = 12.0  # seconds: `import rospy` takes 1, on a busy machine 10
_PROGRAM = """
import rospy
from std_msgs.msg import String
rospy.init_node("selftest_rospy", disable_signals=True)
back = rospy.Publisher("/selftest/from_ros", String, queue_size=1, latch=True)
rospy.Subscriber("/selftest/to_ros", String, lambda m: back.publish("rospy heard " + m.data))
rospy.spin()
"""


def find_ros() -> tuple[str, dict[str, str]] | None:
    """Return a Python that has rospy and the environment it needs; None if there is none.

    Debian's packages are found, and Ubuntu's under /opt/ros.
    """
    if sys.platform == "win32":  # `python3` there may be a link to the Microsoft Store
        return None
    for python in dict.fromkeys(filter(None, ("/usr/bin/python3", shutil.which("python3")))):
        for environment in _environments():
            if _has_rospy(python, environment):
                return python, environment
    return None


def _environments() -> Iterator[dict[str, str]]:
    kept = ("PATH", "HOME", "LANG", "LC_ALL", "TMPDIR", "LD_LIBRARY_PATH", "ROS_HOME", "ROS_LOG_DIR")
    plain = {name: os.environ[name] for name in kept if name in os.environ}
    yield plain
    for folder in sorted(Path("/opt/ros").glob("*/lib/python3/dist-packages")):
        root = folder.parents[2]
        yield {**plain, "PYTHONPATH": str(folder), "ROS_PACKAGE_PATH": str(root / "share")}


def _has_rospy(python: str, environment: dict[str, str]) -> bool:
    command = [python, "-c", "import rospy, std_msgs.msg"]
    try:
        done = subprocess.run(
            command, env=environment, capture_output=True, timeout=_PATIENCE, check=False, cwd=os.sep
        )
    except (OSError, subprocess.TimeoutExpired):
        return False
    return done.returncode == 0


def check_ros() -> str:
    """Exchange a topic in both directions and call a service."""
    found = find_ros()
    if found is None:
        raise NotApplicable("no rospy is installed on this machine; everything else works without it")
    from rosproto.master import Master

    python, environment = found
    with Master(host="127.0.0.1", port=0) as master:
        environment |= {"ROS_MASTER_URI": master.uri, "ROS_IP": "127.0.0.1"}
        with subprocess.Popen(
            [python, "-c", _PROGRAM], env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE, cwd=os.sep,
        ) as process:  # fmt: skip
            try:
                _talk(master.uri, process)
            finally:
                process.kill()
    return say("rospy of {python} and we heard each other", python=python)


def _talk(uri: str, process: subprocess.Popen[bytes]) -> None:
    from rosproto.node import Node

    with Node("/selftest_beside", master_uri=uri, host="127.0.0.1", rosout=False) as node:
        messages = node.subscriber("/selftest/from_ros", "std_msgs/String")
        publisher = node.publisher("/selftest/to_ros", "std_msgs/String", latch=True)
        publisher.publish(data="货架")
        try:
            publisher.wait_for_connection(timeout=_PATIENCE)
        except RosError as error:
            if process.poll() is not None and process.stderr is not None:
                said = process.stderr.read().decode("utf-8", "replace").strip()
                raise CheckFailed(say("the rospy program ended: {said}", said=said[-300:])) from error
            raise
        late = say("rospy's answer did not arrive within {seconds:g} s", seconds=_PATIENCE)
        expect("what rospy heard", _next(messages, _PATIENCE, late).data, "rospy heard 货架")
        with node.service_client("/selftest_rospy/get_loggers", "roscpp/GetLoggers") as client:  # each has it
            loggers = client.call(timeout=_PATIENCE).loggers
        expect("rospy's service", "rosout" in [logger.name for logger in loggers], True)
