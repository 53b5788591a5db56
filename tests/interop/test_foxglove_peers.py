"""Foxglove's own client library (npm: `@foxglove/ws-protocol`) at our server, its decoder reading what it gets.

It is told nothing but an address, and decodes by the definitions that come with the channels: from the simulated
chassis, from rospy and from roscpp, at our master and at Debian's.
"""

from __future__ import annotations

import json
import ssl
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from msgdefs.geometry_msgs.msg import Twist
from rosproto.gateway import Access
from rosproto.gateway.foxglove import Foxglove
from rosproto.node import Node
from tests.interop.topic_samples import TYPES, sample
from tests.support import ros, web_peers
from tests.support.victim import eventually
from tests.unit.gateway.test_websocket_server import certificate
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.foxglove import ChassisTopics
from woosh_pure.interface.table import driving_patterns

pytest.importorskip("websockets", reason="websockets is not installed")

MODULES = ("ws", "@foxglove/ws-protocol", "@foxglove/rosmsg", "@foxglove/rosmsg-serialization")

CLIENT = """
import {{ createRequire }} from 'node:module';
const require = createRequire('{modules}/');
const WebSocket = require('ws');
const {{ FoxgloveClient }} = require('@foxglove/ws-protocol');
const {{ parse }} = require('@foxglove/rosmsg');
const {{ MessageReader, MessageWriter }} = require('@foxglove/rosmsg-serialization');
const plain = (key, value) =>
  typeof value === 'bigint' ? value.toString() : ArrayBuffer.isView(value) ? Array.from(value) : value;
const tell = (...values) => console.log(JSON.stringify(values, plain));
const client = new FoxgloveClient({{ ws: new WebSocket('{url}', [{protocol}], {{ ca: {ca} }}) }});
const readers = new Map(), wanted = new Set({topics}), services = new Map(), writers = new Map(), calls = {{}};
client.on('error', error => tell('error', String(error)));
client.on('close', event => tell('closed', event.code));
client.on('serverInfo', info => tell('info', info));
client.on('status', status => tell('status', status.message));
client.on('advertise', channels => {{
  for (const channel of channels) {{
    if (!wanted.has(channel.topic)) continue;
    if (channel.encoding !== 'ros1' || channel.schemaEncoding !== 'ros1msg') tell('error', channel);
    readers.set(client.subscribe(channel.id), [channel.topic, new MessageReader(parse(channel.schema))]);
  }}
}});
client.on('message', ({{ subscriptionId, data }}) => {{
  const [topic, reader] = readers.get(subscriptionId);
  tell('message', topic, reader.readMessage(data));
}});
client.on('advertiseServices', offered => {{
  for (const service of offered) services.set(service.name, service);
  tell('services', offered.map(one => one.name));
  for (const one of offered) if (one.name in calls) call(one.name, calls[one.name]);
}});
client.on('serviceCallResponse', answer => {{
  const service = [...services.values()].find(one => one.id === answer.serviceId);
  tell('answer', new MessageReader(parse(service.response.schema)).readMessage(answer.data));
}});
client.on('serviceCallFailure', failure => tell('failure', failure.message));
client.on('parameterValues', values => tell('parameters', values.id, values.parameters));
client.on('connectionGraphUpdate', graph => tell('graph', graph));
client.on('fetchAssetResponse', answer => tell('asset', answer.status, answer.error ?? answer.data.byteLength));
const call = (name, request) => {{
  const service = services.get(name);
  const data = new MessageWriter(parse(service.request.schema)).writeMessage(request);
  client.sendServiceCallRequest({{ serviceId: service.id, callId: 1, encoding: 'ros1', data }});
}};
const publish = (topic, schemaName, schema, message) => {{
  if (!writers.has(topic)) {{
    const id = client.advertise({{ topic, encoding: 'ros1', schemaName, schema, schemaEncoding: 'ros1msg' }});
    writers.set(topic, [id, new MessageWriter(parse(schema))]);
  }}
  const [id, writer] = writers.get(topic);
  client.sendMessage(id, writer.writeMessage(message));
}};
const publishJson = (topic, schemaName, message) => {{
  if (!writers.has(topic)) writers.set(topic, client.advertise({{ topic, encoding: 'json', schemaName }}));
  client.sendMessage(writers.get(topic), new TextEncoder().encode(JSON.stringify(message)));
}};
"""


class JsViewer:
    """The client library in a process of node's.

    Attributes:
        process: It.
    """

    def __init__(self, process: ros.RosProcess) -> None:
        self.process = process
        self._seen = 0

    def next(self, kind: str, *more: Any, seconds: float = 30.0) -> list[Any]:
        """The next line of that kind that begins so; those before it are left out."""
        end = time.monotonic() + seconds
        while True:
            for line in self.process.lines_after(self._seen, max(0.0, end - time.monotonic())):
                self._seen += 1
                if not line.startswith("["):
                    raise AssertionError(f"the client says: {line}")
                values: list[Any] = json.loads(line)
                if values[0] == "error":
                    raise AssertionError(f"the client says: {values}")
                if values[0] == kind and values[1 : 1 + len(more)] == list(more):
                    return values[1 + len(more) :]
            assert time.monotonic() < end, f"no {kind} {more}: {self.process.output[-2000:]}"
            assert self.process.running, f"the client ended: {self.process.output[-2000:]}"


@contextmanager
def viewer(
    server: Foxglove,
    *topics: str,
    then: str = "",
    protocol: str = "FoxgloveClient.SUPPORTED_SUBPROTOCOL",
    url: str = "",
    ca: str | None = None,
) -> Iterator[JsViewer]:
    for module in MODULES:
        web_peers.npm_module(module)
    folder = web_peers.npm_module(MODULES[0]).parent
    program = CLIENT.format(
        modules=folder,
        url=url or server.url,
        protocol=protocol,
        topics=json.dumps(topics),
        ca="undefined" if ca is None else json.dumps(ca),
    )
    program += then
    with web_peers.start_module(program) as process:
        yield JsViewer(process)


TWIST = json.dumps(Twist._full_text)
ROSPY = """
import rospy
from geometry_msgs.msg import PoseStamped
from std_srvs.srv import SetBool
rospy.init_node("robot", disable_signals=True)
pub = rospy.Publisher("/goal_pose", PoseStamped, queue_size=1, latch=True)
message = PoseStamped()
message.header.frame_id = "map"
message.header.stamp = rospy.Time(12, 34)
message.pose.position.x = 1e-300
message.pose.orientation.w = -1.5
pub.publish(message)
rospy.Service("/switch", SetBool, lambda request: (not request.data, "was %s" % request.data))
rospy.set_param("/robot/speed", 0.25)
rospy.set_param("/robot/names", ["a", "b"])
rospy.spin()
"""


@pytest.mark.parametrize("protocol", ["FoxgloveClient.SUPPORTED_SUBPROTOCOL", "'foxglove.sdk.v1'"])
def test_a_rospy_robot(any_master: str, protocol: str, genpy_packages: Path) -> None:
    """A latched message, a service, parameters and the graph; the library offers its own name of the protocol, or
    today's; rospy has a subscriber only while it is wanted.
    """
    with (
        ros.start_rospy(ROSPY, any_master, packages=genpy_packages),
        Node("/gateway", master_uri=any_master, rosout=False) as node,
    ):
        then = """
        client.on('open', () => {
          client.getParameters(['/robot/speed', '/robot/names'], 'asked');
          client.subscribeConnectionGraph();
        });
        calls['/switch'] = {data: true};
        """
        node.wait_for_service("/switch", timeout=60)
        with Foxglove(node, port=0, access=Access(write=["/switch"])) as server:
            assert "/goal_pose" not in node.master.get_system_state().subscribers
            with viewer(server, "/goal_pose", then=then, protocol=protocol) as client:
                (info,) = client.next("info")
                assert info["supportedEncodings"] == ["json", "ros1"]
                (message,) = client.next("message", "/goal_pose")
            with viewer(server, then=then, protocol=protocol) as client:
                (values,) = client.next("parameters", "asked")
            with viewer(server, then=then, protocol=protocol) as client:
                (answer,) = client.next("answer")
            with viewer(server, then=then, protocol=protocol) as client:
                while True:
                    (graph,) = client.next("graph")
                    if any(one["name"] == "/goal_pose" for one in graph["publishedTopics"]):
                        break
            end = time.monotonic() + 20
            while "/goal_pose" in node.master.get_system_state().subscribers:
                assert time.monotonic() < end, "it is still followed"
                time.sleep(0.05)
    assert message == {
        "header": {"seq": message["header"]["seq"], "stamp": {"sec": 12, "nsec": 34}, "frame_id": "map"},
        "pose": {
            "position": {"x": 1e-300, "y": 0, "z": 0},
            "orientation": {"x": 0, "y": 0, "z": 0, "w": -1.5},
        },
    }
    assert {one["name"]: one["value"] for one in values} == {"/robot/speed": 0.25, "/robot/names": ["a", "b"]}
    assert answer == {"success": False, "message": "was True"}
    assert {"name": "/goal_pose", "publisherIds": ["/robot"]} in graph["publishedTopics"]


@pytest.mark.parametrize("type_name", TYPES)
def test_a_roscpp_robot(any_master: str, roscpp_peer: Path, type_name: str) -> None:
    """What a roscpp node publishes, read by the library's decoder with the definition that came with the channel."""
    message = sample(type_name)
    with (
        ros.start_program(roscpp_peer, any_master, "topic_echo", type_name),
        Node("/ours", master_uri=any_master, rosout=False) as node,
        Node("/gateway", master_uri=any_master, rosout=False) as gateway,
        Foxglove(gateway, port=0) as server,
    ):
        publisher = node.publisher("/in", type_name)
        publisher.wait_for_connection(60)
        with viewer(server, "/out") as client:
            eventually(
                lambda: any(link.topic == "/out" and link.connected for link in gateway.stats().links), 60
            )
            publisher.publish(message)  # once: a picture is megabytes of JSON, and its pieces no messages
            (received,) = client.next("message", "/out", seconds=60.0)
        assert same(received, message), (received, message)


def same(theirs: Any, ours: Any) -> bool:
    """Whether a decoded object of theirs and a message of ours have the same values."""
    if hasattr(ours, "secs"):
        return bool(theirs == {"sec": ours.secs, "nsec": ours.nsecs})
    if hasattr(ours, "__slots__"):
        return set(theirs) == set(ours.__slots__) and all(
            name == "seq" or same(theirs[name], getattr(ours, name)) for name in ours.__slots__
        )
    if isinstance(ours, (bytes, bytearray)):
        return theirs == list(ours)
    if hasattr(ours, "tolist"):
        ours = ours.tolist()
    if isinstance(ours, (list, tuple)):
        return len(theirs) == len(ours) and all(map(same, theirs, ours))
    if isinstance(ours, float):  # JSON has no word for what is not a number
        return (
            theirs is None if ours != ours or ours in (float("inf"), float("-inf")) else bool(theirs == ours)
        )
    if isinstance(theirs, str) and isinstance(ours, int):  # of 64 bits, which JSON's numbers do not hold
        return theirs == str(ours)
    return bool(theirs == ours)


def test_the_simulated_chassis() -> None:
    """Each kind of its topics: what the library's decoder reads is what ours reads of the same message."""
    topics = ("/scan", "/odom", "/battery", "/tf_static", "/woosh/overlay", "/woosh/map", "/driver_base/bms")
    with SimulatedChassis() as sim, Chassis(sim.master_uri) as chassis, ChassisTopics(chassis) as made:
        kept: dict[str, dict[str, Any]] = {"/scan": {}, "/odom": {}, "/battery": {}}
        for topic, by_stamp in kept.items():
            chassis.node.subscriber(
                topic,
                callback=lambda m, k=by_stamp: k.__setitem__(
                    f"{m.header.stamp.secs}.{m.header.stamp.nsecs}", m
                ),
            )
        with Foxglove(chassis.node, port=0, topics=made.all) as server, viewer(server, *topics) as client:
            for topic in topics:
                with viewer(server, topic) as client:
                    (message,) = client.next("message", topic)
                    if topic in kept:
                        stamp = f"{message['header']['stamp']['sec']}.{message['header']['stamp']['nsec']}"
                        end = time.monotonic() + 10
                        while stamp not in kept[topic]:
                            assert time.monotonic() < end, f"{topic}: ours has none of {stamp}"
                            time.sleep(0.02)
                        assert same(message, kept[topic][stamp]), topic
                    elif topic == "/woosh/map":
                        assert len(message["data"]) == message["info"]["width"] * message["info"]["height"]
                    elif topic == "/woosh/overlay":
                        assert isinstance(message["markers"], list)


def moved(chassis: Chassis, so: Callable[[float], bool]) -> None:
    """Wait until the chassis measures such a velocity."""
    end = time.monotonic() + 20
    while (now := chassis.measured_velocity.latest) is None or not so(now.vx):
        assert time.monotonic() < end, f"it drives {now}"
        time.sleep(0.05)


def test_driving_the_simulated_chassis(tmp_path: Path) -> None:
    """Refused with a sentence; opened by a pattern it drives, by the bytes of ROS or by JSON, also over wss, and
    stands still when the client has gone.
    """
    pytest.importorskip("cryptography", reason="it makes the certificate")
    twist = "{linear: {x: 0.2, y: 0, z: 0}, angular: {x: 0, y: 0, z: 0}}"
    as_ros1 = f"publish('/smooth_cmd_vel', 'geometry_msgs/Twist', {TWIST}, {twist})"
    as_json = f"publishJson('/smooth_cmd_vel', 'geometry_msgs/Twist', {twist})"

    def then(publish: str) -> str:
        return f"client.on('serverInfo', () => {{ setInterval(() => {publish}, 50); }});"

    cert, key = certificate(tmp_path)
    tls = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    tls.load_cert_chain(cert, key)
    ca = Path(cert).read_text("ascii")
    with SimulatedChassis() as sim, Chassis(sim.master_uri) as chassis:
        with Foxglove(chassis.node, port=0) as server, viewer(server, then=then(as_ros1)) as client:
            (text,) = client.next("status")
            assert "--allow-write topic:/smooth_cmd_vel" in text
            moved(chassis, lambda vx: vx == 0.0)
        access = Access(write=driving_patterns())
        for publish, more in ((as_ros1, {}), (as_json, {"tls": tls, "token": "of+many&letters"})):
            with Foxglove(chassis.node, port=0, access=access, **more) as server:
                url = server.url.replace("127.0.0.1", "localhost") + (
                    "/?token=of%2Bmany%26letters" if more else ""
                )
                with viewer(server, then=then(publish), url=url, ca=ca if more else None) as client:
                    client.next("info")
                    moved(chassis, lambda vx: vx > 0.15)
                moved(chassis, lambda vx: abs(vx) < 0.001)
                end = time.monotonic() + 10
                while server.stats().zeros < 5:
                    assert time.monotonic() < end, server.stats()
                    time.sleep(0.02)
