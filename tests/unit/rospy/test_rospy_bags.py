"""What rosbag.Bag tells of itself; in a process."""

from __future__ import annotations

from pathlib import Path

from tests.support.bag_setters import BAG_SETTERS
from tests.support.rospy_program import output


def test_a_bag_tells_what_rosbag_info_tells_and_answers_when_closed(tmp_path: Path) -> None:
    """print(bag), the YAML that programs take from `_get_yaml_info`, and counts after `with`."""
    code = """
        import os
        import rosbag
        from genpy import Time
        from std_msgs.msg import String

        os.chdir(os.path.dirname(os.path.abspath(__file__)))
        with rosbag.Bag("told.bag", "w") as bag:
            for i in range(3):
                bag.write("/said", String("x"), Time(10 + i))
            print(str(bag).splitlines()[-1].split())
        print(bag.get_message_count(), bag.get_start_time(), bag.get_end_time())
        print(bag.get_type_and_topic_info("/said").topics["/said"])
        bag = rosbag.Bag("told.bag")
        print(bag._get_yaml_info().splitlines()[2:5], bag._get_yaml_info(key="messages"))
        print(bag._get_yaml_info(key="nothing"))
        bag.close()
        for wrong in (lambda: bag.size, lambda: list(bag), lambda: rosbag.Bag("no/such/folder.bag", "w")):
            try:
                wrong()
            except (ValueError, OSError) as error:
                print(type(error).__name__)
        print(rosbag.ROSBagException.__module__)
    """
    assert output(code, tmp_path).splitlines() == [
        "['topics:', '/said', '3', 'msgs', '@', '1.0', 'Hz', ':', 'std_msgs/String']",
        "3 10.0 12.0",
        "TopicTuple(msg_type='std_msgs/String', message_count=3, connections=1, frequency=1.0)",
        "['duration: 2.000000', 'start: 10.000000', 'end: 12.000000'] 3",
        "None",
        "ValueError",
        "ValueError",
        "FileNotFoundError",
        "rosbag.bag",
    ]


def test_compression_and_chunk_threshold_can_be_set_while_writing(tmp_path: Path) -> None:
    """Each setting ends the open chunk; wrong values and closed bags are refused."""
    assert output(BAG_SETTERS, tmp_path).splitlines() == [
        "compression compression must be one of: none, bz2, lz4",
        "chunk_threshold chunk_threshold must be greater than or equal to zero",
        "[('chunk_threshold', 160), ('compression', 'none')]",
        "compression I/O operation on closed bag",
        "chunk_threshold I/O operation on closed bag",
        "lz4 27",
        "[('none', '5/8'), ('bz2', '2/8'), ('lz4', '1/8')]",
        str(
            [("x", 1 + 10 * at + i) for at in range(4) for i in range(5)]
            + [("y", 100 + i) for i in range(6)]
            + [("z", 200)]
        ),
    ]
