"""Names that rospy and the masters take although they are not legal: `/camera-1/image` is in somebody's graph."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from rosproto.node import Node
from tests.support import ros

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = """
import rospy, warnings
from std_msgs.msg import String
from std_srvs.srv import Trigger, TriggerResponse
rospy.init_node("odd", disable_signals=True)
rospy.set_param("/3d.scale", 2)
heard = rospy.Publisher("/a-b/heard", String, latch=True, queue_size=1)
rospy.Subscriber("/a-b", String, lambda m: heard.publish(m.data + " " + rospy.get_param("/ours-1")))
rospy.Service("/do-it", Trigger, lambda _: TriggerResponse(True, "done"))
print("up", flush=True)
rospy.spin()
"""


@pytest.mark.parametrize("program_is_ours", [False, True], ids=["rospy", "the rospy layer"])
def test_topics_services_and_parameters(
    any_master: str,
    program_is_ours: bool,
    genpy_packages: Path,
    tmp_path: Path,
    caplog: pytest.LogCaptureFixture,
) -> None:
    path = tmp_path / "odd.py"
    path.write_text(PROGRAM)
    start = [sys.executable, "-m", "rosproto", "run"] if program_is_ours else [ros.PYTHON]
    environment = ros.environment(any_master, packages=ROOT if program_is_ours else genpy_packages)
    with (
        ros.RosProcess([*start, str(path)], environment) as process,
        Node("/me", master_uri=any_master) as node,
    ):
        node.params["/ours-1"] = "and a parameter"
        publisher = node.publisher("/a-b", "std_msgs/String")
        heard = node.subscriber("/a-b/heard", "std_msgs/String")
        process.wait_for("up", 60)
        publisher.wait_for_connection(60)
        publisher.publish(data="a word")
        assert heard.next(60).data == "a word and a parameter"
        assert node.service_client("/do-it", "std_srvs/Trigger").call(timeout=60).message == "done"
        assert node.params["/3d.scale"] == 2
    assert caplog.text.count("/do-it is not a legal ROS name; roscpp and some tools refuse it") == 1
