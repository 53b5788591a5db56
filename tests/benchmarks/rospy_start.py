"""Start-up of a rospy program, real rospy and ours in turn: first callback, and what subscribers cost.

From starting the process to its first callback: the topic is latched, so that it is due as soon as the program is
connected. And three `rospy.Subscriber(...)` of different types: processor time (of all threads) and time of each
constructor, in a fresh process each, after three of other types.
"""

from __future__ import annotations

import argparse
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import rosproto
from tests.support import ros

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = """\
import rospy
from std_msgs.msg import String
def callback(message):
    print("callback", flush=True)
    rospy.signal_shutdown("done")
rospy.init_node("starter")
rospy.Subscriber("/chatter", String, callback)
rospy.spin()
"""
SUBSCRIBERS = """\
import time
import rospy
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, Twist
from sensor_msgs.msg import LaserScan, Image
from std_msgs.msg import String
def callback(message):
    pass
rospy.init_node("starter")
for number, kind in enumerate((String, Twist, PoseStamped)):
    rospy.Subscriber("/first%d" % number, kind, callback)
time.sleep(0.2)
began, spent = time.perf_counter(), time.process_time()
for number, kind in enumerate((PoseWithCovarianceStamped, LaserScan, Image)):
    rospy.Subscriber("/topic%d" % number, kind, callback)
spent, took = time.process_time() - spent, time.perf_counter() - began
print(spent, took, flush=True)
rospy.signal_shutdown("done")
"""


def three_subscribers(command: Sequence[str], env: dict[str, str]) -> tuple[float, float]:
    """(processor time, time) of three constructors, seconds."""
    done = subprocess.run(command, env=env, capture_output=True, text=True, timeout=60, check=True)
    spent, took = map(float, done.stdout.split()[-2:])
    return spent, took


def first_callback(command: Sequence[str], env: dict[str, str]) -> float:
    """Seconds until the program's callback has printed."""
    began = time.perf_counter()
    with subprocess.Popen(command, env=env, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        line = process.stdout.readline()
        spent = time.perf_counter() - began
        process.stdout.read()
        process.wait(30)
    assert line == "callback\n", f"{command}: {line!r}"
    return spent


def run(argv: Sequence[str]) -> int:
    """Print medians in ms and their ratio."""
    parser = argparse.ArgumentParser(prog="rospy_start")
    parser.add_argument("--rounds", type=int, default=11)
    rounds = parser.parse_args(argv).rounds
    with tempfile.TemporaryDirectory() as folder, rosproto.Master() as master:
        program = Path(folder) / "program.py"
        program.write_text(PROGRAM)
        ways = {
            "rospy": ([ros.PYTHON, str(program)], ros.environment(master.uri)),
            "rosproto run": (
                [sys.executable, "-m", "rosproto", "run", str(program)],
                ros.environment(master.uri, packages=ROOT),
            ),
            "python -m rosproto.rospy": (
                [sys.executable, "-m", "rosproto.rospy", str(program)],
                ros.environment(master.uri, packages=ROOT),
            ),
        }
        times: dict[str, list[float]] = {name: [] for name in ways}
        with rosproto.Node("/mouth", master_uri=master.uri) as node:
            node.publisher("/chatter", "std_msgs/String", latch=True).publish(data="hello")
            for _ in range(rounds):
                for name, (command, env) in ways.items():
                    times[name].append(first_callback(command, env))
            program.write_text(SUBSCRIBERS)
            costs: dict[str, list[tuple[float, float]]] = {name: [] for name in ways}
            for _ in range(rounds):
                for name, (command, env) in ways.items():
                    costs[name].append(three_subscribers(command, env))
    table("to the first callback", times)
    table(
        "three constructors, processor", {name: [cost[0] for cost in found] for name, found in costs.items()}
    )
    table("three constructors, time", {name: [cost[1] for cost in found] for name, found in costs.items()})
    return 0


def table(title: str, times: dict[str, list[float]]) -> None:
    base = statistics.median(times["rospy"])
    print(f"{title:32} median ms   min ms   of rospy")
    for name, values in times.items():
        median = statistics.median(values)
        print(f"  {name:30} {median * 1e3:9.2f} {min(values) * 1e3:8.2f} {median / base:9.0%}")
