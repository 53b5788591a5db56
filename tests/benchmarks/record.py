"""Recording and playing beside rosbag: what is lost, the processor time, and how exactly messages come.

    python -m tests.benchmarks record [--rate MB/s] [--seconds N] [--compression none|bz2|lz4] [--only record|play]

Record: one process publishes a camera (1 MB), a laser (8.7 kB, 40 Hz) and odometry (0.7 kB, 200 Hz); the recorder
is a process of its own, ours by `rosproto bag record`. Play: a bag of 200 and 30 messages a second is played by each
player in a process of its own, and received by a node of ours; an error is a message's moment less the recorded one,
less the median of all. Peers take turns in every round; figures are medians of the rounds.
"""

from __future__ import annotations

import argparse
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import rosproto
from rosproto.bag import BagReader, BagWriter
from rosproto.codec import message_class

OURS = [sys.executable, "-m", "rosproto", "bag"]
PEERS = Path("/usr/lib/rosbag")
SETTLE = 2.0


def run(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="tests.benchmarks record")
    parser.add_argument("--rate", type=int, default=100, help="MB of camera a second")
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--compression", default="none")
    parser.add_argument("--only", default="", help="record or play")
    parser.add_argument("--disk", action="store_true", help="record to the disk, not to memory")
    args = parser.parse_args(arguments)
    place = "/dev/shm" if os.path.isdir("/dev/shm") and not args.disk else None
    with tempfile.TemporaryDirectory(dir=place) as folder, rosproto.Master() as master:
        env = os.environ | {"ROS_MASTER_URI": master.uri, "ROS_IP": "127.0.0.1", "ROS_HOME": folder}
        if args.only != "play":
            compare_recorders(args, folder, master.uri, env)
            compare_small(args, folder, master.uri, env)
        if args.only != "record":
            compare_players(args, folder, master.uri, env)


# -- recording ---------------------------------------------------------------------------------------------


def compare_recorders(args: argparse.Namespace, folder: str, uri: str, env: dict[str, str]) -> None:
    option = {"none": [], "bz2": ["-j"], "lz4": ["--lz4"]}[args.compression]
    tail = [*option, "-O", f"{folder}/run.bag", "/camera", "/scan", "/odom"]
    commands = {"ours": [*OURS, "record", *tail]}
    if (PEERS / "record").exists():
        commands["rosbag record"] = [str(PEERS / "record"), *tail]
    print(
        f"record {args.rate} MB/s + 40 scans + 200 odometries a second for {args.seconds:g} s, {args.compression}"
    )
    results: dict[str, list[tuple[int, int, float, float]]] = {name: [] for name in commands}
    for _ in range(args.rounds):
        for name, command in commands.items():
            results[name].append(record(command, env, uri, args, f"{folder}/run.bag"))
    for name, rows in results.items():
        lost = sum(sent - got for sent, got, _, _ in rows)
        cpu, rate = (statistics.median(row[i] for row in rows) for i in (2, 3))
        print(
            f"  {name:14} {lost:5} of {sum(r[0] for r in rows)} lost   {100 * cpu:5.1f} % of a core   {rate:6.1f} MB/s"
        )


def record(
    command: list[str], env: dict[str, str], uri: str, args: argparse.Namespace, path: str
) -> tuple[int, int, float, float]:
    """Messages sent and recorded, processor seconds a second, MB/s sent."""
    image = message_class("sensor_msgs/Image")(data=os.urandom(500_000) + bytes(500_000))
    scan = message_class("sensor_msgs/LaserScan")()
    scan.ranges = scan.intensities = [1.0] * 1080
    process = subprocess.Popen(command, env=env, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    with rosproto.Node("/robot", master_uri=uri, host="127.0.0.1", rosout=False) as node:
        streams = [
            (node.publisher("/camera", "sensor_msgs/Image", queue_size=100), image, float(args.rate)),
            (node.publisher("/scan", "sensor_msgs/LaserScan", queue_size=1000), scan, 40.0),
            (
                node.publisher("/odom", "nav_msgs/Odometry", queue_size=1000),
                message_class("nav_msgs/Odometry")(),
                200.0,
            ),
        ]
        for publisher, _, _ in streams:
            publisher.wait_for_connection(20)
        plan = sorted(
            (i / hz, n) for n, (_, _, hz) in enumerate(streams) for i in range(int(hz * args.seconds))
        )
        before, began = _processor_seconds(process.pid), time.perf_counter()
        for moment, number in plan:
            time.sleep(max(0.0, began + moment - time.perf_counter()))
            streams[number][0].publish(streams[number][1])
        sent_for = time.perf_counter() - began
        time.sleep(1.0)
        used = _processor_seconds(process.pid) - before
        process.send_signal(signal.SIGINT)
        process.wait(60)
    with BagReader(path) as bag:
        got = bag.message_count
    Path(path).unlink()
    return len(plan), got, used / sent_for, args.rate * args.seconds / sent_for


def compare_small(args: argparse.Namespace, folder: str, uri: str, env: dict[str, str]) -> None:
    """8000 velocities a second, sent by the hundred."""
    count, path = int(8000 * args.seconds), f"{folder}/run.bag"
    commands = {"ours": [*OURS, "record"], "rosbag record": [str(PEERS / "record")]}
    print(f"record 8000 small messages a second for {args.seconds:g} s")
    results: dict[str, list[tuple[int, float]]] = {
        name: [] for name in commands if Path(commands[name][0]).exists()
    }
    for _ in range(args.rounds):
        for name, rows in results.items():
            rows.append(record_small([*commands[name], "-O", path, "/cmd"], env, uri, count, path))
    for name, rows in results.items():
        each = statistics.median(used for _, used in rows) / count
        lost = sum(count - got for got, _ in rows)
        print(f"  {name:14} {lost:5} of {count * len(rows)} lost   {1e6 * each:5.1f} us of a core for each")


def record_small(
    command: list[str], env: dict[str, str], uri: str, count: int, path: str
) -> tuple[int, float]:
    """Messages recorded, processor seconds."""
    process = subprocess.Popen(command, env=env, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    twist = message_class("geometry_msgs/Twist")()
    with rosproto.Node("/robot", master_uri=uri, host="127.0.0.1", rosout=False) as node:
        publisher = node.publisher("/cmd", "geometry_msgs/Twist", queue_size=100_000)
        publisher.wait_for_connection(20)
        before, began = _processor_seconds(process.pid), time.perf_counter()
        for number in range(count):
            if number % 100 == 0:
                time.sleep(max(0.0, began + number / 8000 - time.perf_counter()))
            publisher.publish(twist)
        time.sleep(1.0)
        used = _processor_seconds(process.pid) - before
        process.send_signal(signal.SIGINT)
        process.wait(60)
    with BagReader(path) as bag:
        got = bag.message_count
    Path(path).unlink()
    return got, used


def _processor_seconds(pid: int) -> float:
    """What a process has used (Linux)."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


# -- playing -----------------------------------------------------------------------------------------------


def compare_players(args: argparse.Namespace, folder: str, uri: str, env: dict[str, str]) -> None:
    path = f"{folder}/play.bag"
    moments = write_bag(path, args.seconds)
    commands = {"ours": [*OURS, "play", "-q", "-d", str(SETTLE), path]}
    if (PEERS / "play").exists():
        commands["rosbag play"] = [str(PEERS / "play"), "-q", "-d", str(SETTLE), path]
    print(f"play 200 + 30 messages a second for {args.seconds:g} s: distance from the recorded moment")
    results: dict[str, list[tuple[list[float], float]]] = {name: [] for name in commands}
    for _ in range(args.rounds):
        for name, command in commands.items():
            results[name].append(play(command, env, uri, moments))
    for name, rounds in results.items():
        errors = sorted(error for row, _ in rounds for error in row)
        cpu = statistics.median(used for _, used in rounds)
        middle, most = statistics.median(errors), errors[int(len(errors) * 0.99)]
        print(
            f"  {name:14} median {1000 * middle:.3f} ms   99 % {1000 * most:.3f} ms   "
            f"{len(errors)} of {len(moments) * args.rounds}   {100 * cpu:.1f} % of a core"
        )


def write_bag(path: str, seconds: float) -> list[float]:
    """Each message carries its number; returns the moments."""
    stamped = message_class("geometry_msgs/TwistStamped")()
    image = message_class("sensor_msgs/Image")(data=bytes(300_000))
    moments = sorted(
        (i / hz, hz) for hz in (200.0, 30.0) for i in range(int(hz * seconds))
    )  # 30 Hz images between
    with BagWriter(path) as writer:
        for number, (moment, hz) in enumerate(moments):
            message = stamped if hz == 200.0 else image
            message.header.frame_id = str(number)
            writer.write("/fast" if hz == 200.0 else "/images", message, 1000.0 + moment)
    return [moment for moment, _ in moments]


def play(
    command: list[str], env: dict[str, str], uri: str, moments: list[float]
) -> tuple[list[float], float]:
    """Distance of each received message from its moment, and the player's processor seconds a second."""
    times: dict[int, float] = {}
    done = threading.Event()

    def receive(message: object) -> None:
        times[int(message.header.frame_id)] = time.perf_counter()  # type: ignore[attr-defined]
        if len(times) == len(moments):
            done.set()

    with (
        rosproto.Node("/listener", master_uri=uri, host="127.0.0.1", rosout=False) as node,
        node.subscriber("/fast", "geometry_msgs/TwistStamped", receive, queue_size=1000, tcp_nodelay=True),
        node.subscriber("/images", "sensor_msgs/Image", receive, queue_size=1000, tcp_nodelay=True),
    ):
        process = subprocess.Popen(command, env=env, stdout=subprocess.DEVNULL, stdin=subprocess.DEVNULL)
        time.sleep(SETTLE + 0.7)
        before, used, began = _processor_seconds(process.pid), 0.0, time.perf_counter()
        while not done.wait(0.2) and process.poll() is None:
            used = (_processor_seconds(process.pid) - before) / (time.perf_counter() - began)
        process.wait(30)
        done.wait(1.0)
    offsets = {number: moment - moments[number] for number, moment in times.items()}
    middle = statistics.median(offsets.values())
    return [abs(offset - middle) for offset in offsets.values()], used


__all__ = ["run"]
