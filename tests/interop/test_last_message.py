"""`Publisher.close(wait=...)` before rospy and roscpp: all messages arrive, though the topic is given up at once.

Without `wait` they may lose some: told by the master that the publisher is gone, both disconnect.
"""

from __future__ import annotations

from pathlib import Path

from rosproto.master import Master
from rosproto.node import Node
from tests.support import ros

BUSY = """
import time, rospy
from std_msgs.msg import String
def heard(message):
    time.sleep(0.02)
    print("heard", message.data.split()[0], flush=True)
rospy.init_node("busy", disable_signals=True)
rospy.Subscriber("/chatter", String, heard)
print("up", flush=True)
rospy.spin()
"""


def publish_and_close(master: Master, count: int, padding: str) -> None:
    with Node("/ours", master_uri=master.uri) as node:
        publisher = node.publisher("/chatter", "std_msgs/String", queue_size=count)
        publisher.wait_for_connection(60)
        for number in range(count):
            publisher.publish(data=f"{number}{padding}")
        publisher.close(wait=60)
        assert not node.master.get_system_state().publishers.get("/chatter")


def test_a_busy_rospy_subscriber_receives_everything(our_master: Master, genpy_packages: Path) -> None:
    with ros.start_rospy(BUSY, our_master.uri, packages=genpy_packages) as process:
        process.wait_for("up")
        publish_and_close(our_master, 20, " " + "x" * 50_000)
        process.wait_for("heard 19\n")
        heard = [line.split()[1] for line in process.output.splitlines() if line.startswith("heard ")]
        assert heard == [str(number) for number in range(20)]


def test_a_roscpp_subscriber_receives_everything(our_master: Master, roscpp_peer: Path) -> None:
    """As many as its queue takes. It prints a text up to its first NUL."""
    with ros.start_program(roscpp_peer, our_master.uri, "cpp_node") as process:
        process.wait_for("cpp up")
        publish_and_close(our_master, 10, "\0" + "x" * 2_000_000)
        process.wait_for("cpp heard 9\n")
        heard = [line.split()[2] for line in process.output.splitlines() if line.startswith("cpp heard ")]
        assert heard == [str(number) for number in range(10)]
