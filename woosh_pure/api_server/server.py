"""`RobotApiServer`: the server, as a program uses it."""

from __future__ import annotations

import ssl
from collections.abc import Sequence
from functools import partial

from rosproto.gateway import Access, GatewayLimits, GatewayServer, HandshakeRules, WebSocketServer
from rosproto.logs import get_logger
from rosproto.node import Node
from rosproto.watchdog import Watchdog
from woosh_pure.api_server.session import ApiPosts, ApiSession
from woosh_pure.api_server.site import RobotSite
from woosh_pure.api_server.state import ApiState
from woosh_pure.lease import ChassisLease
from woosh_pure.robot_api.wire import PORT

_log = get_logger("woosh_pure.api_server")


class RobotApiServer(GatewayServer):
    """Answers requests of the Robot API, by HTTP and WebSocket, and pushes what is subscribed.

    It moves and changes nothing unless `access` opens it by patterns such as "api:Twist" or "api:*". What no
    topic of the robot tells, and `site` neither, is not known: the request is refused instead of answered
    with zeros. If a client that drives leaves or sends nothing for half a second, zero is sent.

    Args:
        node: Subscribes, publishes and calls for the clients. Close the server before it.
        host: Address to listen on; others than 127.0.0.1 and ::1 need a token, which the vendor's client
            cannot send; by HTTP it may be the password of Basic.
        port: Port; 0 for a free one.
        access: Which commands clients may send.
        limits: Bounds for a client.
        tls, origins, hosts, token: See `Rosbridge`.
        watchdog: Sends zero where a client drives when this process is killed or hangs.
        robot_id: The robot's number in answers and pushes.
        site: Scene, map, marks and what no topic tells.
        lease: Acquired for each command as "robot-api ADDRESS"; a zero and a cancel need none.
        share: Let a client drive while another client or program can: the robot obeys the last one.

    Raises:
        LocalProtocolError: The package `websockets` is missing.
        ValueError: Others can reach the address, and there is no token; or it is too short.
        ConnectionLost: The port cannot be listened on, or the master does not answer.
    """

    def __init__(
        self,
        node: Node,
        *,
        host: str = "127.0.0.1",
        port: int = PORT,
        access: Access | None = None,
        limits: GatewayLimits | None = None,
        tls: ssl.SSLContext | None = None,
        origins: Sequence[str] = (),
        hosts: Sequence[str] = (),
        token: str | None = None,
        watchdog: Watchdog | None = None,
        robot_id: int = 1,
        site: RobotSite | None = None,
        lease: ChassisLease | None = None,
        share: bool = False,
    ) -> None:
        rules = HandshakeRules(host, origins, token, hosts=hosts)
        bounds = limits or GatewayLimits()
        state = ApiState(node, access or Access(), bounds, watchdog, robot_id, site, lease, share=share)
        super().__init__(
            state,
            lambda: WebSocketServer(
                partial(ApiSession, state),
                rules,
                port=port,
                limits=bounds._replace(message_bytes=state.max_message_bytes),
                tls=tls,
                name="robot-api",
                posts=ApiPosts(state),
            ),
        )
        _log.info("= robot-api: serving %s at %s", node.name, self.url)
