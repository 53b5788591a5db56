"""Recording a busy graph beside `rosbag record`: what is lost, and the processor time it takes.

One process publishes 1 MB messages at the given rate; the recorder is a process of its own. Options: --rate MB per
second, --seconds, --compression none|bz2|lz4.
"""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import rosproto
from rosproto.bag import BagReader
from rosproto.codec import message_class

RECORD = """
import sys, signal, threading, rosproto
from rosproto.recording import Recorder
end = threading.Event()
signal.signal(signal.SIGINT, lambda *a: end.set())
with rosproto.Node("/recorder", master_uri=sys.argv[1], host="127.0.0.1") as node:
    with Recorder(node, path=sys.argv[2], topics=["/camera"], compression=sys.argv[3]):
        end.wait()
"""


def run(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="tests.benchmarks recording")
    parser.add_argument("--rate", type=int, default=100)
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--compression", default="none")
    args = parser.parse_args(arguments)
    place = "/dev/shm" if os.path.isdir("/dev/shm") else None
    genuine = Path("/usr/lib/rosbag/record")
    option = {"none": [], "bz2": ["-j"], "lz4": ["--lz4"]}[args.compression]
    with tempfile.TemporaryDirectory(dir=place) as folder, rosproto.Master() as master:
        env = os.environ | {"ROS_MASTER_URI": master.uri, "ROS_IP": "127.0.0.1", "ROS_HOME": folder}
        ours = [sys.executable, "-c", RECORD, master.uri, f"{folder}/ours.bag", args.compression]
        theirs = [str(genuine), *option, "-O", f"{folder}/theirs.bag", "/camera"]
        for name, command in (("ours", ours), ("rosbag record", theirs)):
            if name != "ours" and not genuine.exists():
                continue
            print(f"{name:14} {record(command, env, master.uri, args)}", flush=True)


def record(command: list[str], env: dict[str, str], uri: str, args: argparse.Namespace) -> str:
    """Publish while the command records; what it got and what it used."""
    process = subprocess.Popen(command, env=env, stdout=subprocess.DEVNULL)
    image = message_class("sensor_msgs/Image")(data=os.urandom(500_000) + bytes(500_000))
    with rosproto.Node("/camera_node", master_uri=uri, host="127.0.0.1") as node:
        camera = node.publisher("/camera", "sensor_msgs/Image", queue_size=100)
        camera.wait_for_connection(20)
        before = _ticks(process.pid)
        count, began = int(args.rate * args.seconds), time.perf_counter()
        for number in range(count):
            time.sleep(max(0.0, began + number / args.rate - time.perf_counter()))
            camera.publish(image)
        time.sleep(1.0)
        used = _ticks(process.pid) - before
        process.send_signal(signal.SIGINT)
        process.wait(30)
    path = next(p for p in command if p.endswith(".bag"))
    with BagReader(path) as bag:
        got = bag.message_count
    Path(path).unlink()
    return f"{got} of {count} messages, {used / count * 1000:.2f} ms processor time each"


def _ticks(pid: int) -> float:
    """Processor seconds a process has used (Linux)."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


__all__ = ["run"]
