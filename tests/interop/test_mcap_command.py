"""The `mcap` command line (a Go program) reads what we write, and we read what it writes.

No registry has it: ROSPROTO_MCAP_COMMAND names a built one, else `mcap` is looked for in PATH. Shown with version 0.0.62.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from rosproto.bag import open_bag
from rosproto.cli import main
from tests.interop.test_mcap_peers import a_bag

pytest.importorskip("mcap", reason="mcap is not installed (extra mcap)")

KILLED = """
import os, signal, sys
from rosproto.bag.mcap import McapWriter
from rosproto.codec import message_class
String = message_class("std_msgs/String")
writer = McapWriter(sys.argv[1], "lz4", 4000)
for number in range(1000):
    writer.write("/said", String(data=f"text {number}" * 5), 1000.0 + number)
os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.fixture(scope="module")
def command() -> str:
    found = os.environ.get("ROSPROTO_MCAP_COMMAND") or shutil.which("mcap")
    if found is None:  # also where interop is required: no registry has it, so no machine of ours installs it
        pytest.skip("there is no mcap command: ROSPROTO_MCAP_COMMAND names a built one")
    return found


def run(command: str, *words: str | Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [command, *map(str, words)], capture_output=True, text=True, timeout=60, check=False
    )


def said(command: str, *words: str | Path) -> str:
    """What it prints; it must not complain."""
    done = run(command, *words)
    assert (done.returncode, done.stderr) == (0, ""), done
    return done.stdout


def told(command: str, path: Path) -> list[dict[str, Any]]:
    """Each message as `mcap cat` decodes it, but for its number, which MCAP lets every writer count as it likes."""
    # Its numbers for times have nine digits behind the point: as floats they would lose some.
    lines = [json.loads(line, parse_float=str) for line in said(command, "cat", "--json", path).splitlines()]
    return [{name: value for name, value in line.items() if name != "sequence"} for line in lines]


@pytest.mark.parametrize("compression", ["none", "lz4", "zstd"])
def test_it_finds_nothing_wrong_and_every_message(tmp_path: Path, command: str, compression: str) -> None:
    """`doctor`, `info`, `list` and `cat` of what `bag convert` and `bag export` write."""
    expected = a_bag(tmp_path / "a.bag")
    bag, ours = str(tmp_path / "a.bag"), tmp_path / "a.mcap"
    words = {"none": ["convert", bag, str(ours)], "lz4": ["convert", bag, str(ours), "--lz4"]}
    assert main(["bag", *words.get(compression, ["export", bag, "mcap", "-o", str(ours)])]) == 0

    assert said(command, "doctor", ours) == ""
    told_of = said(command, "info", ours)
    assert re.search(r"profile:\s+ros1\b", told_of)
    assert re.search(r"messages:\s+400\b", told_of)
    assert re.search(r"/scan\s+200 msgs .* sensor_msgs/LaserScan \[ros1msg\]", told_of)
    assert '"callerid":"/robot"' in said(command, "list", "channels", ours)
    assert "float32[] ranges" in said(command, "list", "schemas", ours)
    if compression != "none":
        assert compression in said(command, "list", "chunks", ours)
    assert [(line["topic"], line["log_time"].replace(".", "")) for line in told(command, ours)] == [
        (topic, time) for topic, time, _ in expected
    ]


def test_its_own_conversion_says_the_same(tmp_path: Path, command: str) -> None:
    """`mcap convert` and `bag convert` of one bag: the same decoded messages; ours reads both, and finds both sound."""
    a_bag(tmp_path / "a.bag")
    ours, theirs = tmp_path / "ours.mcap", tmp_path / "theirs.mcap"
    assert main(["bag", "convert", str(tmp_path / "a.bag"), str(ours)]) == 0
    assert run(command, "convert", tmp_path / "a.bag", theirs).returncode == 0  # draws a bar on stderr
    assert told(command, ours) == told(command, theirs) != []
    assert main(["bag", "check", "-q", str(ours), str(theirs)]) == 0
    with open_bag(ours) as left, open_bag(theirs) as right:
        assert [(topic, raw.data, time) for topic, raw, time in left.read_messages(raw=True)] == [
            (topic, raw.data, time) for topic, raw, time in right.read_messages(raw=True)
        ]


@pytest.mark.skipif(os.name != "posix", reason="kills by a signal")
def test_it_recovers_what_a_killed_recorder_left(tmp_path: Path, command: str) -> None:
    """The messages that we read of such a file, it recovers too, and we read what it makes of them."""
    left, recovered = tmp_path / "left.mcap", tmp_path / "recovered.mcap"
    assert subprocess.run([sys.executable, "-c", KILLED, str(left)], timeout=60, check=False).returncode < 0
    assert run(command, "doctor", left).returncode == 1
    assert run(command, "recover", left, "-o", recovered).returncode == 0
    assert said(command, "doctor", recovered) == ""
    with open_bag(left) as ours, open_bag(recovered) as theirs:
        assert ours.damage
        assert not theirs.damage
        expected = [message.data for _, message, _ in ours]
        assert [message.data for _, message, _ in theirs] == expected
    assert 800 < len(expected) < 1000


def test_we_read_what_it_sorts_and_merges(tmp_path: Path, command: str) -> None:
    """Messages and times through `mcap sort`, `filter` and `merge`."""
    expected = a_bag(tmp_path / "a.bag")
    ours = tmp_path / "a.mcap"
    assert main(["bag", "convert", str(tmp_path / "a.bag"), str(ours), "--lz4"]) == 0
    for verb, words in (("sort", [ours]), ("filter", [ours]), ("merge", [ours, ours])):
        made = tmp_path / f"{verb}.mcap"
        assert run(command, verb, *words, "-o", made).returncode == 0
        with open_bag(made) as bag:
            assert not bag.damage
            found = [(topic, str(time.to_nsec())) for topic, _, time in bag.read_messages(raw=True)]
        once = [(topic, time) for topic, time, _ in expected]
        assert sorted(found) == sorted(once * len(words))
