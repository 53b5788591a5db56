"""An assistant's drive at a robot whose `/move_base` is an actionlib server of roscpp."""

from __future__ import annotations

import asyncio
import sys
from pathlib import Path
from typing import Any

import pytest

from rosproto.master import Master
from tests.support import ros
from tests.support.extras import needs

needs("mcp")

from mcp import Client, StdioServerParameters  # noqa: E402 (after the skip)


@pytest.mark.slow
def test_a_closed_stream_cancels_the_goal_of_roscpp(our_master: Master, roscpp_peer: Path) -> None:
    """A drive arrives; the next one is preempted when its client closes the stream, far from the target."""
    words = ["-m", "woosh_pure", "--master", our_master.uri, "mcp", "--allow-motion", "--confirm", "never"]

    async def drive(robot: ros.RosProcess) -> None:
        async with Client(StdioServerParameters(command=sys.executable, args=words)) as client:
            moved: Any = (await client.call_tool("go_to_pose", {"x_m": 0.3, "y_m": 0.0})).structured_content
            assert moved["outcome"] == "reached", moved
            assert moved["pose"]["x_m"] >= 0.3
            call = asyncio.ensure_future(client.call_tool("go_to_pose", {"x_m": 100.0, "y_m": 0.0}))
            await asyncio.to_thread(robot.wait_for, r"(?s)goal.*arrived.*goal")
        await asyncio.gather(call, return_exceptions=True)

    with ros.start_program(roscpp_peer, our_master.uri, "robot", "__name:=ros_interface") as robot:
        robot.wait_for("up")
        asyncio.run(asyncio.wait_for(drive(robot), 60.0))
        robot.wait_for("preempted")
