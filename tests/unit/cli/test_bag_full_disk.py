"""Commands that write recordings, on a disk that has no room for them."""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from rosproto.bag import BagReader, BagWriter
from rosproto.codec import message_class

pytestmark = pytest.mark.skipif(os.name != "posix", reason="limits the size of files by RLIMIT_FSIZE")
LaserScan = message_class("sensor_msgs/LaserScan")

# What a full disk does, a limit on the size of files does too; one process for all commands.
CODE = """
import contextlib, io, json, os, resource, sys
from rosproto.cli import main
lines, folder = json.loads(sys.argv[1]), sys.argv[2]
resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))
told = []
for line in lines:
    said = io.StringIO()
    with contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
        code = main(["bag", *line])
    told.append((code, said.getvalue(), sorted(os.listdir(folder))))
print(json.dumps(told))
"""


def test_a_sentence_and_nothing_that_passes_for_the_whole(tmp_path: Path) -> None:
    """convert to MCAP, to ROS 2, export to Parquet: the recording stays as it is, and no half of anything."""
    source, folder = tmp_path / "a.bag", tmp_path / "out"
    folder.mkdir()
    with BagWriter(source) as bag:
        for i in range(300):
            noise = os.urandom(4000)
            bag.write(
                "/scan",
                LaserScan(ranges=[float(x) for x in noise[:500]], intensities=list(noise[:500])),
                i + 1.0,
            )
    before = source.read_bytes()
    packages = {"mcap": "a.mcap", "rosbags": "ros2", "pyarrow": "a.parquet"}
    words = {
        "mcap": ["convert", str(source), str(folder / "a.mcap")],
        "rosbags": ["convert", "--ros2", str(source), str(folder / "ros2")],
        "pyarrow": ["export", str(source), "parquet", "-o", str(folder / "a.parquet")],
    }
    present = [name for name in packages if importlib.util.find_spec(name) is not None]
    if not present:
        pytest.skip("none of mcap, rosbags and pyarrow is installed")
    done = subprocess.run(
        [sys.executable, "-c", CODE, json.dumps([words[name] for name in present]), str(folder)],
        capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    for name, (code, said, left) in zip(present, json.loads(done.stdout), strict=True):
        assert code != 0, name
        assert len(said.strip().splitlines()) == 1, said
        assert "Traceback" not in said, said
        assert left == [], (name, left)
    assert source.read_bytes() == before
    with BagReader(source) as bag:
        assert bag.message_count == 300
