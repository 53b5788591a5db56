"""Topics and services between two processes on loopback, beside rospy and roscpp, interleaved in one run.

    python -m tests.benchmarks transport [--busy 2] [--rounds 5] [--table] [--busy-thread]
                                         [--only burst,large,ping,steady,compute,start,service,fan]

Every cell is the median over the rounds; in a round each pairing takes its turn, so that a busy computer hits all of
them. Ratios are medians of the rounds' own ratios. Ours runs on Debian's /usr/bin/python3 where it is the same
minor version as this one (rospy runs on it too), else on this one. `--table` ends with the rows of the table in
docs/performance.md, each cell with its spread. With `--busy-thread` the subscriber's own process has a thread that
computes, ours and the peer's. "bare" is sockets alone (peers/bare_sockets.py), "sink" reads and throws away: what
is left to win.

Needs Debian's ROS 1 packages and g++; what is absent is left out.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import socket
import statistics
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rosproto.master import Master
from tests.benchmarks._figures import Table, print_ratio, ratios, spread
from tests.support import ros

HERE = Path(__file__).parent
ROOT = HERE.parent.parent
PEER = HERE / "peers" / "python_peer.py"
VGA = 640 * 480 * 3
IMAGES = {
    "Image 640 x 480": VGA,
    "Image 1920 x 1080": 1920 * 1080 * 3,
    "as much as a PointCloud2, 4.9 MB": 4_900_000,
}


def run(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="tests.benchmarks transport")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=2.0)
    parser.add_argument("--only", default="burst,large,ping,steady,compute,start,service,fan")
    parser.add_argument("--pairs", help="of `burst`: rospy-ours,rospy-rospy ...; all when not given")
    parser.add_argument("--busy-thread", action="store_true")
    parser.add_argument("--table", action="store_true")
    args = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as folder, Bench(Path(folder), args.rounds, args.seconds) as bench:
        bench.wanted = set(args.pairs.split(",")) if args.pairs else None
        bench.busy_thread = args.busy_thread
        for name in args.only.split(","):
            getattr(bench, f"measure_{name}")()
        if args.table:
            bench.table.print()


class Bench:
    """The processes of one run, and a master of ours in this process, which waits while they work."""

    def __init__(self, folder: Path, rounds: int, seconds: float) -> None:
        self.folder, self.rounds, self.seconds = folder, rounds, seconds
        self.wanted: set[str] | None = None
        self.busy_thread = False
        self.table = Table("beside rospy", "beside roscpp")

    def __enter__(self) -> Bench:
        (self.folder / "genpy").mkdir()
        self.packages = ros.generate_python_packages(self.folder / "genpy")
        source = (HERE / "peers" / "roscpp_peer.cpp").read_text("utf-8")
        self.cpp = ros.build_cpp_node("roscpp_peer", source, self.folder)
        self.python = sys.executable if _other_version() else "/usr/bin/python3"
        self.master = Master()
        print(
            f"ours on {self.python}, {os.cpu_count()} CPUs, load {os.getloadavg()[0]:.1f}, {self.rounds} rounds"
        )
        return self

    def __exit__(self, *exc: object) -> None:
        self.master.close()

    @property
    def uri(self) -> str:
        return self.master.uri

    def renew_master(self) -> None:
        """Peers are killed and stay registered: the next ones would try to reach them."""
        self.master.close()
        self.master = Master()

    def renew(self) -> None:
        """Nothing is left of the last pair: no registration, no port of bare sockets."""
        self.renew_master()
        shutil.rmtree(self.folder / "bare", ignore_errors=True)
        (self.folder / "bare").mkdir()

    def _env(self, library: str, uri: str) -> dict[str, str]:
        env = ros.environment(uri, packages=self.packages)
        env["BENCH_FOLDER"] = str(self.folder / "bare")
        if library.startswith("ours"):
            import numpy

            env["PYTHONPATH"] = f"{ROOT}{os.pathsep}{Path(numpy.__file__).parent.parent}"
            # Compiled once, as pip and Debian's packages do.
            env.pop("PYTHONDONTWRITEBYTECODE", None)
        return env

    def start(
        self, library: str, role: str, before: Sequence[str] = (), **options: Any
    ) -> subprocess.Popen[str]:
        """Start one role; `before` is a program that runs it (strace)."""
        if library == "roscpp":
            queue = (
                options.get("sub_queue_size")
                if role in ("count", "one_way", "pong")
                else options.get("queue_size")
            )
            words = [
                options.get("seconds", 0) or options.get("life", 0),
                options.get("count", 0),
                options.get("hz", 0),
                queue or 1000,
                int(bool(options.get("nodelay"))),
            ]
            command = [str(self.cpp), role, *map(str, words)]
        else:
            python = self.python if library.startswith("ours") else "/usr/bin/python3"
            command = [python, str(PEER), library, role, json.dumps(options)]
        return subprocess.Popen(
            [*before, *command],
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            env=self._env(library, self.uri),
        )

    def pair(self, pub: str, pub_role: str, sub: str, sub_role: str, **options: Any) -> tuple[dict, dict]:
        """As `_pair`; once more when a peer got stuck (it happens to rospy and roscpp on a busy computer)."""
        try:
            return self._pair(pub, pub_role, sub, sub_role, **options)
        except (subprocess.TimeoutExpired, RuntimeError) as error:
            print(f"  (again: {pub} {pub_role}, {sub} {sub_role}: {type(error).__name__})")
            return self._pair(pub, pub_role, sub, sub_role, **options)

    def _pair(self, pub: str, pub_role: str, sub: str, sub_role: str, **options: Any) -> tuple[dict, dict]:
        """Run two roles against each other; the second is started first. Results of both."""
        self.renew()
        if self.busy_thread:
            options["compute"] = 1
        second = self.start(sub, sub_role, **options)
        _answer(second, "ready")
        first = self.start(pub, pub_role, **options)
        try:
            result = _last(first, 25)
            return result, (_last(second, 25) if sub_role in ("count", "sink", "one_way") else {})
        finally:
            for process in (first, second):
                process.kill()
                process.wait(5)

    # -- cases ----------------------------------------------------------------------------------------------

    def measure_burst(self) -> None:
        """Twist as fast as possible, received and decoded."""
        pairs: dict[str, tuple[str, str, int | None]] = {
            "rospy-rospy": ("rospy", "rospy", None),
            "rospy queue 1000": ("rospy", "rospy", 1000),
            # roscpp's publisher has a queue that loses nothing: with 1000 it drops nine of ten messages.
            "roscpp-roscpp": ("roscpp", "roscpp", 1_000_000),
            "roscpp-rospy": ("roscpp", "rospy", 1_000_000),
            "ours-ours": ("ours", "ours", 1000),
            "ours-ours queue 10": ("ours", "ours", 10),
            "ours-rospy": ("ours", "rospy", 1000),
            "roscpp-ours": ("roscpp", "ours", 1_000_000),
            "rospy-ours": ("rospy", "ours", None),
            "roscpp-sink": ("roscpp", "sink", 1_000_000),
            "rospy-sink": ("rospy", "sink", None),
        }
        if self.busy_thread:
            pairs = {
                label: pair
                for label, pair in pairs.items()
                if pair[1] in ("rospy", "ours") and "queue" not in label
            }
        if self.wanted is not None:
            pairs = {label: pair for label, pair in pairs.items() if label in self.wanted}
        rates: dict[str, list[float]] = defaultdict(list)
        for _ in range(self.rounds):
            for label, (pub, sub, queue) in pairs.items():
                sent, got = self.pair(
                    pub,
                    "publish_fast",
                    "ours" if sub == "sink" else sub,
                    "sink" if sub == "sink" else "count",
                    seconds=self.seconds,
                    queue_size=queue,
                    sub_queue_size=None if sub == "rospy" else 100_000,
                )
                rates[label].append(got["received"] / got["seconds"] / 1000)
                rates[label + " lost"].append(1 - got["received"] / max(1, sent["sent"]))
                rates[label + " sender"].append(sent["cpu"] / sent["seconds"])
                rates[label + " cpu"].append(got["cpu"] / max(1, got["received"]) * 1e6)
                rates[label + " sender cpu"].append(sent["cpu"] / max(1, sent["sent"]) * 1e6)
                rates[label + " waits"].append(got.get("waits", 0) / max(1, got["received"]) * 1e3)
        print("\nTwist as fast as possible: k messages/s received and decoded")
        for label in pairs:
            lost = statistics.median(rates[label + " lost"])
            print(f"  {label:20} {spread(rates[label])}   lost {lost:.1%}")
        print("\nprocessor time for a message, us: receiver, sender; the sender's share of a processor;")
        print("how often the receiver waited for 1000 messages")
        for label in pairs:
            figures = (
                f"{statistics.median(rates[label + key]):7.2f}" for key in (" cpu", " sender cpu", " sender")
            )
            print(f"  {label:20} {' '.join(figures)} {spread(rates[label + ' waits'])}")
        fast = "Twist as fast as possible, received and decoded"
        for mine, theirs, must, row in (
            ("ours-ours", "rospy-rospy", 3, fast),
            ("ours-ours", "roscpp-roscpp", 3, fast),
            ("ours-ours", "rospy queue 1000", 60, f"{fast}, rospy with `queue_size=1000`"),
            ("ours-rospy", "rospy-rospy", 1.5, "the same from our publisher to a rospy subscriber"),
            ("roscpp-ours", "roscpp-rospy", 1.5, "from a roscpp publisher to our subscriber"),
            ("rospy-ours", "rospy-rospy", 0.85, "from a rospy publisher to our subscriber"),
            ("rospy-sink", "rospy-rospy", 0.85, "from a rospy publisher to one that reads and throws away"),
            ("roscpp-sink", "roscpp-rospy", 1.5, "from a roscpp publisher to one that reads and throws away"),
        ):
            if mine in pairs and theirs in pairs:
                column = "beside roscpp" if theirs == "roscpp-roscpp" else "beside rospy"
                self._ratio(f"{mine} / {theirs}", rates[mine], rates[theirs], must, row, column, more=True)

    def measure_large(self) -> None:
        """Images and a cloud as fast as possible; beside a raw socket."""
        for label, size in IMAGES.items():
            values: dict[str, list[float]] = defaultdict(list)
            for _ in range(self.rounds):
                values["raw socket"].append(raw_socket(size, self.seconds))
                for name, lib, array in (
                    ("rospy", "rospy", 0),
                    ("ours", "ours", 0),
                    ("ours, ndarray", "ours", 1),
                ):
                    _, got = self.pair(
                        lib,
                        "publish_fast",
                        lib,
                        "count",
                        seconds=self.seconds,
                        type="sensor_msgs/Image",
                        size=size,
                        chunk=1,
                        array=array,
                        queue_size=10 if lib == "ours" else None,
                    )
                    values[name].append(got["received"] / got["seconds"])
                    values[name + " cpu"].append(got["cpu"] / max(1, got["received"]))
            print(f"\n{label}: messages/s")
            for name in ("raw socket", "rospy", "ours", "ours, ndarray"):
                print(f"  {name:20} {spread(values[name])}")
            self._ratio("ours / rospy", values["ours"], values["rospy"], 5, label, more=True)
            self._ratio("ours / raw socket", values["ours"], values["raw socket"], 0.85, more=True)
            self._ratio("ours, ndarray / rospy", values["ours, ndarray"], values["rospy"], 5, more=True)
            self._ratio(
                "subscriber CPU per message", values["ours cpu"], values["rospy cpu"], 0.2, more=False
            )

    def measure_ping(self) -> None:
        """Round trips of a Twist; by bare sockets, too."""
        p50: dict[str, list[float]] = defaultdict(list)
        p99: dict[str, list[float]] = defaultdict(list)
        for _ in range(self.rounds):
            for lib in ("rospy", "roscpp", "ours", "bare"):
                result, _ = self.pair(lib, "ping", lib, "pong", count=2000, life=60)
                _percentiles(result["times"], p50[lib], p99[lib])
        self._latency("ping and pong", p50, p99, 0.75, 0.75)

    def measure_steady(self) -> None:
        """One way at 2 kHz and at 50 Hz."""
        for hz, count in ((50, 150), (2000, 6000)):
            p50: dict[str, list[float]] = defaultdict(list)
            p99: dict[str, list[float]] = defaultdict(list)
            for _ in range(self.rounds):
                for lib in ("rospy", "roscpp", "ours", "bare"):
                    _, got = self.pair(lib, "publish_steady", lib, "one_way", count=count, hz=hz)
                    _percentiles(got["times"], p50[lib], p99[lib])
            self._latency(f"one way at {hz} Hz", p50, p99, 0.8, 0.4)

    def _latency(self, title: str, p50: Any, p99: Any, rospy: float, roscpp: float) -> None:
        print(f"\n{title}: microseconds")
        for lib in p50:
            print(f"  {lib:10} p50 {spread(p50[lib])}   p99 {spread(p99[lib])}")
        rows = {
            "ours": f"{title}: median; 99th percentile",
            "bare": f"{title}, bare sockets",
        }
        for lib, must in (("rospy", rospy), ("roscpp", roscpp)):
            for mine, row in rows.items():
                for name, times in (("p50", p50), ("p99", p99)):
                    label, column = f"{name} {mine} / {lib}", f"beside {lib}"
                    self._ratio(label, times[mine], times[lib], must, row, column, more=False)

    def _ratio(
        self,
        label: str,
        ours: list[float],
        theirs: list[float],
        must: float,
        row: str = "",
        column: str = "beside rospy",
        *,
        more: bool,
    ) -> None:
        values = ratios(ours, theirs)
        print_ratio(label, values, must, more=more)
        if row:
            self.table.add(row, column, values)

    def measure_compute(self) -> None:
        """VGA images at 100 Hz while a thread of the subscriber computes."""
        share: dict[str, list[float]] = defaultdict(list)
        for _ in range(min(3, self.rounds)):
            for lib in ("rospy", "ours"):
                sent, got = self.pair(
                    "ours",
                    "publish_steady",
                    lib,
                    "count",
                    type="sensor_msgs/Image",
                    size=VGA,
                    hz=100,
                    count=300,
                    compute=1,
                    queue_size=3,
                )
                share[lib].append((got["received"] + 1) / sent["sent"])
        print("\nVGA at 100 Hz beside a computing thread: delivered")
        for lib, values in share.items():
            print(f"  {lib:10} {statistics.median(values):.1%}")

    def start_up(self, lib: str) -> dict[str, float]:
        process = self.start(lib, "first_message", started=time.monotonic())
        try:
            return _last(process, 30)
        finally:
            process.kill()
            process.wait(5)

    def measure_start(self) -> None:
        """Process start to first message, import, memory."""
        self.renew_master()
        publisher = self.start("ours", "publish_steady", hz=200, count=100_000)
        values: dict[str, dict[str, list[float]]] = {lib: defaultdict(list) for lib in ("rospy", "ours")}
        try:
            for _ in range(self.rounds):
                for lib, table in values.items():
                    for key, value in self.start_up(lib).items():
                        table[key].append(value)
        finally:
            publisher.kill()
            publisher.wait(5)
        print("\nprocess start to first message; import; resident memory")
        for lib, table in values.items():
            first, imported, memory = (statistics.median(table[k]) for k in ("first", "imported", "rss"))
            print(f"  {lib:10} {first * 1e3:6.0f} ms   {imported * 1e3:6.0f} ms   {memory / 1e6:6.1f} MB")
        for key, must, row in (
            ("first", 0.4, "from starting Python to the first message"),
            ("imported", 0.25, ""),
            ("rss", 0.75, "resident memory"),
        ):
            self._ratio(
                f"{key} ours / rospy", values["ours"][key], values["rospy"][key], must, row, more=False
            )

    def measure_service(self) -> None:
        """Calls of a service, persistent and one-shot."""
        for persistent, must in ((True, 1.1), (False, 0.5)):
            p50: dict[str, list[float]] = defaultdict(list)
            p99: dict[str, list[float]] = defaultdict(list)
            for _ in range(self.rounds):
                for lib in ("rospy", "ours"):
                    result, _ = self.pair(
                        lib, "call", lib, "provide", persistent=persistent, count=300, life=60
                    )
                    _percentiles(result["times"], p50[lib], p99[lib])
            print(f"\nservice, {'persistent' if persistent else 'one-shot'}: microseconds")
            for lib in p50:
                print(f"  {lib:10} p50 {spread(p50[lib])}   p99 {spread(p99[lib])}")
            self._ratio("p50 ours / rospy", p50["ours"], p50["rospy"], must, more=False)

    def measure_fan(self) -> None:
        """Memory and threads per link of a process that subscribes many topics."""
        print("\nsubscriptions held by one process: memory and threads per topic")
        for lib in ("rospy", "ours"):
            self.renew_master()
            process = self.start(lib, "fan_out", topics=200, life=3)
            try:
                got = _last(process, 60)
            finally:
                process.kill()
                process.wait(5)
            print(
                f"  {lib:10} {got['rss'] / got['held'] / 1024:6.1f} KiB   {got['threads'] / got['held']:.2f} threads"
            )


def raw_socket(size: int, seconds: float) -> float:
    """Messages/s of `size` bytes from one process to another, received whole into fresh memory."""
    code = (
        "import socket,sys,time\n"
        "s=socket.create_connection(('127.0.0.1',int(sys.argv[1]))); d=bytes(int(sys.argv[2]))\n"
        "e=time.monotonic()+float(sys.argv[3])\n"
        "while time.monotonic()<e: s.sendall(d)\n"
    )
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        sender = subprocess.Popen([sys.executable, "-c", code, str(port), str(size), str(seconds)])
        connection, _ = server.accept()
        with connection:
            began, count = time.monotonic(), 0
            while connection.recv_into(bytearray(size), 0, socket.MSG_WAITALL) == size:
                count += 1
            took = time.monotonic() - began
        sender.wait(10)
    return count / took


def _other_version() -> bool:
    done = subprocess.run(
        [ros.PYTHON, "-c", "import sys; print(sys.version_info[:2])"], capture_output=True, text=True
    )
    return done.stdout.strip() != str(sys.version_info[:2])


def _answer(process: subprocess.Popen[str], key: str) -> dict[str, Any]:
    assert process.stdout is not None
    for line in process.stdout:
        if line.startswith("{"):
            values: dict[str, Any] = json.loads(line)
            if key in values:
                return values
    raise RuntimeError(f"{process.args} ended without {key!r}")


def _last(process: subprocess.Popen[str], timeout: float) -> dict[str, Any]:
    """The last JSON line of a process."""
    text, _ = process.communicate(timeout=timeout)
    lines = [line for line in text.splitlines() if line.startswith("{")]
    if not lines:
        raise RuntimeError(f"{process.args} said nothing")
    result: dict[str, Any] = json.loads(lines[-1])
    return result


def _percentiles(times: list[float], p50: list[float], p99: list[float]) -> None:
    times = sorted(times)
    p50.append(times[len(times) // 2])
    p99.append(times[len(times) * 99 // 100])
