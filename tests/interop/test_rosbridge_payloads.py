"""What the protocol writes, read by roslib's own transport as its makers ship it: text, pictures, fragments, CBOR."""

from __future__ import annotations

import base64
import json
import math
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from rosproto.codec import message_class
from rosproto.gateway import GatewayLimits
from rosproto.gateway.rosbridge import cbor, png
from rosproto.gateway.rosbridge.operations import Payload
from rosproto.gateway.rosbridge.protocol import Protocol, publish_text
from rosproto.gateway.values import to_json
from tests.support import ros
from tests.support.extras import needs
from tests.support.rosbridge_values import to_values
from tests.support.web_peers import npm_module

needs("bridge")

READER = """
const { AbstractTransport } = await import(process.argv[1]);
const lines = (await import("node:fs")).readFileSync(0, "utf8").split("\\n").filter(line => line);
class Transport extends AbstractTransport {}
const plain = (key, value) => ArrayBuffer.isView(value)
  ? { kind: value.constructor.name, items: Array.from(value, item => typeof item === "bigint" ? `${item}` : item) }
  : value;
for (const line of lines) {
  const transport = new Transport();
  const seen = [];
  transport.on("message", message => seen.push(message));
  transport.on("error", error => seen.push({ error: `${error} ${error.cause}` }));
  for (const payload of JSON.parse(line)) {
    if (payload.text !== undefined) { transport.handleRawMessage(payload.text); continue; }
    const bytes = Uint8Array.from(Buffer.from(payload.binary, "base64"));
    transport.handleRawMessage(bytes.buffer);
  }
  console.log(JSON.stringify(seen, plain));
}
"""


def odometry() -> Any:
    message = message_class("nav_msgs/Odometry")()
    message.header.frame_id = "Wüste 地图"
    message.pose.pose.position.x = 0.1
    message.pose.covariance[3] = math.nan
    return message


def joints() -> Any:
    return message_class("sensor_msgs/JointState")(name=["a", "ä"], position=[1.5, -2], velocity=[math.inf])


def picture() -> Any:
    return message_class("sensor_msgs/CompressedImage")(format="png", data=bytes(range(256)))


def read_by_roslib(*conversations: tuple[Payload, ...]) -> list[Any]:
    """For each conversation the one message that roslib makes of its payloads."""
    roslib = npm_module("roslib/dist/RosLib.js")
    asked = "\n".join(json.dumps([_as_json(payload) for payload in payloads]) for payloads in conversations)
    done = subprocess.run(
        [shutil.which("node") or "node", "--input-type=module", "-e", READER, Path(roslib).as_uri()],
        input=asked,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        env=ros.clean_environment(),
    )
    assert done.returncode == 0, done.stderr[-2000:]
    answers = [json.loads(line) for line in done.stdout.splitlines()]
    assert [len(answer) for answer in answers] == [1] * len(conversations), answers
    return [answer[0] for answer in answers]


def _as_json(payload: Payload) -> dict[str, str]:
    if isinstance(payload, str):
        return {"text": payload}
    return {"binary": base64.b64encode(payload).decode()}


@pytest.mark.parametrize("make", [odometry, joints, picture])
def test_text_pictures_and_fragments(make: Any) -> None:
    """Each is the same message; also a picture in fragments, and two messages' fragments under ids of their own."""
    message = make()
    text = publish_text("/t", to_json(message))
    protocol = Protocol(GatewayLimits())
    first, second = protocol.split(text, 50), protocol.split(png.publish_png(text), 60)
    assert min(len(first), len(second)) > 2
    seen = read_by_roslib((text,), (png.publish_png(text),), first, second, first[::-1])
    assert seen == [{"op": "publish", "topic": "/t", "msg": to_values(message)}] * 5


def test_cbor() -> None:
    """Arrays of numbers are JavaScript's typed arrays, octets too; NaN stays one."""
    odom, joint, image = read_by_roslib(
        *((cbor.publish_cbor("/t", make()),) for make in (odometry, joints, picture))
    )
    assert odom["msg"]["header"]["frame_id"] == "Wüste 地图"
    assert odom["msg"]["pose"]["pose"]["position"] == {"x": 0.1, "y": 0, "z": 0}
    assert odom["msg"]["pose"]["covariance"] == {"kind": "Float64Array", "items": [0, 0, 0, None] + [0] * 32}
    assert joint["msg"]["name"] == ["a", "ä"]
    assert joint["msg"]["position"] == {"kind": "Float64Array", "items": [1.5, -2]}
    assert image["msg"]["data"] == {"kind": "Uint8Array", "items": list(range(256))}


def test_cbor_raw() -> None:
    """ROS's own bytes."""
    (seen,) = read_by_roslib((cbor.publish_cbor_raw("/t", 1, 2, b"\x00\xff"),))
    assert seen["msg"] == {"secs": 1, "nsecs": 2, "bytes": {"kind": "Uint8Array", "items": [0, 255]}}


def test_every_kind_of_typed_array() -> None:
    """The tags of all ten are known to it."""
    kinds = {
        "Int8": "Int8Array", "Int16": "Int16Array", "UInt16": "Uint16Array", "Int32": "Int32Array",
        "UInt32": "Uint32Array", "Int64": "BigInt64Array", "UInt64": "BigUint64Array", "Float32": "Float32Array",
        "Float64": "Float64Array", "Byte": "Int8Array",
    }  # fmt: skip
    messages = [message_class(f"std_msgs/{kind}MultiArray")(data=[1, 2, 100]) for kind in kinds]
    seen = read_by_roslib(*((cbor.publish_cbor("/t", message),) for message in messages))
    assert [answer["msg"]["data"]["kind"] for answer in seen] == list(kinds.values())
    assert {tuple(map(float, answer["msg"]["data"]["items"])) for answer in seen} == {(1.0, 2.0, 100.0)}
