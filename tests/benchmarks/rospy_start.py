"""Start-up of a rospy program: from starting the process to its first callback, real rospy and ours in turn.

The topic is latched, so that the first callback is due as soon as the program is connected.
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
    base = statistics.median(times["rospy"])
    print(f"{'':26} median ms   min ms   of rospy")
    for name, values in times.items():
        median = statistics.median(values)
        print(f"{name:26} {median * 1e3:9.0f} {min(values) * 1e3:8.0f} {median / base:9.0%}")
    return 0
