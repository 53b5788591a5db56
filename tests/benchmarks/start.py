"""Process start to first message, import time and resident memory, beside rospy; and what each import costs.

    python -m tests.benchmarks start [--rounds 9] [--commands FOLDER] [--old TREE]

The first table is that of `transport --only start`. The second is of fresh interpreters that only import. The
third, processor time of the commands' `--help` and of a simulated chassis, is that of `processor` alone.
"""

from __future__ import annotations

import argparse
import statistics
import subprocess
import tempfile
from pathlib import Path

from tests.benchmarks import processor
from tests.benchmarks.transport import Bench

IMPORTS = {
    "nothing": "pass",
    "rosproto": "import rosproto",
    "rosproto.Node": "import rosproto; rosproto.Node",
    "rosproto.Node, a Twist": "import rosproto; rosproto.Node; rosproto.message_class('geometry_msgs/Twist')",
    "rosproto.Node, an Image": "import rosproto; rosproto.Node; rosproto.message_class('sensor_msgs/Image')().data",
    "rosproto.aio": "import rosproto.aio; rosproto.aio.Node",
    "woosh_pure": "import woosh_pure; woosh_pure.Chassis",
    "rospy": "import rospy",
    "rospy, a Twist": "import rospy; from geometry_msgs.msg import Twist",
}
CODE = """
import time
began = time.perf_counter()
{}
took = time.perf_counter() - began
with open("/proc/self/statm") as file:
    print(took, int(file.read().split()[1]) * 4096)
"""


def run(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="tests.benchmarks start")
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--commands", type=Path, help="as of `processor`")
    parser.add_argument("--old", type=Path, help="as of `processor`")
    args = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as folder, Bench(Path(folder), args.rounds, 1.0) as bench:
        bench.measure_start()
        found: dict[str, list[tuple[float, int]]] = {label: [] for label in IMPORTS}
        for _ in range(args.rounds):
            for label, code in IMPORTS.items():
                found[label].append(imported(bench, label, code))
    print("\nimport alone: milliseconds, resident MB (each in a fresh interpreter; modules of it included)")
    for label, values in found.items():
        took, memory = (statistics.median(column) for column in zip(*values, strict=True))
        print(f"  {label:26} {took * 1e3:7.1f} ms   {memory / 1e6:6.1f} MB")
    processor.measure(args.rounds, args.commands, args.old)


def imported(bench: Bench, label: str, code: str) -> tuple[float, int]:
    """Seconds and bytes of one fresh interpreter."""
    library = "rospy" if label.startswith("rospy") else "ours"
    python = bench.python if library == "ours" else "/usr/bin/python3"
    done = subprocess.run(
        [python, "-c", CODE.format(code)],
        capture_output=True,
        text=True,
        timeout=60,
        env=bench._env(library, bench.uri),
        check=True,
    )
    seconds, memory = done.stdout.split()
    return float(seconds), int(memory)
