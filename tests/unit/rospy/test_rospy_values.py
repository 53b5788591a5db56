"""Values that genpy's generated code takes or refuses, taken and refused alike; each in a process."""

from __future__ import annotations

from pathlib import Path

from rosproto.master import Master
from tests.support.rospy_program import output

SEQUENCES = """
    from io import BytesIO

    from nav_msgs.msg import OccupancyGrid, Path
    from sensor_msgs.msg import JointState
    from std_msgs.msg import ByteMultiArray, Float64MultiArray, UInt16MultiArray

    def read_back(message):
        buffer = BytesIO()
        message.serialize(buffer)
        return type(message)().deserialize(buffer.getvalue())

    grid = OccupancyGrid(data=bytearray(b"\\x00\\x64"))
    print(read_back(grid).data, type(grid.data).__name__)
    print(read_back(UInt16MultiArray(data=b"ab")).data, read_back(Float64MultiArray(data=b"a")).data)
    print(read_back(ByteMultiArray(data=b"ab")).data)
    print(read_back(JointState(name="ab", position=[1])).name, read_back(JointState(name={"j": 1})).name)
    for wrong in (OccupancyGrid(data=b"\\xff"), OccupancyGrid(data="ab"), JointState(name=[5])):
        try:
            read_back(wrong)
        except Exception as error:
            print(type(error).__name__, error)
"""


def test_bytes_are_numbers_and_letters_are_texts(tmp_path: Path) -> None:
    """genpy's code walks through what is given for a sequence; the program's own message stays as it is."""
    assert output(SEQUENCES, tmp_path).splitlines() == [
        "(0, 100) bytearray",
        "(97, 98) (97.0,)",
        "(97, 98)",
        "['a', 'b'] ['j']",
        "SerializationError field data[] exceeds specified width [int8]",
        "SerializationError field data must be a list or tuple type. Only uint8[] can be a string",
        "SerializationError field name[] must be of type bytes or an ascii string",
    ]


def test_published_and_served_alike(tmp_path: Path) -> None:
    """The same on the way through a publisher and through a service, in both directions."""
    code = """
        import rospy
        from std_msgs.msg import ByteMultiArray
        from std_srvs.srv import Trigger
        from topic_tools.srv import MuxList, MuxListResponse

        rospy.init_node("values")
        pub = rospy.Publisher("/bytes", ByteMultiArray, latch=True, queue_size=1)
        pub.publish(data=b"ab")
        print(rospy.wait_for_message("/bytes", ByteMultiArray, 10).data)
        rospy.Service("/list", MuxList, lambda request: MuxListResponse("ab"))
        print(rospy.ServiceProxy("/list", MuxList)().topics)
        try:
            rospy.ServiceProxy("/list", Trigger)()
        except rospy.ServiceException as error:
            print(error)
    """
    with Master() as master:
        assert output(code, tmp_path, uri=master.uri).splitlines() == [
            "(97, 98)",
            "['a', 'b']",
            "unable to connect to service: remote error reported: request from [/values]: md5sums do not match: "
            "[937c9679a518e3a18d831e57125ea522] vs. [b0eef9a05d4e829092fc2f2c3c2aad3d]",
        ]


def test_what_follows_the_last_field_is_left_alone(tmp_path: Path) -> None:
    """`deserialize` of a buffer that is longer than the message; one that is too short is refused."""
    code = """
        from std_msgs.msg import Float64, Header, String
        print(String().deserialize(b"\\x01\\0\\0\\0abc"), Float64().deserialize(bytes(20)).data)
        for cls, data in ((Float64, bytes(7)), (Header, bytes(11))):
            try:
                cls().deserialize(data)
            except Exception as error:
                print(type(error).__name__)
    """
    assert output(code, tmp_path).splitlines() == [
        'data: "a" 0.0',
        "DeserializationError",
        "DeserializationError",
    ]


def test_text_that_is_not_utf_8_is_told_once_per_type(tmp_path: Path) -> None:
    """It is replaced, and the log names the type."""
    code = """
        import logging
        from std_msgs.msg import Header, String
        logging.getLogger("rosout").addHandler(logging.StreamHandler(__import__("sys").stdout))
        for cls, data in ((String, b""), (String, b""), (Header, bytes(12))):
            found = cls().deserialize(data + b"\\x01\\0\\0\\0\\xff")
        print(ascii(found.frame_id))
    """
    text = "Characters replaced when decoding message %s (will print only once): "
    lines = output(code, tmp_path).splitlines()
    assert [line.partition("'")[0] for line in lines[:-1]] == [
        text % "std_msgs/String",
        text % "std_msgs/Header",
    ]
    assert lines[-1] == "'\\ufffd'"


def test_a_reserved_name_is_spelled_with_an_underscore_everywhere(tmp_path: Path) -> None:
    """As in the class that genpy writes: in `__slots__`, by keyword, in texts; the bytes are the same."""
    code = """
        import copy, pickle
        from woosh_msgs.msg import NavMode

        mode = NavMode()
        mode.in_.x = 3
        print([name for name in NavMode.__slots__ if name.startswith("in")], str(mode).split()[6:9])
        print(NavMode(in_=mode.in_) == mode == copy.deepcopy(mode) == pickle.loads(pickle.dumps(mode)))
    """
    assert output(code, tmp_path).splitlines() == ["['in_'] ['in_:', 'x:', '3']", "True"]
