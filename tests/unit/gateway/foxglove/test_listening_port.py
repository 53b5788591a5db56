"""Each viewer's port behind the proxy: nobody else gets in, or is taken for the viewer."""

from __future__ import annotations

import os
import socket
import sys
import threading
from collections.abc import Callable
from typing import Any

import pytest

from msgdefs.std_msgs.msg import String
from msgdefs.std_srvs.srv import SetBool
from rosproto.codec import encode
from rosproto.gateway import Access
from rosproto.gateway.foxglove import listening_port, session
from tests.support.foxglove_ground import Ground, until
from tests.support.viewer import Viewer

pytest.importorskip("foxglove", reason="foxglove-sdk is not installed")
exceptions = pytest.importorskip("websockets.exceptions", reason="websockets is not installed")

linux = pytest.mark.skipif(sys.platform != "linux", reason="the port is closed on Linux alone")


class Thief:
    """Another program of this computer that is at the port before the proxy has closed it, or is led there.

    Args:
        closes: Whether the port can be closed, as on Linux.
    """

    def __init__(self, monkeypatch: pytest.MonkeyPatch, *, closes: bool) -> None:
        self.viewer: Viewer | None = None
        self._closes = closes
        monkeypatch.setattr(session, "close_listening_port", self._close)

    def _close(self, port: int, client: int) -> bool:
        if self.viewer is None:
            self.viewer = Viewer(f"ws://127.0.0.1:{port}")
        return self._closes and listening_port.close_listening_port(port, client)


@pytest.mark.promise(
    "before anything is offered, and one who was there before",
    "Behind the proxy each viewer has an SDK server",
)
@linux
def test_the_port_is_closed_when_the_viewer_is_there(ground: Ground) -> None:
    """Nobody can connect to it any more, nothing of this process listens there, and the viewer sees on."""
    ground.robot.publisher("/chatter", String, latch=True).publish(data="x")
    server = ground.serve()
    viewer = ground.view(server)
    one = next(iter(server._shared.sessions))
    assert one.alone
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.1", one.port), timeout=5)
    # The SDK's loop has ended with it, and goes round in no circle.
    until(lambda: one.port not in listening(), "it listens still")
    viewer.subscribe("/chatter")
    assert viewer.message("/chatter") == encode(String(data="x"))
    assert server.stats().clients == 1


def listening() -> set[int]:
    """Ports of the sockets of this process that wait for connections, or did."""
    found = set()
    for entry in os.listdir("/proc/self/fd"):
        try:
            if not os.readlink(f"/proc/self/fd/{entry}").startswith("socket:"):
                continue
            with socket.socket(fileno=os.dup(int(entry))) as one:
                if one.family == socket.AF_INET and not connected(one):
                    found.add(one.getsockname()[1])
        except OSError:
            continue
    return found


def connected(one: socket.socket) -> bool:
    try:
        one.getpeername()
    except OSError:
        return False
    return True


def test_sockets_of_others_are_left_as_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where looking at them would make them non-blocking, nothing is looked at."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        with monkeypatch.context() as patch:
            patch.setattr(socket, "getdefaulttimeout", lambda: 5.0)
            assert not listening_port.close_listening_port(server.getsockname()[1], 1)
        with socket.create_connection(server.getsockname(), timeout=5):
            assert server.getblocking()


@pytest.mark.promise("before anything is offered, and one who was there before")
@linux
def test_who_was_there_before_ends_it(ground: Ground, monkeypatch: pytest.MonkeyPatch) -> None:
    """The viewer is told to come again, is served then, and the other one has seen no topic."""
    thief = Thief(monkeypatch, closes=True)
    ground.robot.publisher("/chatter", String)
    server = ground.serve()
    with pytest.raises(exceptions.InvalidStatus) as caught:
        ground.view(server)
    assert caught.value.response.status_code == 503
    ended(thief)
    until(lambda: server.stats().clients == 0, "the session goes on")
    ground.view(server).offered("/chatter")
    assert server.stats().clients == 1


def ended(thief: Thief) -> None:
    """Its connection is over, and no topic, service or parameter came."""
    viewer = thief.viewer
    assert viewer is not None
    with pytest.raises(exceptions.ConnectionClosed):
        viewer.until(lambda: False)
    assert (viewer.channels, viewer.services) == ({}, {})
    viewer.close()


def publishes(viewer: Viewer) -> None:
    viewer.publish(viewer.advertise("/cmd_vel", "geometry_msgs/Twist"), bytes(48))


def calls(viewer: Viewer) -> None:
    viewer.call("/set", encode(SetBool.Request(data=True)))


def sets(viewer: Viewer) -> None:
    viewer.send("setParameters", parameters=[{"name": "/speed", "value": 9}], id="set")


def reads(viewer: Viewer) -> None:
    viewer.send("getParameters", parameterNames=["/speed"], id="get")


def follows(viewer: Viewer) -> None:
    viewer.subscribe("/chatter")


@pytest.mark.promise("gets nothing done and ends the session")
@pytest.mark.parametrize("act", [publishes, calls, sets, reads, follows])
def test_where_the_port_stays_open_the_first_is_not_taken_for_the_viewer(
    ground: Ground, monkeypatch: pytest.MonkeyPatch, act: Callable[[Viewer], None]
) -> None:
    """It is at the port before the viewer, does something that is open to viewers, and nothing of it happens."""
    called = threading.Event()
    ground.robot.publisher("/chatter", String)
    ground.robot.service_server("/set", SetBool, lambda request: called.set() or {"success": True})
    ground.robot.params["/speed"] = 1
    thief = Thief(monkeypatch, closes=False)
    server = ground.serve(token="secret", access=Access(write=["*"]))
    viewer = Viewer(server.url + "?token=secret")
    assert not next(iter(server._shared.sessions)).alone
    assert thief.viewer is not None
    act(thief.viewer)
    until(lambda: server.stats().clients == 0, "the session goes on")
    assert not called.is_set()
    assert ground.publishers("/cmd_vel") == []
    assert ground.robot.params["/speed"] == 1
    assert not [one for one in thief.viewer.came if one_of(one, "parameterValues")]
    thief.viewer.close()
    viewer.close()


def one_of(came: Any, op: str) -> bool:
    return isinstance(came, dict) and came["op"] == op
