"""What a bad network between two computers costs: `python -m tests.benchmarks network [--silence 3 8 15]`.

Two network namespaces on this computer (tests/support/hosts.py; Linux, as root): a robot with a master and a node that
publishes at 20 Hz, and a laptop. Each row tells, from the moment the network is back, when the first message came that
was sent after it, and how old the oldest message was that came then. rospy on both sides for comparison.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

from tests.support.hosts import ROBOT, Host, two_hosts, why_not
from tests.support.ros import PYTHON, environment

MASTER = f"http://{ROBOT}:11311/"
ROBOT_SIDE = f"""
from rosproto import Master, Node
master = Master(host={ROBOT!r}, port=11311)
node = Node("/robot", master_uri=master.uri)
tick = Ticker(node, "/t", 20)
heard = Heard(node, "/back")
"""
LAPTOP_SIDE = f"""
from rosproto import Node
node = Node("/laptop", master_uri={MASTER!r})
heard = Heard(node, "/t")
tick = Ticker(node, "/back", 20)
"""
ROSPY_TALKER = """
import rospy, time
from std_msgs.msg import String
rospy.init_node("robot")
talk, n = rospy.Publisher("/t", String, queue_size=10), 0
while not rospy.is_shutdown():
    talk.publish("%d %r" % (n, time.monotonic())); n += 1
    time.sleep(0.05)
"""
ROSPY_LISTENER = """
import rospy, time
from std_msgs.msg import String
rospy.init_node("laptop")
rospy.Subscriber("/t", String, lambda m: print("heard", repr(time.monotonic()), m.data.split()[1], flush=True))
rospy.spin()
"""


def run(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="tests.benchmarks network")
    parser.add_argument("--silence", type=float, nargs="*", default=[3.0, 8.0, 15.0], help="seconds")
    parser.add_argument("--no-rospy", action="store_true", help="leave the comparison out")
    args = parser.parse_args(arguments)
    if why_not():
        print(f"no network of two computers: {why_not()}")
        return 1
    print(
        f"{'seconds from the network being back':58} {'heard again':>12} {'back channel':>13} {'oldest':>8}"
    )
    for seconds in args.silence:
        _ours(f"{seconds:g} s of silence", lambda _, s=seconds: time.sleep(s), silent=True)
    _ours("own address replaced", lambda laptop: laptop.set_addresses("10.77.0.33/24"))
    _ours("own address gone for 5 s, then another", lambda laptop: _other_address(laptop, 5.0))
    _ours("cable out for 5 s", lambda laptop: _cable(laptop, 5.0))
    if not args.no_rospy:
        for seconds in args.silence:
            _rospy(seconds)
    return 0


def _other_address(laptop: Host, seconds: float) -> None:
    laptop.run("ip", "address", "flush", "dev", laptop.device)
    time.sleep(seconds)
    laptop.set_addresses("10.77.0.34/24")


def _cable(laptop: Host, seconds: float) -> None:
    laptop.down()
    time.sleep(seconds)
    laptop.up()


def _ours(label: str, fault: Callable[[Host], object], *, silent: bool = False) -> None:
    with two_hosts() as (robot, laptop, air):
        robot.python.do(ROBOT_SIDE)
        laptop.python.do(LAPTOP_SIDE)
        for host in (robot, laptop):
            host.python.eventually("heard.messages")
        time.sleep(1.0)
        if silent:
            air.silence()
        fault(laptop)
        air.clear()
        back = time.monotonic()
        times = []
        for host in (laptop, robot):
            host.python.eventually(f"heard.first_sent_after({back!r})", 60)
            times.append(host.python.ask(f"heard.first_sent_after({back!r})") - back)
        time.sleep(2.0)
        oldest = max(host.python.ask(f"heard.latest_after({back!r})") for host in (laptop, robot))
    print(f"{'ours: ' + label:58} {times[0]:12.2f} {times[1]:13.2f} {oldest:8.2f}")


def _rospy(seconds: float) -> None:
    with two_hosts() as (robot, laptop, air):
        on_robot = environment(MASTER, extra={"ROS_IP": ROBOT})
        robot.start(PYTHON, "/usr/bin/rosmaster", "--core", "-p", "11311", env=on_robot)
        robot.python.eventually(f"reachable({ROBOT!r}, 11311)", 20)
        robot.start(PYTHON, "-c", ROSPY_TALKER, env=on_robot)
        on_laptop = environment(MASTER, extra={"ROS_IP": "10.77.0.2"})
        listener = laptop.start(PYTHON, "-c", ROSPY_LISTENER, env=on_laptop)
        listener.wait_for("^heard")
        time.sleep(1.0)
        air.silence()
        time.sleep(seconds)
        air.clear()
        back = time.monotonic()
        end = back + 3 * seconds + 10
        after: list[tuple[float, float]] = []
        while not any(sent > back for _, sent in after) and time.monotonic() < end:
            time.sleep(0.05)
            lines = [line.split() for line in listener.output.splitlines() if line.startswith("heard")]
            after = [(float(got), float(sent)) for _, got, sent in lines if float(got) > back]
        fresh = [got - back for got, sent in after if sent > back]
        oldest = max((got - sent for got, sent in after), default=0.0)
    print(
        f"{f'rospy to rospy: {seconds:g} s of silence':58} {fresh[0] if fresh else float('inf'):12.2f} {'':13} {oldest:8.2f}"
    )
