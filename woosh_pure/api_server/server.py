"""`RobotApiServer`: the server, as a program uses it."""

from __future__ import annotations

from functools import partial

from rosproto.gateway import GatewayLimits, GatewayServer, HandshakeRules, WebSocketServer
from rosproto.logs import get_logger
from rosproto.node import Node
from woosh_pure.api_server.session import ApiPosts, ApiSession
from woosh_pure.api_server.site import RobotSite
from woosh_pure.api_server.state import ApiState
from woosh_pure.robot_api.wire import PORT

_log = get_logger("woosh_pure.api_server")


class RobotApiServer(GatewayServer):
    """Answers read requests of the Robot API, by HTTP and WebSocket, and pushes what is subscribed.

    It moves and changes nothing: every other request is answered with `ok` false. What no topic of the robot
    tells, and `site` neither, is not known: the request is refused instead of answered with zeros.

    Args:
        node: Subscribes to the robot's topics. Close the server before it.
        port: Port on 127.0.0.1; 0 for a free one. The vendor's client knows no authentication.
        robot_id: The robot's number in answers and pushes.
        site: Scene, map, marks and what no topic tells.
        limits: Bounds for a client.

    Raises:
        LocalProtocolError: The package `websockets` is missing.
        ConnectionLost: The port cannot be listened on, or the master does not answer.
    """

    def __init__(
        self,
        node: Node,
        *,
        port: int = PORT,
        robot_id: int = 1,
        site: RobotSite | None = None,
        limits: GatewayLimits | None = None,
    ) -> None:
        state = ApiState(node, limits or GatewayLimits(), robot_id, site)
        super().__init__(
            state,
            lambda: WebSocketServer(
                partial(ApiSession, state),
                HandshakeRules("127.0.0.1"),
                port=port,
                limits=state.limits._replace(message_bytes=state.max_message_bytes),
                name="robot-api",
                posts=ApiPosts(state),
            ),
        )
        _log.info("= robot-api: serving %s at %s", node.name, self.url)
