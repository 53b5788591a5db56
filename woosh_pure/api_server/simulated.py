"""The site of a simulated chassis, whose world tells what ROS 1 does not."""

from __future__ import annotations

import math
from collections.abc import Mapping
from urllib.parse import urlsplit

from woosh_pure.api_server.site import RobotSite
from woosh_pure.robot_api.wire import Values, enum
from woosh_pure.sim import SimulatedChassis

_CORNERS = 12  # of the outline of the round body
_FAULT = enum("woosh.robot.HardwareState.State")["kFatal"]
_PARTS = {"motor": [0, 0], "lidar": [0], "camera": [0]}


def simulated_site(sim: SimulatedChassis, robot_id: int = 1) -> RobotSite:
    """The map of a simulated chassis with its marks, and the state of its parts; it has no stored tasks."""
    site = sim.world.site
    hardware, software = (
        enum("woosh.robot.DeviceState.HardwareBit"),
        enum("woosh.robot.DeviceState.SoftwareBit"),
    )
    host = urlsplit(sim.master_uri).hostname or ""

    def facts() -> Mapping[str, Values]:
        with sim.lock:
            world = sim.world
            pressed, located, bumped = world.emergency_stop, world.located, world.bumper
            radius = world.settings.radius
        size = round(2000 * radius)
        angles = [2.0 * math.pi * corner / _CORNERS for corner in range(_CORNERS)]
        outline = [{"x": radius * math.cos(angle), "y": radius * math.sin(angle)} for angle in angles]
        return {
            "woosh.robot.General": {
                "modelData": {"length": size, "width": size},
                "displayModel": "simulated chassis",
                "serialNumber": robot_id,
            },
            "woosh.robot.DeviceState": {
                "hardware": hardware["kEmgBtn"] * pressed,
                "software": software["kLocation"] * located,
            },
            "woosh.robot.HardwareState": {**_PARTS, "crash": _FAULT * bumped},
            "woosh.robot.Model": {"model": outline},
            **{f"woosh.task.{name}": {} for name in ("TaskInfo", "RepeatTasks", "CallTasks")},
            "woosh.robot.Network": {"robotIp": host},
            "woosh.robot.Setting": {"identity": {"name": "simulated chassis"}, "allow": {}},
        }

    marks = tuple(site.user_marks().values())
    return RobotSite("simulation", "map", lambda: site.grid, lambda: marks, facts)
