"""A bag of 2 GB: the memory and time of listing, checking and reading it. Not for CI; needs that much disk.

    python -m tests.benchmarks bigbag [--mb 2000] [--compression none|bz2|lz4] [--folder PATH]

The bag (camera, laser, odometry, velocity as a robot sends them) is made in a temporary directory and removed
afterwards. Each case is a process of its own; its memory is the most it ever had resident, interpreter and numpy
included (see the first row).
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from rosproto.bag import BagWriter
from rosproto.time import Time
from tests.benchmarks.bag import mixed_entries

PREFIX = "import sys, time\nbegan = time.perf_counter()\n"
SUFFIX = """
took = time.perf_counter() - began
# Not ru_maxrss: that begins with what the parent had when it forked.
status = open("/proc/self/status").read()
print(f"{took:.2f} {int(status.partition('VmHWM:')[2].split()[0]) // 1024}")
"""
QUIET = "import io, contextlib\nwith contextlib.redirect_stdout(io.StringIO()):\n    "
READ = "from rosproto.bag import BagReader\nwith BagReader(sys.argv[1]) as bag:\n    "
RECORDED = "from rosproto.recording import Timeline\n"
CASES = {
    "import numpy": "import numpy",
    "bag info": QUIET + "from rosproto.cli import main; main(['bag', 'info', sys.argv[1]])",
    "bag info --plain": QUIET
    + "from rosproto.cli import main; main(['bag', 'info', '--plain', sys.argv[1]])",
    "bag check": QUIET + "from rosproto.cli import main; main(['bag', 'check', '-q', sys.argv[1]])",
    "read decoded": READ + "print(sum(1 for _ in bag.read_messages()), file=sys.stderr)",
    "read raw": READ + "print(sum(1 for _ in bag.read_messages(raw=True)), file=sys.stderr)",
    "play's timeline": RECORDED + READ + "print(sum(1 for _ in Timeline([bag])), file=sys.stderr)",
    "rosbag info": "import rosbag; str(rosbag.Bag(sys.argv[1], skip_index=True))",
    "rosbag read raw": "import rosbag\nfor _ in rosbag.Bag(sys.argv[1]).read_messages(raw=True): pass",
}


def run(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="tests.benchmarks bigbag")
    parser.add_argument("--mb", type=int, default=2000)
    parser.add_argument("--compression", default="none")
    parser.add_argument("--folder", help="where to put the bag while it is measured")
    args = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory(dir=args.folder) as folder:
        path = Path(folder) / "big.bag"
        count = write(path, args.mb, args.compression)
        print(
            f"{path.stat().st_size / 1e9:.2f} GB in the file, {args.mb} MB of messages, {count} messages, {args.compression}"
        )
        for name, code in CASES.items():
            measure(name, code, path)


def write(path: Path, megabytes: int, compression: str) -> int:
    """Ten seconds' worth of messages, again and again."""
    block = mixed_entries(50)
    with BagWriter(path, compression) as writer:  # type: ignore[arg-type]
        start = 10**18
        while writer.message_count * 50 < len(block) * megabytes:
            for topic, message, stamp in block:
                writer.write(topic, message, Time(*divmod(start + stamp - 10**18, 10**9)))
            start += len(block) * 10**7
        return writer.message_count


def measure(name: str, code: str, path: Path) -> None:
    theirs = name.startswith("rosbag")
    python = "/usr/bin/python3" if theirs else sys.executable
    env = dict(os.environ) if theirs else os.environ | {"PYTHONPATH": os.getcwd()}
    done = subprocess.run(
        [python, "-c", PREFIX + code + SUFFIX, str(path)],
        env=env,
        capture_output=True,
        text=True,
        timeout=1800,
    )
    if done.returncode:
        print(f"  {name:18} {(done.stderr.strip().splitlines() or ['failed'])[-1]}")
        return
    took, megabytes = done.stdout.split()
    print(f"  {name:18} {float(took):8.2f} s {int(megabytes):6} MB   {done.stderr.strip()}", flush=True)


__all__ = ["run"]
