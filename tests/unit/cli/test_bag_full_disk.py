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
Image = message_class("sensor_msgs/Image")

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
    left = [name for _, _, files in os.walk(folder) for name in files]
    told.append((code, said.getvalue(), left))
print(json.dumps(told))
"""


def test_a_sentence_and_nothing_that_passes_for_the_whole(tmp_path: Path) -> None:
    """The sentence names the file that could not be written; the recording stays as it is."""
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
        bag.write(
            "/image", Image(height=300, width=300, encoding="rgb8", step=900, data=os.urandom(270_000)), 1.0
        )
    before = source.read_bytes()
    lines = {  # what is written: the command, and the package it needs
        "filtered.bag": (["filter", "a.bag", "out/filtered.bag"], "numpy"),
        "merged.bag": (["merge", "out/merged.bag", "a.bag"], "numpy"),
        "fixed.bag": (["fix", "a.bag", "out/fixed.bag"], "numpy"),
        "a.bag": (["compress", "--lz4", "--output-dir", "out", "a.bag"], "numpy"),
        "a.mcap": (["convert", "a.bag", "out/a.mcap"], "mcap"),
        "exported.mcap": (["export", "a.bag", "mcap", "-o", "out/exported.mcap"], "mcap"),
        "ros2": (["convert", "--ros2", "a.bag", "out/ros2"], "rosbags"),
        "scan.csv": (["export", "a.bag", "csv", "-o", "out", "--topics", "/scan"], "numpy"),
        "scan.npz": (["export", "a.bag", "npz", "-o", "out", "--topics", "/scan"], "numpy"),
        "1.000000000.png": (["export", "a.bag", "png", "-o", "out"], "numpy"),
        "scan.parquet": (["export", "a.bag", "parquet", "-o", "out", "--topics", "/scan"], "pyarrow"),
    }
    present = {
        name: words for name, (words, needs) in lines.items() if importlib.util.find_spec(needs) is not None
    }
    done = subprocess.run(
        [sys.executable, "-c", CODE, json.dumps(list(present.values())), str(folder)],
        capture_output=True, text=True, timeout=120, check=False, cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[3])},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    for name, (code, said, left) in zip(present, json.loads(done.stdout), strict=True):
        assert code == 1, name
        assert len(said.strip().splitlines()) == 1, said
        assert "Traceback" not in said, said
        assert name in said
        assert "readable" not in said  # it is gone
        if name != "ros2":  # the package rosbags says it in SQLite's words
            assert "cannot write: " in said
            assert "File too large" in said
        assert left == [], (name, left)
    assert source.read_bytes() == before
    with BagReader(source) as bag:
        assert bag.message_count == 301
