"""With every file in use, whatever is opened says so in our words, names the limit, and leaves nothing behind."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

if sys.platform == "win32":
    pytest.skip("there is no such limit", allow_module_level=True)

ROOT = Path(__file__).resolve().parents[3]
PROGRAM = """
import json, os, resource, sys, time
from rosproto import Master, Node
from rosproto.errors import RosError

def used():
    return max(map(int, os.listdir("/dev/fd")))

def tried(make, few):
    '''What `make()` raises when the process may open so few files more; and what stays open of it.'''
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    before = len(os.listdir("/dev/fd"))
    resource.setrlimit(resource.RLIMIT_NOFILE, (before + few, hard))
    try:
        made = make()
        result = ["made", ""]
    except RosError as error:
        made, result = None, [type(error).__name__, str(error)]
    except BaseException as error:
        made, result = None, ["bare " + type(error).__name__, str(error)]
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    if made is not None:
        made.close()
    until = time.monotonic() + 3.0  # the master in this process closes its ends a little later
    while (left := len(os.listdir("/dev/fd")) - before) > 0 and time.monotonic() < until:
        time.sleep(0.01)
    return [*result, left]

with Master() as master:
    make = {
        "node": lambda: Node("/n", master_uri=master.uri, timeout=5.0),
        "master": Master,
    }[sys.argv[1]]
    if sys.argv[2] == "warm":
        make().close()
    print(json.dumps([tried(make, few) for few in range(0, 24)]))
"""


def outcomes(*arguments: str) -> list[Any]:
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, *arguments], capture_output=True, text=True, timeout=120, cwd=ROOT
    )
    assert done.returncode == 0, done.stderr
    found: list[Any] = json.loads(done.stdout)
    return found


@pytest.mark.slow
@pytest.mark.parametrize("state", ["warm", "cold"])
@pytest.mark.parametrize("what", ["node", "master"])
def test_opening(what: str, state: str) -> None:
    """However many files are left, from none to enough; also when modules are still to be imported."""
    found = outcomes(what, state)
    refused = [row for row in found if row[0] != "made"]
    assert {row[0] for row in refused} <= {"ConnectionLost", "RosTimeout"}, refused
    told = [text for _, text, _ in refused if "too many open files" in text]
    # The master is in this process: it may be the one that has no file for the connection, and does not answer.
    assert len(told) >= len(refused) - 4, refused
    assert all("the limit is" in text and "ulimit -n" in text for text in told), told
    assert found[-1][0] == "made", found[-1]
    assert not [row for row in found if row[2] > 0]


def test_the_first_message() -> None:
    """It imports what encodes it."""
    program = """
import os, resource
from rosproto import Master, Node
from rosproto.errors import ConnectionLost
with Master() as master, Node("/n", master_uri=master.uri, rosout=False) as node:
    publisher = node.publisher("/scan", "sensor_msgs/LaserScan", latch=True)
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (3, hard))
    try:
        publisher.publish(ranges=[1.0])
        print("published")
    except ConnectionLost as error:
        text = str(error)
    resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    assert "publish /scan: too many open files" in text, text
    assert "the limit is 3" in text, text
    publisher.publish(ranges=[1.0])
    print("fine")
"""
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=60, cwd=ROOT
    )
    assert done.stdout == "fine\n", done.stderr
