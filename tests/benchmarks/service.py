"""Service calls beside rospy's: persistent and one-shot, provider and client in two processes, over loopback.

Both sides run on the same Python (Debian's, which rospy needs), turn by turn; the ratio is of the medians of
each turn. Printed: p50 and p99 in µs, and ours/rospy (issue: persistent at most 1.1, one-shot at most 0.5).
"""

from __future__ import annotations

import argparse
import json
import statistics
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

from rosproto.master import Master
from tests.support import ros

ROOT = Path(__file__).resolve().parents[2]

MEASURE = """
import json, sys, time
def measure(call, count):
    times = []
    for _ in range(count):
        start = time.perf_counter_ns()
        call()
        times.append(time.perf_counter_ns() - start)
    return [t / 1000 for t in times]
"""
OUR_SERVER = """
import sys
from rosproto.node import Node
node = Node("/ours", master_uri=sys.argv[1])
server = node.service_server("/ours", "std_srvs/SetBool", lambda request: (request.data, ""))
print("ready", flush=True)
node.wait()
"""
OUR_CLIENT = (
    MEASURE
    + """
from rosproto.node import Node
uri, service, persistent, count = sys.argv[1], sys.argv[2], sys.argv[3] == "1", int(sys.argv[4])
node = Node("/our_client", master_uri=uri, anonymous=True)
client = node.service_client(service, "std_srvs/SetBool", persistent=persistent)
measure(lambda: client.call(data=True), 20)
print(json.dumps(measure(lambda: client.call(data=True), count)))
node.close()
"""
)
ROSPY_SERVER = """
import rospy
from std_srvs.srv import SetBool, SetBoolResponse
rospy.init_node("rospy_server", disable_signals=True)
rospy.Service("/rospy", SetBool, lambda request: SetBoolResponse(request.data, ""))
print("ready", flush=True)
rospy.spin()
"""
ROSPY_CLIENT = (
    MEASURE
    + """
import rospy
from std_srvs.srv import SetBool
service, persistent, count = sys.argv[2], sys.argv[3] == "1", int(sys.argv[4])
rospy.init_node("rospy_client", anonymous=True, disable_signals=True)
rospy.wait_for_service(service)
proxy = rospy.ServiceProxy(service, SetBool, persistent=persistent)
measure(lambda: proxy(True), 20)
print(json.dumps(measure(lambda: proxy(True), count)))
"""
)


def run(arguments: list[str]) -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks service", description=__doc__)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--calls", type=int, default=2000, help="persistent calls per round")
    parser.add_argument("--once", type=int, default=300, help="one-shot calls per round")
    options = parser.parse_args(arguments)
    with TemporaryDirectory() as folder, Master() as master:
        packages = ros.generate_python_packages(Path(folder) / "packages")
        path = f"{packages}:{ROOT}"
        with (
            ros.start_rospy(OUR_SERVER, master.uri, master.uri, packages=path) as ours,
            ros.start_rospy(ROSPY_SERVER, master.uri, packages=path) as theirs,
        ):
            ours.wait_for("ready")
            theirs.wait_for("ready")
            _table(lambda code, *args: _times(code, master.uri, path, *args), options)
    return 0


def _times(code: str, uri: str, path: str, *args: str) -> list[float]:
    done = ros.run_rospy(code, uri, uri, *args, packages=path, timeout=300.0)
    return [float(time) for time in json.loads(done.stdout.splitlines()[-1])]


PAIRS = [
    ("ours -> ours", OUR_CLIENT, "/ours"),
    ("rospy -> rospy", ROSPY_CLIENT, "/rospy"),
    ("ours -> rospy", OUR_CLIENT, "/rospy"),
    ("rospy -> ours", ROSPY_CLIENT, "/ours"),
]


def _table(times: Callable[..., list[float]], options: argparse.Namespace) -> None:
    print(f"{'case':<12}{'pair':<18}{'p50 µs':>10}{'p99 µs':>10}{'ratio to rospy [min-max]':>30}")
    for case, flag, count in (("persistent", "1", options.calls), ("one-shot", "0", options.once)):
        rounds: dict[str, list[list[float]]] = {name: [] for name, _, _ in PAIRS}
        for _ in range(options.rounds):
            for name, code, service in PAIRS:
                rounds[name].append(times(code, service, flag, str(count)))
        for name, samples in rounds.items():
            middle = [statistics.median(sample) for sample in samples]
            late = statistics.median(sorted(sample)[int(len(sample) * 0.99)] for sample in samples)
            base = [statistics.median(sample) for sample in rounds["rospy -> rospy"]]
            ratios = sorted(mine / theirs for mine, theirs in zip(middle, base, strict=True))
            spread = f"{statistics.median(ratios):.2f} [{ratios[0]:.2f}-{ratios[-1]:.2f}]"
            print(f"{case:<12}{name:<18}{statistics.median(middle):>10.1f}{late:>10.1f}{spread:>30}")
