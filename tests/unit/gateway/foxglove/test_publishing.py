"""What viewers publish as JSON, as their Publish, Teleop and 3-D panels do."""

from __future__ import annotations

import json
from typing import Any

import pytest

from msgdefs.geometry_msgs.msg import PoseStamped, Twist, Vector3
from msgdefs.sensor_msgs.msg import CompressedImage
from msgdefs.std_msgs.msg import String
from rosproto.codec import encode
from rosproto.gateway import Access, GatewayLimits
from rosproto.time import Time
from tests.support.foxglove_ground import Ground, until

pytest.importorskip("websockets", reason="websockets is not installed")


def as_json(value: Any) -> bytes:
    return json.dumps(value).encode()


def test_json_beside_the_bytes_of_ros(ground: Ground) -> None:
    """Both are offered, JSON first; times as viewers write them; a type named as ROS 2 does; ROS bytes as before."""
    poses = ground.robot.subscriber("/goal", PoseStamped)
    pictures = ground.robot.subscriber("/picture", CompressedImage)
    texts = ground.robot.subscriber("/say", String)
    viewer = ground.view(ground.serve(access=Access(write=["*"])))
    assert viewer.info["supportedEncodings"] == ["json", "ros1"]
    goal = viewer.advertise("/goal", "geometry_msgs/msg/PoseStamped", encoding="json")
    picture = viewer.advertise("/picture", "sensor_msgs/CompressedImage", encoding="json")
    say = viewer.advertise("/say", "std_msgs/String", encoding="ros1")
    for heard in (poses, pictures, texts):
        heard.wait_for_connection(5)
    header = {"seq": 0, "stamp": {"sec": 12, "nsec": 34}, "frame_id": "map"}
    pose = {"position": {"x": 1, "y": 2.5, "z": 0}, "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}}
    viewer.publish(goal, as_json({"header": header, "pose": pose}))
    came = poses.next(5)
    assert (came.header.stamp, came.header.frame_id) == (Time(12, 34), "map")
    assert (came.pose.position.x, came.pose.position.y, came.pose.orientation.w) == (1.0, 2.5, 1.0)
    viewer.publish(picture, as_json({"format": "png", "data": [1, 2, 255]}))
    assert bytes(pictures.next(5).data) == b"\x01\x02\xff"
    viewer.publish(say, encode(String(data="as before")))
    assert texts.next(5).data == "as before"


def test_a_schema_of_json_is_no_definition(ground: Ground) -> None:
    """The type is known here by its name; a JSON schema beside it is left unread."""
    heard = ground.robot.subscriber("/say", String)
    viewer = ground.view(ground.serve(access=Access(write=["*"])))
    channel = {
        "id": 7, "topic": "/say", "encoding": "json", "schemaName": "std_msgs/String",
        "schemaEncoding": "jsonschema", "schema": '{"type": "object"}',
    }  # fmt: skip
    viewer.send("advertise", channels=[channel])
    heard.wait_for_connection(5)
    viewer.publish(7, as_json({"data": "grüß dich"}))
    assert heard.next(5).data == "grüß dich"


WRONG = (
    (b"{", "not JSON"),
    (b"\xff", "not UTF-8 text"),
    (b"[" * 99_999, "inside one another"),
    (b"[" * 100_001, "values and keys"),
    (b"", "is empty"),
    (b'{"linear": {"x": ' + b"9" * 5000 + b"}}", "digits"),
    (as_json({"linear": {"x": "fast"}}), "linear.x"),
    (as_json({"speed": 1}), "has no field 'speed'"),
    (b'{"linear": {"x": NaN}}', "not finite"),
    (b'{"linear": {"x": 1e999}}', "not finite"),
    (b'{"linear": {"x": 1e308}}', "which is larger than 1000"),
)


@pytest.mark.promise(
    "A message is bounded in bytes, in nesting, and in its values and keys",
    "does not publish a velocity with a number that is not finite",
)
def test_json_that_fits_nothing(ground: Ground) -> None:
    """Is answered with a sentence each; nothing of it is published, and the next message is."""
    heard = ground.robot.subscriber("/cmd_vel", Twist)
    viewer = ground.view(ground.serve(access=Access(write=["*"])))
    channel = viewer.advertise("/cmd_vel", "geometry_msgs/Twist", encoding="json")
    heard.wait_for_connection(5)
    for data, words in WRONG:
        viewer.publish(channel, data)
        if words != "not finite":
            assert "/cmd_vel" in viewer.status(words)
    viewer.status("not finite")  # the same sentence is told once in a while
    viewer.publish(channel, as_json({"linear": {"x": 0.25}}))
    assert heard.next(5) == Twist(linear=Vector3(x=0.25))


def test_what_is_too_long_ends_the_connection(ground: Ground, caplog: pytest.LogCaptureFixture) -> None:
    """It is not even read; less may be read where nothing may be written. The log names the option."""
    closed = pytest.importorskip("websockets.exceptions").ConnectionClosed
    limits = GatewayLimits(message_bytes=100_000)
    for access, most in ((Access(write=["*"]), 100_000), (Access(), 64 << 10)):
        viewer = ground.view(ground.serve(access=access, limits=limits))
        viewer.publish(7, bytes(most - 5))
        assert "channel 7 is not advertised" in viewer.status("nothing is published")
        viewer.publish(7, bytes(most - 4))
        with pytest.raises(closed) as ended:
            viewer.until(lambda: False)
        assert ended.value.rcvd.code == 1009
    assert "--message-bytes" in caplog.text


def test_other_encodings_are_refused(ground: Ground) -> None:
    """The refusal lists the accepted encodings."""
    viewer = ground.view(ground.serve(access=Access(write=["*"])))
    viewer.advertise("/say", "std_msgs/String", encoding="cdr")
    assert "json or ros1" in viewer.status("/say", "'cdr'")
    assert ground.publishers("/say") == []


def test_json_needs_a_pattern_like_everything(ground: Ground) -> None:
    """The type that is judged is the type that would be published, however it is written."""
    viewer = ground.view(ground.serve())
    channel = viewer.advertise("/cmd_vel", "geometry_msgs/msg/Twist", encoding="json")
    viewer.publish(channel, as_json({}))
    assert "--allow-write topic:/cmd_vel" in viewer.status("/cmd_vel", "refused")
    assert ground.publishers("/cmd_vel") == []


TWIST_OF_ONES_OWN = (
    "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n"
    + "=" * 80
    + "\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n"
)
OTHER_NAMES = (("geometry_msgs/Accel", ""), ("geometry_msgs/msg/Accel", ""), ("my/Thing", TWIST_OF_ONES_OWN))


@pytest.mark.promise(
    "does not publish a velocity with a number that is not finite",
    "leaves or is silent for half a second, the gateway sends zero",
    "The md5sum of a message decides whether it is a velocity",
)
@pytest.mark.parametrize(("name", "schema"), OTHER_NAMES)
@pytest.mark.parametrize("encoding", ["ros1", "json"])
def test_a_velocity_by_another_name_is_one(ground: Ground, name: str, schema: str, encoding: str) -> None:
    """Advertised before the robot's topic is in the graph, it is guarded, and zero follows when the viewer has gone."""
    viewer = ground.view(ground.serve(access=Access(write=["/base_cmd_vel"])))
    channel = viewer.advertise("/base_cmd_vel", name, schema, encoding)
    until(lambda: ground.publishers("/base_cmd_vel"), "it is advertised")
    heard = ground.robot.subscriber("/base_cmd_vel", Twist, queue_size=100)
    heard.wait_for_connection(5)

    def drive(speed: float) -> None:
        twist = Twist(linear=Vector3(x=speed))
        viewer.publish(channel, encode(twist) if encoding == "ros1" else as_json({"linear": {"x": speed}}))

    drive(float("nan"))
    viewer.status("/base_cmd_vel", "not finite")
    drive(1001.0)
    viewer.status("/base_cmd_vel", "larger than 1000")
    drive(0.25)
    assert heard.next(5) == Twist(linear=Vector3(x=0.25))
    viewer.close()
    assert [heard.next(5) for _ in range(5)] == [Twist()] * 5


@pytest.mark.promise("A topic that other nodes use is published with their type only")
@pytest.mark.parametrize(("name", "schema"), OTHER_NAMES)
def test_the_graph_says_what_a_topic_is(ground: Ground, name: str, schema: str) -> None:
    """A topic that other nodes use with a type is not advertised with another one."""
    ground.robot.subscriber("/base_cmd_vel", Twist)
    viewer = ground.view(ground.serve(access=Access(write=["/base_cmd_vel"])))
    viewer.advertise("/base_cmd_vel", name, schema)
    assert "/base_cmd_vel is of type geometry_msgs/Twist, not" in viewer.status("/base_cmd_vel")
    assert ground.publishers("/base_cmd_vel") == []


def test_a_type_that_nobody_uses_any_longer_binds_nobody(ground: Ground) -> None:
    """The master remembers the type of a topic after its last node has left."""
    ground.robot.publisher("/say", Twist).close()
    heard = ground.robot.subscriber("/listen", String)
    viewer = ground.view(ground.serve(access=Access(write=["*"])))
    viewer.advertise("/say", "std_msgs/String")
    until(lambda: ground.publishers("/say"), "it is advertised")
    viewer.publish(viewer.advertise("/listen", "std_msgs/String"), encode(String(data="a")))
    assert heard.next(5).data == "a"
