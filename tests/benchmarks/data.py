"""What recordings become afterwards: bytes, tables, pieces, ranges; beside rosbags and pandas in the same run.

    python -m tests.benchmarks data [--mb 400] [--rounds 5] [--only cells,parquet,pieces,ranges] [--folder PATH]

* cells: reading a bag, beside rosbags: small messages and mixed ones, none and lz4, raw and decoded. Peers take turns,
  each in a process of its own (see `bag`).
* parquet: three topics of a bag with pictures (--mb of messages) to Parquet, beside `bag export csv`, which goes row by
  row, and beside rosbags with pandas; and the memory that ours took. Each is a process of its own, interpreter included.
* pieces: `rosproto.bag.partitions` of four bags with LZ4, in a process on one core and in two on two (on Linux; a
  process that may use both would read ahead on the other one).
* ranges: a topic of the bag behind HTTP: bytes that were fetched over the bytes of its chunks.

Files lie in a temporary directory, in --folder, else in /dev/shm where there is one.
"""

from __future__ import annotations

import argparse
import os
import re
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from rosproto.bag import BagReader, BagWriter, Partition, partitions
from rosproto.codec import message_class
from tests.benchmarks import bag, bigbag
from tests.benchmarks._figures import print_ratio, ratios

TOPICS = ("/scan", "/odom", "/cmd_vel")
OUR_EXPORT = """
from rosproto.cli import main
path, form, folder, *topics = sys.argv[1:]
assert main(["bag", "export", "-q", path, form, "-o", folder, "--topics", *topics]) == 0
"""
ROSBAGS_AND_PANDAS = """
import os
import pandas
from rosbags.rosbag1 import Reader
from rosbags.typesys import Stores, get_typestore
path, _, folder, *topics = sys.argv[1:]
store = get_typestore(Stores.ROS1_NOETIC)
os.makedirs(folder, exist_ok=True)
def flat(message, prefix, row):
    for name, value in vars(message).items():
        if hasattr(value, "__msgtype__"):
            flat(value, prefix + name + ".", row)
        elif name != "__msgtype__":
            row[prefix + name] = value
    return row
with Reader(path) as bag:
    rows = {topic: [] for topic in topics}
    wanted = [c for c in bag.connections if c.topic in rows]
    for connection, stamp, raw in bag.messages(wanted):
        message = store.deserialize_ros1(raw, connection.msgtype)
        rows[connection.topic].append(flat(message, "", {"receive_time": stamp}))
for topic in topics:
    pandas.DataFrame(rows[topic]).to_parquet(os.path.join(folder, topic.strip("/") + ".parquet"))
"""


def run(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="tests.benchmarks data")
    parser.add_argument("--mb", type=int, default=400, help="megabytes of messages in the large bag")
    parser.add_argument("--small", type=int, default=100_000, help="messages in the bag of small ones")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--only", default="cells,parquet,pieces,ranges")
    parser.add_argument("--folder", help="where to put the bags")
    args = parser.parse_args(arguments)
    chosen = args.only.split(",")
    place = args.folder or ("/dev/shm" if os.path.isdir("/dev/shm") else None)
    with tempfile.TemporaryDirectory(dir=place) as name:
        folder = Path(name)
        if "cells" in chosen:
            cells(args, folder)
        if "pieces" in chosen:
            pieces(args, folder)
        if "parquet" in chosen or "ranges" in chosen:
            path = folder / "big.bag"
            count = bigbag.write(path, args.mb, "none")
            print(f"{path.stat().st_size / 1e9:.2f} GB, {count} messages")
            if "parquet" in chosen:
                parquet(args, path, folder)
            if "ranges" in chosen:
                ranges(path)


# -- reading, beside rosbags -------------------------------------------------------------------------------------------


def cells(args: argparse.Namespace, folder: Path) -> None:
    theirs = bag.RosbagsPeer.create()
    if theirs is None:
        print("  rosbags is not installed: no cells")
        return
    path = folder / "cell.bag"
    ours = bag.Ours()
    for label, entries in (
        ("small", bag.small_entries(args.small)),
        ("mixed", bag.mixed_entries(args.mb // 2)),
    ):
        for compression in ("none", "lz4"):
            ours.write(path, compression, ours.prepare(entries))
            turns = {peer.name: bag.Turn(peer, []) for peer in (ours, theirs)}
            for verb, what in (("raw", "raw"), ("read", "decoded")):
                times: bag.Times = {}
                for _ in range(args.rounds):
                    for name, turn in turns.items():
                        assert bag.clock(times, name, turn, verb, path) == len(entries)
                found = ratios(times[verb, "rosbags"], times[verb, "ours"])
                print_ratio(f"{label} {compression} {what}: rosbags / ours", found, 1.3, more=True)
                found = ratios(times[verb + " cpu", "rosbags"], times[verb + " cpu", "ours"])
                print_ratio("  in processor time", found, 1.3, more=True)
            for turn in turns.values():
                turn.close()
    path.unlink()


# -- tables ------------------------------------------------------------------------------------------------------------


def parquet(args: argparse.Namespace, path: Path, folder: Path) -> None:
    ways = {"ours": (OUR_EXPORT, "parquet"), "csv": (OUR_EXPORT, "csv")}
    try:
        import rosbags  # noqa: F401

        ways["rosbags"] = (ROSBAGS_AND_PANDAS, "parquet")
    except ImportError:
        print("  rosbags is not installed: not beside it")
    times: dict[str, list[float]] = {name: [] for name in ways}
    memory = 0
    for _ in range(max(1, args.rounds // 2)):
        for name, (code, form) in ways.items():
            took, megabytes = child(code, str(path), form, str(folder / name), *TOPICS)
            times[name].append(took)
            if name == "ours":
                memory = max(memory, megabytes)
    print(f"  Parquet of three topics: {statistics.median(times['ours']):.2f} s, {memory} MB")
    print_ratio("CSV row by row / Parquet", ratios(times["csv"], times["ours"]), 5, more=True)
    if "rosbags" in times:
        print_ratio("rosbags + pandas / ours", ratios(times["rosbags"], times["ours"]), 1, more=True)
    print_ratio("memory, MB", [memory], 300, more=False)


def child(code: str, *arguments: str) -> tuple[float, int]:
    """Seconds and megabytes of a process that runs it."""
    done = subprocess.run(
        [sys.executable, "-c", bigbag.PREFIX + code + bigbag.SUFFIX, *arguments],
        env=os.environ | {"PYTHONPATH": os.getcwd(), "PYTHONDONTWRITEBYTECODE": ""},
        capture_output=True,
        text=True,
        timeout=3600,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    took, megabytes = done.stdout.split()[-2:]
    return float(took), int(megabytes)


# -- pieces ------------------------------------------------------------------------------------------------------------


def pieces(args: argparse.Namespace, folder: Path) -> None:
    """Each process also reads a piece before the clock starts: what it imports is not what is measured."""
    Odometry = message_class("nav_msgs/Odometry")
    runs = folder / "runs"
    runs.mkdir()
    each = max(1000, args.mb * 1_000_000 // 730 // 4)
    for number in range(4):
        with BagWriter(runs / f"{number}.bag", "lz4") as writer:
            message = Odometry()
            for i in range(each):
                message.pose.pose.position.x = float(i)
                writer.write("/odom", message, 1000.0 + i / 50)
    found = partitions(runs, "/odom", size=1 << 18)
    took: dict[int, list[float]] = {1: [], 2: []}
    context = get_context("spawn")
    pools = {n: ProcessPoolExecutor(n, context, _own_core, (context.Value("i", 0),)) for n in took}
    for count, pool in pools.items():
        list(pool.map(rows_of, found[: 4 * count]))
    busy: dict[int, list[float]] = {1: [], 2: []}
    for _ in range(args.rounds):
        for count, pool in pools.items():
            began = time.perf_counter()
            done = list(pool.map(rows_of, found))
            took[count].append(time.perf_counter() - began)
            assert sum(rows for rows, _, _ in done) == 4 * each
            spent: dict[int, float] = {}
            for _, process, seconds in done:
                spent[process] = spent.get(process, 0.0) + seconds
            busy[count].append(max(spent.values()))
    for pool in pools.values():
        pool.shutdown()
    print(f"  {len(found)} pieces, {4 * each} messages: {statistics.median(took[1]):.2f} s in one process")
    print_ratio("pieces: one process / two", ratios(took[1], took[2]), 1.7, more=True)
    # On a computer that has other things to do, the time on the wall is theirs as well.
    print_ratio("the same in processor time of the busiest", ratios(busy[1], busy[2]), 1.7, more=True)


def _own_core(taken: Any) -> None:
    """In a process of a pool: stay on a core of one's own."""
    with taken.get_lock():
        number, taken.value = taken.value, taken.value + 1
    if hasattr(os, "sched_setaffinity"):
        cores = sorted(os.sched_getaffinity(0))
        os.sched_setaffinity(0, {cores[number % len(cores)]})


def rows_of(piece: Partition) -> tuple[int, int, float]:
    """Rows, which process made them, and its processor time."""
    began = time.process_time()
    rows: int = piece.table().num_rows
    return rows, os.getpid(), time.process_time() - began


# -- ranges ------------------------------------------------------------------------------------------------------------


def ranges(path: Path) -> None:
    with served(path) as (url, sent):
        for topic in ("/cmd_vel", "/image"):
            began, before = time.perf_counter(), sum(sent)
            found = partitions(url, topic)
            count = sum(batch.num_rows for piece in found for batch in piece.batches())
            fetched, chunks = sum(sent) - before, sum(piece.size for piece in found)
            with BagReader(path) as local:
                assert count == local.topics[topic].message_count
            print(
                f"  {topic} by HTTP: {fetched / 1e6:.1f} MB fetched for {chunks / 1e6:.1f} MB of chunks, "
                f"{time.perf_counter() - began:.1f} s"
            )
            print_ratio(f"{topic}: bytes fetched / of chunks", [fetched / chunks], 2, more=False)


@contextmanager
def served(path: Path) -> Iterator[tuple[str, list[int]]]:
    """A URL of a file behind the standard library's server, and the bytes of each answer."""
    sent: list[int] = []
    size = path.stat().st_size

    class Handler(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def do_HEAD(self) -> None:
            self.answer(200, 0, size, body=False)

        def do_GET(self) -> None:
            asked = re.fullmatch(r"bytes=(\d+)-(\d+)", self.headers.get("Range", ""))
            if asked is None:
                self.answer(200, 0, size)
            else:
                self.answer(206, int(asked[1]), min(int(asked[2]) + 1, size))

        def answer(self, status: int, start: int, end: int, *, body: bool = True) -> None:
            self.send_response(status)
            self.send_header("Content-Length", str(end - start))
            self.send_header("Accept-Ranges", "bytes")
            if status == 206:
                self.send_header("Content-Range", f"bytes {start}-{end - 1}/{size}")
            self.end_headers()
            if body:
                with open(path, "rb") as file:
                    file.seek(start)
                    self.wfile.write(file.read(end - start))
                sent.append(end - start)

        def log_message(self, *_: object) -> None:
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    thread = threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_address[1]}/{path.name}", sent
    finally:
        server.shutdown()
        server.server_close()
        thread.join(5)


__all__ = ["run"]
