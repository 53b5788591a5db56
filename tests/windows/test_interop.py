"""CPython for Windows (under Wine) against Linux: the simulator, and rospy, in both directions.

Skipped where Wine is not installed; fails instead with REQUIRE_INTEROP=1. What Wine cannot prove: README.md here.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from rosproto.master import Master
from tests.support import ros
from woosh_pure import SimulatedChassis

HERE = Path(__file__).resolve().parent
RUN = str(HERE / "run")
WINE = Path("/usr/lib/wine/wine64")

# One worker runs them all: Wine's server handles the sockets of all Windows processes in one thread.
pytestmark = [
    pytest.mark.interop,
    pytest.mark.slow,
    pytest.mark.timeout(300),
    pytest.mark.skipif(sys.platform == "win32", reason="this is the Linux side"),
]

ROSPY = """
import sys, time, rospy, actionlib
from std_msgs.msg import String, Empty
from std_srvs.srv import SetBool, SetBoolResponse
from sensor_msgs.msg import PointCloud2
from actionlib.msg import TestAction, TestGoal, TestResult
rospy.init_node("rospy_side", disable_signals=True)
def say(*words): print(*map(ascii, words), flush=True)
def execute(goal):
    server.set_succeeded(TestResult(result=goal.goal * 2), "done by rospy")
server = actionlib.SimpleActionServer("/ros/act", TestAction, execute, auto_start=False)
server.start()
rospy.Service("/ros/set", SetBool, lambda q: SetBoolResponse(True, "rospy %s" % q.data))
words = rospy.Publisher("/ros/words", String, queue_size=1, latch=True)
words.publish("from rospy: \\u8d27\\u67b6")
cloud = rospy.Publisher("/ros/cloud", PointCloud2, queue_size=1, latch=True)
cloud.publish(PointCloud2(data=bytes(range(256)) * 4096))
quit = rospy.Publisher("/win/quit", Empty, queue_size=1, latch=True)
say("heard", rospy.wait_for_message("/win/latched", String, 60).data)
rospy.wait_for_service("/win/set", 20)
proxy = rospy.ServiceProxy("/win/set", SetBool)
say("answered", proxy(True).message, proxy(False).success)
client = actionlib.SimpleActionClient("/win/act", TestAction)
assert client.wait_for_server(rospy.Duration(30))
client.send_goal(TestGoal(goal=4))
assert client.wait_for_result(rospy.Duration(30))
say("result", client.get_result().result, client.get_goal_status_text())
quit.publish()
time.sleep(60)
"""


@pytest.fixture(scope="module", autouse=True)
def windows_python(tmp_path_factory: pytest.TempPathFactory) -> None:
    """The interpreter is set up; beforehand, because that reaches other machines."""
    ros.require(WINE.exists(), f"there is no {WINE} (Debian: apt-get install wine wine64)")
    home = Path(os.environ["WOOSH_WINDOWS"]) / os.environ.get("WOOSH_WINDOWS_PYTHON", "3.11")
    if home.exists():
        with ros.exclusive(Path(f"{home}.lock")):  # somebody may be setting it up
            pass
    ros.require((home / "ready").exists(), "CPython for Windows is not set up: tests/windows/run python -V")
    base = tmp_path_factory.getbasetemp().parent
    with ros.exclusive(base / "windows.lock"):
        done = subprocess.run(
            [RUN, "python", "-c", "import sys, numpy, lz4; print(sys.platform)"],
            stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=280, check=False,
        )  # fmt: skip
    assert done.stdout.strip() == "win32", done.stdout + done.stderr


def windows(*arguments: str, **variables: str) -> ros.RosProcess:
    """A Python program on Windows, in the background, in the set-up that `windows_python` has made or found."""
    where = {key: value for key, value in os.environ.items() if key.startswith("WOOSH_WINDOWS")}
    return ros.RosProcess([RUN, "python", *arguments], ros.clean_environment() | where | variables)


def test_a_chassis_on_windows_drives_the_simulator_on_linux() -> None:
    """State, an action with feedback, velocities and a task with its service call, over TCP."""
    with SimulatedChassis(speed=4) as sim, windows(str(HERE / "peer.py"), "chassis", sim.master_uri) as peer:
        for fact in (r"'battery' 8\d", "'moved'", "'driven'", "'arrived' 3 1", r"'leftovers' \[\]"):
            peer.wait_for(fact, timeout=90)
        assert peer.wait(timeout=30) == 0


@pytest.mark.parametrize("whose", ["ours", "debian"])
def test_windows_and_rospy_serve_each_other(whose: str, genpy_packages: Path) -> None:
    """Publisher, subscriber, service and action, client and server, through our master and through Debian's."""
    ros.require_ros("actionlib")
    if whose == "debian":
        with ros.start_real_master() as uri:
            serve_each_other(uri, genpy_packages)
    else:
        with Master() as master:
            serve_each_other(master.uri, genpy_packages)


def serve_each_other(master_uri: str, packages: Path) -> None:
    with windows(str(HERE / "peer.py"), "graph", master_uri) as peer:
        peer.wait_for("'up'", timeout=60)
        with ros.start_rospy(ROSPY, master_uri, packages=packages) as rospy:
            for fact in (
                r"'heard' 'from Windows: \\u8d27\\u67b6'",
                "'answered' 'windows True' False",
                "'result' 8 'done on Windows'",
            ):
                rospy.wait_for(fact, timeout=90)
            for fact in (
                r"'heard' 'from rospy: \\u8d27\\u67b6'",
                f"'cloud' 1048576 {sum(range(256)) * 4096}",
                "'answered' 'rospy True'",
                "'result' 42 'done by rospy'",
                "'quit' True",
                r"'leftovers' \[\]",
            ):
                peer.wait_for(fact, timeout=90)
            assert peer.wait(timeout=30) == 0


def test_the_demo_runs_on_windows() -> None:
    """`woosh demo`: simulator, master and chassis in one Windows process; its output fits a cp1252 pipe."""
    with windows("-m", "woosh_pure", "demo") as demo:
        demo.wait_for("done in", timeout=150)
        assert demo.wait(timeout=30) == 0
        assert "Traceback" not in demo.output


def test_every_command_prints_what_the_encoding_can() -> None:
    """A drawing of characters that cp1252 lacks (a tree of frames, bars) must not end in UnicodeEncodeError."""
    with SimulatedChassis(speed=4) as sim:
        env = {"ROS_MASTER_URI": sim.master_uri, "PYTHONIOENCODING": "cp1252"}
        for command in (["tf", "tree"], ["topic", "list"], ["graph"]):
            with windows("-m", "rosproto", *command, **env) as process:
                process.wait(timeout=60)
                assert "UnicodeEncodeError" not in process.output, process.output
                assert process.process.returncode == 0, process.output
