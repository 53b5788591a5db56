"""Subscribers of other kinds (rospy, roscpp) get nothing that is older than five seconds, and get new messages soon."""

from __future__ import annotations

import itertools
import os
import signal

import pytest

from tests.scenarios.network.conftest import MASTER, Network, start_robot, wait
from tests.support.hosts import LAPTOP
from tests.support.load import crowd
from tests.support.ros import PYTHON, environment, require_ros
from tests.support.ros_code import build_cpp_node
from tests.support.ros_process import RosProcess

pytestmark = pytest.mark.slow

OLDEST = 5.0  # seconds
BACK = 8.0  # seconds until new messages come again

ROSPY = """
import rospy, time
from std_msgs.msg import String
rospy.init_node("stranger")
rospy.Subscriber("/t", String, lambda m: print("heard", repr(time.monotonic()), m.data.split()[1], flush=True))
rospy.spin()
"""
ROSCPP = """
#include <ros/ros.h>
#include <std_msgs/String.h>
#include <cstdio>
#include <sstream>
#include <time.h>
void heard(const std_msgs::String::ConstPtr& m) {
    timespec t; clock_gettime(CLOCK_MONOTONIC, &t);
    std::istringstream words(m->data); std::string number, sent; words >> number >> sent;
    printf("heard %.6f %s\\n", t.tv_sec + t.tv_nsec * 1e-9, sent.c_str()); fflush(stdout);
}
int main(int argc, char** argv) {
    ros::init(argc, argv, "cpp_stranger");
    ros::NodeHandle node;
    ros::Subscriber s = node.subscribe("/t", 1000, heard);
    ros::spin();
}
"""


def heard(stranger: RosProcess) -> list[tuple[float, float]]:
    """(received, sent) of every message."""
    lines = [line.split() for line in stranger.output.splitlines() if line.startswith("heard")]
    return [(float(line[1]), float(line[2])) for line in lines if len(line) == 3]


def await_new(stranger: RosProcess, moment: float) -> float:
    """Seconds from a moment until a message came that was sent after it."""
    end = moment + 60 * crowd()
    while True:
        after = [got for got, sent in heard(stranger) if sent > moment]
        if after:
            return after[0] - moment
        assert wait(0.05) < end, stranger.output[-2000:]


@pytest.fixture
def strangers(network: Network, tmp_path_factory: pytest.TempPathFactory) -> dict[str, RosProcess]:
    """One of each kind, side by side: they hear our publisher on the robot."""
    require_ros("std_msgs")
    base = tmp_path_factory.getbasetemp()
    if os.environ.get("PYTEST_XDIST_WORKER"):
        base = base.parent  # compiled once for all workers
    commands = {
        "rospy": [PYTHON, "-c", ROSPY],
        "roscpp": [str(build_cpp_node("stranger", ROSCPP, base, optimise="-O0"))],
    }
    start_robot(network.robot.python)
    settings = environment(MASTER, extra={"ROS_IP": LAPTOP})
    processes = {kind: network.laptop.start(*words, env=settings) for kind, words in commands.items()}
    for process in processes.values():
        process.wait_for("^heard")
    return processes


@pytest.mark.promise("What TCP has taken is delivered whenever the", "The reset may be lost with the rest")
@pytest.mark.parametrize("silent", [2.0, 10.0, 25.0])
def test_silence(silent: float, strangers: dict[str, RosProcess], network: Network) -> None:
    """After a short one everything comes; after a long one only what is new, within seconds."""
    wait(1.0)
    network.air.silence()
    began = wait(silent) - silent
    back = wait(0.0)
    network.air.clear()
    again = {kind: await_new(stranger, back) for kind, stranger in strangers.items()}
    wait(3.0)
    for kind, stranger in strangers.items():
        late = [got - sent for got, sent in heard(stranger) if got > back]
        print(
            f"{kind}, {silent:g} s of silence: heard again after {again[kind]:.2f} s, "
            f"the oldest is {max(late):.2f} s old"
        )
        assert max(late) < OLDEST, kind
        assert again[kind] < BACK * crowd(), kind
        if silent < 4.0:
            sent = [sent for _, sent in heard(stranger) if sent > began - 0.5]
            assert max(b - a for a, b in itertools.pairwise(sent)) < 1.0, f"{kind}: TCP repeats what is lost"


@pytest.mark.promise("What TCP has taken is delivered whenever the")
def test_a_program_that_is_stopped(strangers: dict[str, RosProcess], network: Network) -> None:
    """What its own system had taken nobody can take back; but nothing of the time after that comes."""
    network.robot.python.do("flood = Ticker(node, '/t', 200, padding=4000)")
    wait(1.0)
    for stranger in strangers.values():
        stranger.process.send_signal(signal.SIGSTOP)
    stopped = wait(0.0)
    back = wait(30.0)
    for stranger in strangers.values():
        stranger.process.send_signal(signal.SIGCONT)
    again = {kind: await_new(stranger, back) for kind, stranger in strangers.items()}
    wait(2.0)
    for kind, stranger in strangers.items():
        late = [(sent, got - sent) for got, sent in heard(stranger) if got > back]
        old = [sent - stopped for sent, age in late if age > OLDEST]
        print(
            f"{kind}: {len(old)} old ones, sent within {max(old, default=0):.2f} s after the stop; "
            f"again after {again[kind]:.2f} s"
        )
        assert max(old, default=0.0) < OLDEST, kind
        assert again[kind] < BACK * crowd(), kind
