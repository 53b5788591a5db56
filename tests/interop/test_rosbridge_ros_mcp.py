"""PyPI's `ros-mcp` (a robot for language models), unmodified, against real rospy nodes behind either bridge.

Its tools are called as an MCP client does, through its own server object.
"""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest

from tests.interop.rosbridge_world import World
from tests.support import ros, web_peers
from tests.support.extras import needs

needs("bridge")

PROGRAM = """
import asyncio, json, sys
from fastmcp import Client
from ros_mcp.main import mcp

async def main():
    said = []
    async with Client(mcp) as client:
        for name, arguments in json.loads(sys.argv[1]):
            answer = await client.call_tool(name, arguments, raise_on_error=False)
            texts = [getattr(part, 'text', part.type) for part in answer.content]
            said.append(answer.structured_content or texts)
    print('SAID ' + json.dumps(said, default=str))

asyncio.run(main())
"""


def tools(world: World, folder: Path, *calls: tuple[str, dict[str, Any]]) -> list[Any]:
    """What its tools answer, the robot connected first."""
    python = web_peers.python_with("ros_mcp")
    connect = ("connect_to_robot", {"ip": "127.0.0.1", "port": world.port})
    done = subprocess.run(
        [python, "-c", PROGRAM, json.dumps([connect, *calls])],
        capture_output=True, text=True, timeout=120, env=ros.clean_environment(), cwd=folder,
    )  # fmt: skip
    lines = [line for line in done.stdout.splitlines() if line.startswith("SAID ")]
    assert lines, done.stderr[-3000:]
    connected, *said = json.loads(lines[0][5:])
    assert "warning" not in connected, connected
    return said


def test_topics_services_and_nodes(web_world: World, tmp_path: Path) -> None:
    """What there is, of what types, with whom."""
    version, topics, kind, details, message, services, service, nodes, node, actions = tools(
        web_world,
        tmp_path,
        ("detect_ros_version", {}),
        ("get_topics", {}),
        ("get_topic_type", {"topic": "/chatter"}),
        ("get_topic_details", {"topic": "/cmd_vel"}),
        ("get_message_details", {"message_type": "geometry_msgs/Twist"}),
        ("get_services", {}),
        ("get_service_details", {"service": "/lamp"}),
        ("get_nodes", {}),
        ("get_node_details", {"node": "/robot"}),
        ("get_actions", {}),
    )
    assert "1" in str(version)
    assert "noetic" in json.dumps(version)
    assert "/scan" in topics["topics"]
    assert kind["type"] == "std_msgs/String"
    assert "/robot" in details["subscribers"]
    assert "linear" in json.dumps(message)
    assert "/lamp" in services["services"]
    assert "std_srvs/SetBool" in json.dumps(service)
    assert "/robot" in json.dumps(service)
    assert "/robot" in nodes["nodes"]
    assert "/chatter" in json.dumps(node)
    assert "error" not in actions


def test_messages_calls_and_parameters(web_world: World, tmp_path: Path) -> None:
    """It reads a topic, sees a picture, publishes, calls, and sets parameters."""
    with web_world.node.subscriber("/from_mcp", "std_msgs/String") as came:
        once, picture, published, lamp, broken, speed, set_, has, deleted, gone = tools(
            web_world,
            tmp_path,
            ("subscribe_once", {"topic": "/chatter", "msg_type": "std_msgs/String", "timeout": 20}),
            ("subscribe_once", {"topic": "/picture", "msg_type": "sensor_msgs/Image", "timeout": 20}),
            ("publish_for_durations", {
                "topic": "/from_mcp", "msg_type": "std_msgs/String",
                "messages": [{"data": "one"}, {"data": "two"}], "durations": [1, 1],
            }),
            ("call_service", {"service_name": "/lamp", "service_type": "std_srvs/SetBool", "request": {"data": True}}),
            ("call_service", {"service_name": "/lamp", "service_type": "std_srvs/SetBool", "request": {"data": False}}),
            ("get_parameter", {"name": "/speed"}),
            ("set_parameter", {"name": "/mcp", "value": "5"}),
            ("has_parameter", {"name": "/mcp"}),
            ("delete_parameter", {"name": "/mcp"}),
            ("has_parameter", {"name": "/mcp"}),
        )  # fmt: skip
        assert came.next(10).data in ("one", "two")
    assert once["msg"]["data"] == "hello"
    assert "error" not in picture
    assert (tmp_path / "camera" / "received_image.jpeg").stat().st_size > 0
    assert "error" not in published
    assert "on" in json.dumps(lamp)
    assert "the lamp is broken" in json.dumps(broken)
    assert "0.5" in json.dumps(speed)
    assert set_["successful"]
    assert has["exists"]
    assert deleted["successful"]
    assert not gone["exists"]


def test_a_goal(web_world: World, tmp_path: Path) -> None:
    """Its tool for actions, which knows ROS 2's operations only."""
    if web_world.bridge != "ours":
        pytest.skip("the original has no such operation")
    goal = {"action_name": "/walk", "action_type": "actionlib/action/Test", "goal": {"goal": 5}}
    (answer,) = tools(web_world, tmp_path, ("send_action_goal", goal))
    assert (answer["success"], answer["result"]) == (True, {"result": 10})
