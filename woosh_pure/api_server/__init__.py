"""A server of the Robot API on a node: `RobotApiServer(node, site=simulated_site(sim))`.

Read requests and subscriptions are answered; commands only where `Access(write=["api:*"])` opens them.
"""

from __future__ import annotations

from woosh_pure.api_server.server import RobotApiServer
from woosh_pure.api_server.simulated import simulated_site
from woosh_pure.api_server.site import RobotSite

__all__ = ["RobotApiServer", "RobotSite", "simulated_site"]
