"""Runs in the SDK's environment: its agent class with all subscriptions for some seconds, and 20 requests in parallel.

Arguments: port, seconds. stdout: the log of the SDK, and a line KNOWN and JSON: what the agent knows at the end.
"""

from __future__ import annotations

import asyncio
import json
import logging
import sys

from woosh.proto.robot.robot_pb2 import Battery, Mode, PoseSpeed, RobotInfo
from woosh_robot_agent import WooshRobotAgent


async def main(port: int, seconds: float) -> None:
    logging.basicConfig(stream=sys.stdout, level=logging.INFO)
    agent = await WooshRobotAgent.create("127.0.0.1", port, logger=logging.getLogger("agent"))
    robot = agent.robot
    kinds = (
        (robot.robot_info_req, RobotInfo),
        (robot.robot_battery_req, Battery),
        (robot.robot_mode_req, Mode),
        (robot.robot_pose_speed_req, PoseSpeed),
    ) * 5
    answers = await asyncio.gather(*(ask(kind()) for ask, kind in kinds))
    await asyncio.sleep(seconds)
    pose = agent.pose_speed.pose
    known = {
        "answered": [
            ok and type(body).__name__ == kind.__name__
            for (body, ok, _), (_, kind) in zip(answers, kinds, strict=True)
        ],
        "state": agent.state.state,
        "mode": [agent.mode.ctrl, agent.mode.work],
        "power": agent.battery.power,
        "at": [pose.x, pose.y],
        "task": [agent.task_proc.dest, agent.task_proc.state],
        "outline": len(agent.model.model),
        "path": len(agent.nav_path.path.poses),
        "taskable": agent.operation_state.robot,
    }
    print("\nKNOWN " + json.dumps(known), flush=True)


asyncio.run(main(int(sys.argv[1]), float(sys.argv[2])))
