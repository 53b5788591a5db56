"""The master is killed with -9 and started again on its port: everybody of ours finds everybody again."""

from __future__ import annotations

import time

import pytest

from rosproto.node import Event, EventKind, MasterClient, Node
from tests.support import ros
from tests.support.load import crowd

OURS = "from rosproto.master import Master; import sys, time; Master(port=int(sys.argv[1])); time.sleep(600)"


def start_master(kind: str, port: int) -> ros.RosProcess:
    """A master in a process of its own."""
    import sys
    from pathlib import Path

    env = ros.environment(f"http://127.0.0.1:{port}")
    if kind == "ours":
        env["PYTHONPATH"] = str(Path(__file__).resolve().parents[2])
        return ros.RosProcess([sys.executable, "-c", OURS, str(port)], env)
    return ros.RosProcess([ros.PYTHON, str(ros.BIN / "rosmaster"), "--core", "-p", str(port)], env)


def wait_for_master(uri: str) -> float:
    """When it answered first, monotonic."""
    end = time.monotonic() + 30
    while time.monotonic() < end:
        try:
            with MasterClient(uri, "/test") as client:
                client.get_pid(timeout=1.0)
            return time.monotonic()
        except OSError:
            time.sleep(0.02)
    raise AssertionError("the master does not start")


@pytest.mark.promise("After the master was killed and started again")
@pytest.mark.parametrize("kind", ["ours", "debian"])
def test_everything_is_registered_again_within_two_seconds(kind: str, ros_installed: None) -> None:
    """Publisher, subscriber, service and parameter subscription; links meanwhile go on."""
    port = ros.free_port()
    uri = f"http://127.0.0.1:{port}/"
    events: list[Event] = []
    with start_master(kind, port) as first:
        wait_for_master(uri)
        with (
            Node("/a", master_uri=uri, on_event=events.append, intraprocess=False) as a,
            Node("/b", master_uri=uri) as b,
        ):
            publisher = a.publisher("/t", "std_msgs/String")
            subscriber = b.subscriber("/t", "std_msgs/String")
            a.service_server("/s", "std_srvs/Empty", lambda request: {})
            publisher.wait_for_connection()
            first.kill()
            publisher.publish(data="without a master")
            assert subscriber.next(60).data == "without a master"
            with start_master(kind, port):
                back = wait_for_master(uri)
                with MasterClient(uri, "/test") as master:
                    while True:
                        state = master.get_system_state()
                        if (
                            state.publishers.get("/t") == ["/a"]
                            and state.subscribers.get("/t") == ["/b"]
                            and "/s" in state.services
                        ):
                            break
                        assert time.monotonic() < back + 2.0 * crowd(), state
                        time.sleep(0.02)
                with Node("/c", master_uri=uri) as late:
                    assert late.subscriber("/t").connections >= 0
                    assert late.wait_for_service("/s") is None
    assert EventKind.MASTER_BACK in [event.kind for event in events]


TALKER = """
import rospy
from std_msgs.msg import UInt32
rospy.init_node("talker", disable_signals=True)
publisher = rospy.Publisher("/count", UInt32, queue_size=10)
print("up", flush=True)
number = 0
while True:
    number += 1
    publisher.publish(number)
    rospy.sleep(0.02)
"""


def test_a_rospy_publisher_that_never_registers_again_is_heard_on(ros_installed: None) -> None:
    """rospy and roscpp do not notice the restart; what is connected with them must not be given up for it."""
    port = ros.free_port()
    uri = f"http://127.0.0.1:{port}/"
    events: list[Event] = []
    with start_master("debian", port) as first:
        wait_for_master(uri)
        with ros.start_rospy(TALKER, uri) as talker, Node("/b", master_uri=uri, on_event=events.append) as b:
            talker.wait_for("^up$")
            subscriber = b.subscriber("/count", "std_msgs/UInt32")
            subscriber.next(60)
            first.kill()
            with start_master("debian", port):
                end = time.monotonic() + 30
                while EventKind.MASTER_BACK not in [event.kind for event in events]:
                    assert time.monotonic() < end, "not registered again"
                    subscriber.next(60)
                with MasterClient(uri, "/test") as master:
                    assert master.get_system_state().publishers.get("/count") is None
                last = subscriber.next(60).data
                for _ in range(50):
                    assert subscriber.next(60).data == last + 1
                    last += 1
                assert subscriber.connections == 1
