"""Sequences given as what genpy only walks through: bytes for numbers, a text or a dict for texts."""

from io import BytesIO

from nav_msgs.msg import OccupancyGrid
from sensor_msgs.msg import JointState
from std_msgs.msg import ByteMultiArray, Float64MultiArray, Int32MultiArray, String, UInt16MultiArray


def sent(message):
    buffer = BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


for cls, fields in (
    (OccupancyGrid, {"data": bytearray(b"\x00\x64")}),
    (OccupancyGrid, {"data": b"\x00\x64"}),
    (OccupancyGrid, {"data": "ab"}),
    (UInt16MultiArray, {"data": b"ab"}),
    (Int32MultiArray, {"data": bytearray(b"ab")}),
    (Float64MultiArray, {"data": b"a"}),
    (ByteMultiArray, {"data": b"ab"}),
    (JointState, {"name": "ab"}),
    (JointState, {"name": {"j": 1}}),
    (JointState, {"name": [5]}),
):
    message = cls(**fields)
    try:
        print(cls.__name__, fields, sent(message))
    except Exception as error:
        print(cls.__name__, fields, type(error).__module__, type(error).__name__, error)
    print([getattr(message, name) == value for name, value in fields.items()])

print(repr(String().deserialize(b"\x01\x00\x00\x00abc")))
