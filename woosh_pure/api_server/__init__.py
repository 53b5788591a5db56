"""A server of the Robot API on a node: programs written for that interface read a chassis of ROS 1, or a
simulated one.

    with SimulatedChassis() as sim, Node("/robot_api", master_uri=sim.master_uri) as node:
        with RobotApiServer(node, site=simulated_site(sim)) as server:
            print(server.url)

It moves nothing: only read requests and subscriptions are answered.
"""

from __future__ import annotations

from woosh_pure.api_server.server import RobotApiServer
from woosh_pure.api_server.simulated import simulated_site
from woosh_pure.api_server.site import RobotSite

__all__ = ["RobotApiServer", "RobotSite", "simulated_site"]
