"""No file can be opened any more: an error of ours, whichever module or file it hits."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from rosproto.bag import BagWriter, open_bag
from rosproto.codec import message_class
from rosproto.errors import BagError

pytest.importorskip("resource", reason="this system has no limit of open files")

PROGRAM = """
import os, resource, sys, traceback
path, verb, loaded, spare = sys.argv[1], sys.argv[2], sys.argv[3], int(sys.argv[4])
import rosproto
from rosproto.errors import RosError
if verb == "write":
    message = rosproto.message_class("std_msgs/String")(data="x")
if loaded == "loaded":
    import rosproto.bag
resource.setrlimit(resource.RLIMIT_NOFILE, (64, 64))
taken = []
try:
    while True:
        taken.append(os.open(os.devnull, os.O_RDONLY))
except OSError:
    pass
for _ in range(spare):
    os.close(taken.pop())
try:
    if verb == "read":
        with rosproto.BagReader(path) as bag:
            count = sum(1 for _ in bag)
    elif verb == "raw":
        with rosproto.BagReader(path) as bag:
            count = sum(1 for _ in bag.read_messages(raw=True))
    elif verb == "times":
        with rosproto.BagReader(path) as bag:
            count = len(bag.times("/said"))
    elif verb == "message_at":
        with rosproto.BagReader(path) as bag:
            count = len(bag.message_at("/said", 5.0))
    else:
        with rosproto.BagWriter(path + ".new", "lz4") as bag:
            for i in range(1000):
                bag.write("/said", message, 1.0)
            count = bag.message_count
    found = f"{count} messages"
except RosError as error:
    found = f"{type(error).__name__}: {error}"
except BaseException:
    for file in taken:
        os.close(file)
    traceback.print_exc()
    found = "not ours"
for file in taken[:8]:
    try:
        os.close(file)
    except OSError:
        pass
print(found)
"""


@pytest.mark.parametrize("verb", ["read", "raw", "times", "message_at", "write"])
@pytest.mark.parametrize("loaded", ["loaded", "not loaded"])
@pytest.mark.parametrize("spare", [0, 1, 2])
def test_no_file_left_is_an_error_of_ours(verb: str, loaded: str, spare: int, tmp_path: Path) -> None:
    """It says which file or module cannot be opened; with files to spare there may be no error at all."""
    path = tmp_path / "run.bag"
    with BagWriter(path, "lz4") as bag:
        for i in range(10):
            bag.write("/said", message_class("std_msgs/String")(data="x" * 10), float(i))
    words = [sys.executable, "-c", PROGRAM, str(path), verb, loaded, str(spare)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60, check=True)
    assert "not ours" not in done.stdout, done.stderr
    if spare == 0:
        assert "Too many open files" in done.stdout


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_pipe_is_refused_at_once(tmp_path: Path) -> None:
    """Opening it would wait for a writer, perhaps for ever."""
    os.mkfifo(tmp_path / "pipe.bag")
    with pytest.raises(BagError, match="this is a pipe"):
        open_bag(tmp_path / "pipe.bag")
