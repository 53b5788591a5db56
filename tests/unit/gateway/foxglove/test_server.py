"""A Foxglove server over a real node and master, seen by a plain client of the published protocol."""

from __future__ import annotations

import socket
import ssl
import struct
import threading
import time
from pathlib import Path
from typing import Any

import pytest

from msgdefs.geometry_msgs.msg import Twist, Vector3
from msgdefs.std_msgs.msg import String
from msgdefs.std_srvs.srv import SetBool
from rosproto.codec import define, encode
from rosproto.errors import ConnectionLost
from rosproto.gateway import Access, GatewayLimits
from rosproto.gateway.foxglove import Foxglove, LocalTopic
from rosproto.master import Master
from rosproto.node import Node
from rosproto.time import Time
from tests.support.foxglove_ground import Ground, until
from tests.support.viewer import Viewer
from tests.unit.gateway.test_websocket_server import certificate

pytest.importorskip("websockets", reason="websockets is not installed")
pytest.importorskip("websockets", reason="websockets is not installed")

DRIVE = Twist(linear=Vector3(x=0.2))
ZERO = bytes(48)


def test_a_topic_is_followed_while_somebody_looks(ground: Ground) -> None:
    """The robot has a subscriber from the first viewer to the last, and the bytes come as they were sent."""
    publisher = ground.robot.publisher("/chatter", String)
    server = ground.serve(limits=GatewayLimits(linger_seconds=0.1))
    first, second = ground.view(server), ground.view(server)
    channel = first.offered("/chatter")
    assert (channel["encoding"], channel["schemaName"], channel["schemaEncoding"]) == (
        "ros1",
        "std_msgs/String",
        "ros1msg",
    )
    assert channel["schema"] == String._full_text
    second.offered("/chatter")
    assert ground.subscribers("/chatter") == []
    for viewer in (first, second):
        viewer.subscribe("/chatter")
    publisher.wait_for_connection(5)
    until(
        lambda: len(server.stats().topics) == 1 and sum(bool(c.subscriptions) for c in server.clients) == 2,
        "both",
    )
    before = {client.peer: client.sent for client in server.clients}
    data = encode(String(data="hello"))
    publisher.publish(data="hello")
    assert first.message("/chatter") == data
    assert second.message("/chatter") == data
    assert publisher.connections == 1
    first.unsubscribe("/chatter")
    second.close()
    until(lambda: ground.subscribers("/chatter") == [], "it is still followed")
    assert [client.sent - before[client.peer] for client in server.clients] == [1]


def test_a_latched_message_comes_to_everybody(ground: Ground) -> None:
    """Also to a viewer that subscribes when another has already."""
    publisher = ground.robot.publisher("/map_name", String, latch=True)
    publisher.publish(data="hall")
    server = ground.serve()
    for viewer in (ground.view(server), ground.view(server)):
        viewer.subscribe("/map_name")
        assert viewer.message("/map_name") == encode(String(data="hall"))


def test_a_latched_message_comes_again_to_who_subscribes_again(ground: Ground) -> None:
    """A viewer whose layout changes leaves a topic and takes it again at once: its new panel has seen nothing yet."""
    ground.robot.publisher("/map_name", String, latch=True).publish(data="hall")
    own = LocalTopic("/own", String, lambda wanted: None)
    own.publish(String(data="drawn"))
    server = ground.serve(topics=[own])
    viewer = ground.view(server)
    for topic, data in (("/map_name", "hall"), ("/own", "drawn")):
        viewer.subscribe(topic)
        assert viewer.message(topic) == encode(String(data=data))
        for _ in range(3):
            viewer.unsubscribe(topic)
            viewer.subscribe(topic)
            assert viewer.message(topic) == encode(String(data=data))
    # A latched message may come before its subscription is complete.
    until(lambda: server.clients[0].subscriptions == ("/map_name", "/own"), "a subscription is missing")


def test_topics_come_and_go(ground: Ground) -> None:
    """Without a new connection; a topic of another type is another channel."""
    server = ground.serve()
    viewer = ground.view(server)
    publisher = ground.robot.publisher("/later", String)
    number = viewer.offered("/later")["id"]
    publisher.close()
    viewer.until(lambda: "/later" not in viewer.channels)
    ground.robot.publisher("/later", Twist)
    assert viewer.offered("/later")["schemaName"] == "geometry_msgs/Twist"
    assert viewer.channels["/later"]["id"] != number


def test_types_that_nobody_knows_here(ground: Ground) -> None:
    """The publisher is asked for its definition before anybody subscribes."""
    kind = define("my_pkg/Odd", "float32 a\nOther b\n" + "=" * 80 + "\nMSG: my_pkg/Other\nuint8[] c\n")
    publisher = ground.robot.publisher("/odd", kind, latch=True)
    message = kind(a=1.5)
    publisher.publish(message)
    viewer = ground.view(ground.serve())
    channel = viewer.offered("/odd")
    assert "MSG: my_pkg/Other" in channel["schema"]
    viewer.subscribe("/odd")
    assert viewer.message("/odd") == encode(message)


def test_another_revision_of_a_known_type(ground: Ground) -> None:
    """What was offered with our definition is offered anew with the robot's, before any of its bytes come."""
    kind = define("std_msgs/String", "string data\nuint8 more\n")
    publisher = ground.robot.publisher("/chatter", kind, latch=True)
    publisher.publish(kind(data="a", more=7))
    viewer = ground.view(ground.serve())
    viewer.subscribe("/chatter")
    viewer.until(lambda: "more" in viewer.channels.get("/chatter", {}).get("schema", ""))
    viewer.subscribe("/chatter")
    assert viewer.message("/chatter") == encode(kind(data="a", more=7))


def test_a_publisher_of_another_type(ground: Ground) -> None:
    """Its messages are not sent to viewers of the channel, who are told; those of the topic's type are."""
    with Node("/other", master_uri=ground.master.uri, rosout=False, intraprocess=False) as node:
        wrong = node.publisher("/say", Twist)
        right = ground.robot.publisher("/say", String)  # the last one decides the graph's type
        viewer = ground.view(ground.serve())
        viewer.subscribe("/say")
        for publisher in wrong, right:
            publisher.wait_for_connection(5)
        for _ in range(100):
            wrong.publish(DRIVE)
        assert "geometry_msgs/Twist" in viewer.status("/say", "std_msgs/String")
        right.publish(data="right")
        assert viewer.message("/say") == encode(String(data="right"))


def test_what_is_not_open_is_not_shown(ground: Ground) -> None:
    """Topics, services, parameters, and their place in the graph."""
    ground.robot.publisher("/open", String)
    ground.robot.publisher("/secret/topic", String)
    ground.robot.service_server("/secret/service", SetBool, lambda request: {"success": True})
    ground.robot.service_server("/set", SetBool, lambda request: {"success": True})
    ground.robot.params["/secret/key"] = 1
    ground.robot.params["/key"] = 2
    viewer = ground.view(ground.serve(access=Access(deny=["/secret/*"])))
    viewer.offered("/open")
    viewer.until(lambda: "/set" in viewer.services)
    viewer.send("getParameters", parameterNames=[], id="all")
    names = {one["name"] for one in viewer.document("parameterValues", id="all")["parameters"]}
    assert "/key" in names
    viewer.send("subscribeConnectionGraph")
    graph = viewer.wait(
        lambda one: isinstance(one, dict) and one["op"] == "connectionGraphUpdate" and one["publishedTopics"]
    )
    assert "/open" in {topic["name"] for topic in graph["publishedTopics"]}
    seen = f"{viewer.channels}{viewer.services}{names}{graph}"
    assert "secret" not in seen


def test_the_graph_and_what_changes_in_it(ground: Ground) -> None:
    """Publishers, subscribers and service providers."""
    ground.robot.publisher("/chatter", String)
    viewer = ground.view(ground.serve())
    viewer.offered("/chatter")
    viewer.send("subscribeConnectionGraph")
    viewer.wait(
        lambda one: (
            isinstance(one, dict)
            and {"name": "/chatter", "publisherIds": ["/robot"]} in one.get("publishedTopics", [])
        )
    )
    ground.robot.subscriber("/orders", String)
    viewer.wait(
        lambda one: (
            isinstance(one, dict)
            and {"name": "/orders", "subscriberIds": ["/robot"]} in one.get("subscribedTopics", [])
        )
    )


# -- writing -------------------------------------------------------------------------------------------------


@pytest.mark.promise("a refused request gets an error text")
def test_nothing_is_written_at_first(ground: Ground) -> None:
    """Publishing, calling and setting are answered with a sentence that names the option; nothing happens."""
    called = []
    ground.robot.service_server("/set", SetBool, lambda request: called.append(request) or {"success": True})
    ground.robot.params["/speed"] = 1
    server = ground.serve()
    viewer = ground.view(server)
    # Viewers advertise some topics unasked, and need not be told; who publishes is.
    channel = viewer.advertise("/cmd_vel", "geometry_msgs/Twist")
    viewer.call("/set", encode(SetBool.Request(data=True)))
    failure = viewer.document("serviceCallFailure", callId=1)
    assert "--allow-write service:/set" in failure["message"]
    viewer.send("setParameters", parameters=[{"name": "/speed", "value": 9}], id="set")
    assert viewer.document("parameterValues", id="set")["parameters"] == [{"name": "/speed", "value": 1}]
    assert "--allow-write param:/speed" in viewer.status("/speed")
    assert not [one for one in viewer.came if "/cmd_vel" in str(one)]
    viewer.publish(channel, encode(DRIVE))
    assert "--allow-write topic:/cmd_vel" in viewer.status("/cmd_vel", "refused")
    assert ground.publishers("/cmd_vel") == []
    assert called == []
    assert ground.robot.params["/speed"] == 1
    assert server.stats().refusals >= 2


@pytest.mark.promise("a refused request gets an error text")
def test_what_is_opened_is_written(ground: Ground) -> None:
    """By a pattern, with the client's bytes, and not after it has left."""
    ground.robot.service_server("/set", SetBool, lambda request: {"success": request.data, "message": "done"})
    heard = ground.robot.subscriber("/say", String)
    viewer = ground.view(ground.serve(access=Access(write=["/say", "/set", "param:/speed*"])))
    channel = viewer.advertise("/say", "std_msgs/String", schema="string data")
    heard.wait_for_connection(5)
    viewer.publish(channel, encode(String(data="hello")))
    assert heard.next(5).data == "hello"
    viewer.publish(channel, b"\xff\xff\xff\xffno")
    assert "is not published" in viewer.status("/say")
    viewer.call("/set", encode(SetBool.Request(data=True)), call=5)
    answer = viewer.wait(lambda one: isinstance(one, tuple) and one[0] == "response")
    assert answer[1:] == (5, encode(SetBool.Response(success=True, message="done")))
    viewer.call("/set", b"", call=6)
    assert "SetBool" in viewer.document("serviceCallFailure", callId=6)["message"]
    viewer.send("subscribeParameterUpdates", parameterNames=["/speed"])
    viewer.send("setParameters", parameters=[{"name": "/speed", "value": 1.5}], id="a")
    assert viewer.document("parameterValues", id="a")["parameters"][0]["value"] == 1.5
    ground.robot.params["/speed"] = 2.5
    viewer.wait(
        lambda one: (
            isinstance(one, dict)
            and one["op"] == "parameterValues"
            and one["parameters"][0] == {"name": "/speed", "value": 2.5, "type": "float64"}
        )
    )


@pytest.mark.promise("a refused request gets an error text")
def test_read_only_wins_over_patterns(ground: Ground) -> None:
    """Whatever `write` says."""
    viewer = ground.view(ground.serve(access=Access(write=["*"], read_only=True)))
    viewer.publish(viewer.advertise("/say", "std_msgs/String"), encode(String(data="hello")))
    assert "read only" in viewer.status("/say")
    assert ground.publishers("/say") == []


@pytest.mark.promise("Zero velocity is sent when a viewer that drove leaves or falls silent")
def test_zero_follows_a_client_that_drove(ground: Ground) -> None:
    """When it falls silent, and at once when it has gone; a velocity that is not a number is not sent."""
    heard = ground.robot.subscriber("/cmd_vel", Twist, queue_size=100)
    server = ground.serve(access=Access(write=["/cmd_vel"]))
    viewer = ground.view(server)
    channel = viewer.advertise("/cmd_vel", "geometry_msgs/Twist")
    heard.wait_for_connection(5)
    viewer.publish(channel, encode(Twist(linear=Vector3(x=float("nan")))))
    assert "not finite" in viewer.status("/cmd_vel")
    viewer.publish(channel, encode(DRIVE))
    assert heard.next(5) == DRIVE
    assert encode(heard.next(5)) == ZERO, "it was silent"
    for _ in range(4):
        assert encode(heard.next(5)) == ZERO
    viewer.publish(channel, encode(DRIVE))
    assert heard.next(5) == DRIVE
    gone = time.monotonic()
    viewer.close()
    assert encode(heard.next(5)) == ZERO, "it has gone"
    for _ in range(4):
        assert encode(heard.next(5)) == ZERO
    until(lambda: server.stats().zeros == 10, "ten zeros")  # each is counted when it has been sent
    until(lambda: ground.publishers("/cmd_vel") == [], "its publisher stays")
    assert time.monotonic() - gone < 10


@pytest.mark.promise("Zero velocity is sent when a viewer that drove leaves or falls silent")
def test_closing_sends_zero_too(ground: Ground) -> None:
    """Also when the server closes while a viewer drives."""
    heard = ground.robot.subscriber("/cmd_vel", Twist, queue_size=100)
    server = ground.serve(access=Access(write=["/cmd_vel"]))
    viewer = ground.view(server)
    channel = viewer.advertise("/cmd_vel", "geometry_msgs/Twist")
    heard.wait_for_connection(5)
    viewer.publish(channel, encode(DRIVE))
    assert heard.next(5) == DRIVE
    server.close()
    assert encode(heard.next(5)) == ZERO
    assert ground.publishers("/cmd_vel") == []


# -- who comes in --------------------------------------------------------------------------------------------


def refused(url: str, **options: Any) -> int:
    exceptions = pytest.importorskip(
        "websockets.exceptions", reason='websockets is not installed: pip install ".[bridge]"'
    )
    with pytest.raises(exceptions.InvalidStatus) as caught:
        Viewer(url, **options)
    return int(caught.value.response.status_code)


@pytest.mark.promise(
    "on another address it does not start without a token",
    "the number of viewers, the topics of each",
    "a page from a file sends",
    "`Foxglove` allows none by default",
)
def test_strangers_stay_outside(ground: Ground) -> None:
    """Foreign pages, wrong tokens, other protocols, one client too many."""
    server = ground.serve(token="kd83-hsa2", limits=GatewayLimits(connections=1))
    assert refused(server.url) == 401
    assert refused(server.url + "?token=wrong") == 401
    assert (
        refused(server.url + "?token=kd83-hsa2", additional_headers={"Origin": "https://evil.example"}) == 403
    )
    assert refused(server.url + "?token=kd83-hsa2", additional_headers={"Origin": "null"}) == 403
    assert refused(server.url + "?token=kd83-hsa2", protocol="other") == 400
    viewer = Viewer(server.url + "?token=kd83-hsa2", protocol="foxglove.websocket.v1")
    assert viewer.socket.subprotocol == "foxglove.websocket.v1"
    assert refused(server.url + "?token=kd83-hsa2") == 503
    viewer.close()
    until(lambda: server.stats().clients == 0, "it is still here")
    with Viewer(server.url, additional_headers={"Authorization": "Bearer kd83-hsa2"}):
        pass
    assert server.stats().refused == 6


@pytest.mark.promise("on another address it does not start without a token")
def test_others_than_this_computer_need_a_token(ground: Ground) -> None:
    """An address that others can reach needs a token; a port in use is an error."""
    with pytest.raises(ValueError, match="token"):
        ground.serve(host="0.0.0.0")
    server = ground.serve()
    with pytest.raises(ConnectionLost, match="port"):
        Foxglove(ground.node, port=server.port)


def test_tls(ground: Ground, tmp_path: Path) -> None:
    """wss, with the certificate given; who speaks plainly there gets nothing, nor who trusts another one."""
    pytest.importorskip("cryptography")
    cert, key = certificate(tmp_path)
    context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    context.load_cert_chain(cert, key)
    ground.robot.publisher("/chatter", String, latch=True).publish(data="x" * 100_000)
    server = ground.serve(tls=context, token="kd83-hsa2")
    assert server.url.startswith("wss://127.0.0.1:")
    url = server.url.replace("127.0.0.1", "localhost") + "?token=kd83-hsa2"
    with Viewer(url, ssl=ssl.create_default_context(cafile=cert)) as viewer:
        viewer.subscribe("/chatter")
        assert viewer.message("/chatter") == encode(String(data="x" * 100_000))
    with pytest.raises(ssl.SSLCertVerificationError):
        Viewer(url, ssl=ssl.create_default_context())
    with socket.create_connection(("127.0.0.1", server.port), timeout=5) as sock:
        sock.sendall(b"GET / HTTP/1.1\r\n\r\n")
        assert not _received(sock).startswith(b"HTTP")


@pytest.mark.promise("an incomplete request is dropped after five")
def test_half_a_request_ends(ground: Ground) -> None:
    """Who connects and says nothing, garbage, or too much, has a place for a moment only, and is counted."""
    server = ground.serve(limits=GatewayLimits(handshake_seconds=0.3))
    for peer_log in (b"", b"GET / HT", b"\x16\x03\x01\x02\x00" + bytes(100) + b"\r\n\r\n", b"a" * 40_000):
        with socket.create_connection(("127.0.0.1", server.port), timeout=5) as sock:
            sock.sendall(peer_log)
            while _received(sock):
                pass
    until(lambda: server.stats().refused == 4, "not all were refused")
    ground.view(server)


def _received(sock: socket.socket) -> bytes:
    try:
        return sock.recv(4096)
    except ConnectionResetError:
        return b""


# -- what it costs -------------------------------------------------------------------------------------------


@pytest.mark.promise("A viewer that does not read costs at most 32 MiB")
def test_a_client_that_does_not_read_gets_the_newest_later(ground: Ground) -> None:
    """It takes bounded memory, does not delay others, and gets no old messages when it reads again."""
    publisher = ground.robot.publisher("/cloud", String, queue_size=1)
    # Longer than a busy machine takes for 80 MB: a client that has read nothing for that long is cut off.
    server = ground.serve(limits=GatewayLimits(silence_seconds=600.0))
    slow, quick = ground.view(server), ground.view(server)
    for viewer in (slow, quick):
        viewer.subscribe("/cloud")
    publisher.wait_for_connection(5)
    until(lambda: all(client.subscriptions for client in server.clients), "not followed")
    body = "x" * 2_000_000
    for number in range(40):
        publisher.publish(data=f"{number:04d}{body}")
        assert quick.message("/cloud")[4:8] == f"{number:04d}".encode()
    until(lambda: any(client.dropped for client in server.clients), "nothing was dropped")
    seen = [slow.message("/cloud")[4:8]]
    while seen[-1] != b"0039":
        seen.append(slow.message("/cloud")[4:8])
    assert seen == sorted(seen)
    dropped = max(sum(client.dropped.values()) for client in server.clients)  # no more after the last one
    assert len(seen) + dropped == 40


@pytest.mark.promise("A viewer that does not read costs at most 32 MiB")
def test_a_client_that_reads_nothing_at_all_is_cut_off(ground: Ground) -> None:
    """After the time of silence; the topic is left."""
    publisher = ground.robot.publisher("/cloud", String, queue_size=1)
    server = ground.serve(limits=GatewayLimits(silence_seconds=0.5, linger_seconds=0.1))
    viewer = ground.view(server, close_timeout=0.1)
    viewer.subscribe("/cloud")
    publisher.wait_for_connection(5)
    until(lambda: any(client.subscriptions for client in server.clients), "not followed")
    body = "x" * 2_000_000
    end = time.monotonic() + 20
    while server.stats().stalled == 0:
        assert time.monotonic() < end, server.stats()
        publisher.publish(data=body)
        threading.Event().wait(0.01)
    until(lambda: server.stats().clients == 0 and not server.stats().topics, str(server.stats()))


@pytest.mark.promise("the number of viewers, the topics of each")
def test_a_client_may_not_follow_everything(ground: Ground) -> None:
    """Further topics are refused with a status; its subscriptions continue."""
    publishers = [ground.robot.publisher(f"/t{number}", String, latch=True) for number in range(4)]
    for publisher in publishers:
        publisher.publish(data="x")
    viewer = ground.view(ground.serve(limits=GatewayLimits(subscriptions_per_client=2)))
    for number in range(4):
        viewer.subscribe(f"/t{number}")
    assert "2 topics already are" in viewer.status("is not subscribed to")
    for number in range(2):
        assert viewer.message(f"/t{number}")


WORKERS = {"rosproto:foxglove", "rosproto:foxglove work"}


def ours() -> set[str]:
    """Names of the library's threads; the clients of this test have some, too."""
    names = {thread.name for thread in threading.enumerate()}
    return {name for name in names if name.startswith("rosproto:") and "master 127" not in name}


@pytest.mark.slow
def test_many_who_come_and_go_leave_nothing(ground: Ground) -> None:
    """No thread, no file, no subscription: by a goodbye, by a cut, and in the middle of the handshake."""
    ground.robot.publisher("/chatter", String, latch=True).publish(data="x")
    server = ground.serve(limits=GatewayLimits(linger_seconds=0.1))
    with ground.view(server) as viewer:
        viewer.subscribe("/chatter")
        viewer.message("/chatter")
    until(lambda: not server.stats().topics and not server.stats().clients, "the first stays")
    threads = ours()
    for number in range(100):
        if number % 4 == 3:
            with socket.create_connection(("127.0.0.1", server.port)) as sock:
                sock.sendall(b"GET / HTTP/1.1\r\nHost: localhost\r\n")
            continue
        viewer = Viewer(server.url)
        viewer.subscribe("/chatter")
        if number % 4 == 1:
            viewer.message("/chatter")
            viewer.close()
        else:
            viewer.socket.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            viewer.socket.socket.close()
    until(lambda: server.stats().clients == 0 and not server.stats().topics, str(server.stats()), 20.0)
    until(lambda: ground.subscribers("/chatter") == [], "still subscribed")
    # Worker threads are started when they are needed, and stay for a while.
    until(lambda: ours() <= threads | WORKERS, "threads stay")
    assert server.clients == ()


def test_closing_is_quick_and_says_goodbye(ground: Ground) -> None:
    """Clients get a close frame; a second close does nothing; the node's end closes it, too."""
    exceptions = pytest.importorskip(
        "websockets.exceptions", reason='websockets is not installed: pip install ".[bridge]"'
    )
    server = ground.serve()
    viewer = ground.view(server)
    server.close()
    server.close()
    farewell: Any = None
    while farewell is None:
        try:
            viewer.socket.recv(timeout=5)
        except exceptions.ConnectionClosed as closed:
            farewell = closed
    assert farewell.rcvd is not None
    other = ground.serve()
    ground.node.close()
    with pytest.raises(OSError):
        socket.create_connection(("127.0.0.1", other.port), timeout=1)


# -- the rest ------------------------------------------------------------------------------------------------


def test_a_topic_of_this_program_alone(ground: Ground) -> None:
    """Made only while a viewer subscribes, and not registered at the master."""
    wanted: list[bool] = []
    topic = LocalTopic("/overlay", String, wanted.append)
    server = ground.serve(topics=[topic])
    viewer = ground.view(server)
    assert wanted == []
    viewer.subscribe("/overlay")
    until(lambda: wanted == [True], "not wanted")
    topic.publish(String(data="drawn"))
    assert viewer.message("/overlay") == encode(String(data="drawn"))
    later = ground.view(server)
    later.subscribe("/overlay")
    assert later.message("/overlay") == encode(String(data="drawn"))
    assert ground.publishers("/overlay") == []
    viewer.close()
    later.close()
    until(lambda: wanted == [True, False], "still wanted")


def test_files_of_packages(ground: Ground, tmp_path: Path) -> None:
    """From the folders that were named, with an error for everything else."""
    (tmp_path / "my_robot").mkdir()
    (tmp_path / "my_robot" / "base.stl").write_bytes(b"solid")
    viewer = ground.view(ground.serve(assets=[tmp_path]))
    assert "assets" in viewer.info["capabilities"]
    viewer.send("fetchAsset", uri="package://my_robot/base.stl", requestId=3)
    assert viewer.wait(lambda one: isinstance(one, tuple) and one[0] == "asset")[1:] == (3, 0, "", b"solid")
    viewer.send("fetchAsset", uri="file:///etc/passwd", requestId=4)
    answer = viewer.wait(lambda one: isinstance(one, tuple) and one[0] == "asset")
    assert answer[1:3] == (4, 1)
    assert answer[4] == b""
    assert "assets" not in ground.view(ground.serve()).info["capabilities"]


def test_simulated_time() -> None:
    """Viewers get the simulated time, and messages carry it."""
    with Master() as master, Node("/sim", master_uri=master.uri, rosout=False) as sim:
        sim.params["/use_sim_time"] = True
        clock = sim.publisher("/clock", "rosgraph_msgs/Clock", latch=True)
        clock.publish(clock=Time(41, 5))
        text = sim.publisher("/text", String, latch=True)
        with Node("/gateway", master_uri=master.uri, rosout=False) as node:
            assert node.clock.wait_for_time(5)
            with Foxglove(node, port=0) as server, Viewer(server.url) as viewer:
                assert "time" in viewer.info["capabilities"]
                assert (
                    viewer.wait(lambda one: isinstance(one, tuple) and one[0] == "time")[1] == 41_000_000_005
                )
                until(lambda: "/clock" in server.stats().topics, "the server follows no clock")
                clock.publish(clock=Time(42, 0))
                viewer.wait(lambda one: one == ("time", 42_000_000_000))
                until(lambda: node.clock.now_nsec() == 42_000_000_000, "the node's clock")
                viewer.subscribe("/text")
                text.wait_for_connection(5)
                text.publish(data="x")
                message = viewer.wait(lambda one: isinstance(one, tuple) and one[:2] == ("message", "/text"))
                assert message[3] == 42_000_000_000


@pytest.mark.slow
def test_the_master_goes_and_comes_back() -> None:
    """Viewers get a status, stay connected, and see the topics of the new run."""
    with Master() as first:
        port = first.port
        robot = Node("/robot", master_uri=first.uri, rosout=False, intraprocess=False)
        node = Node("/gateway", master_uri=first.uri, rosout=False, intraprocess=False)
        publisher = robot.publisher("/chatter", String, latch=True)
        publisher.publish(data="x")
        server = Foxglove(node, port=0)
        viewer = Viewer(server.url)
        viewer.subscribe("/chatter")
        viewer.message("/chatter")
        session = viewer.info["sessionId"]
    try:
        assert "does not answer" in viewer.status("master", seconds=20)
        with Master(port=port):
            viewer.status("is back", "another run", seconds=20)
            viewer.document("removeStatus")
            again = viewer.document("serverInfo", seconds=20)
            assert again["sessionId"] != session
            viewer.came.clear()
            viewer.until(lambda: "/chatter" in viewer.channels, 20)
            viewer.subscribe("/chatter")
            assert viewer.message("/chatter", 20) == encode(String(data="x"))
    finally:
        viewer.close()
        server.close()
        node.close()
        robot.close()
