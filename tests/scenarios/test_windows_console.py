"""What a Windows console tells a command: Ctrl-C, its closing. The robot stands afterwards.

The events are raised as Windows raises them, by a thread that begins in the program at kernel32's CtrlRoutine: no
console is needed for it. tests/windows/test_console.py types a real Ctrl-C.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

if sys.platform != "win32":
    pytest.skip("Windows' consoles", allow_module_level=True)

import ctypes

import rosproto
from msgdefs.std_msgs.msg import String
from woosh_pure.enums import TaskState

ROOT = Path(__file__).resolve().parents[2]
CTRL_C, CLOSE = 0, 2


def start(module: str, *arguments: str) -> subprocess.Popen[str]:
    """A command in a process of its own."""
    return subprocess.Popen(
        [sys.executable, "-m", module, *arguments],
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True, encoding="utf-8", env={**os.environ, "PYTHONIOENCODING": "utf-8"},
    )  # fmt: skip


def console_event(process: subprocess.Popen[str], event: int) -> None:
    """Have the program's console handlers called."""
    kernel = ctypes.WinDLL("kernel32", use_last_error=True)
    library = ctypes.WinDLL("kernelbase")
    routine = ctypes.cast(library.CtrlRoutine, ctypes.c_void_p)  # at the same address in every process
    kernel.CreateRemoteThread.restype = ctypes.c_void_p
    kernel.CreateRemoteThread.argtypes = [
        ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_ulong,
        ctypes.c_void_p,
    ]  # fmt: skip
    thread = kernel.CreateRemoteThread(int(process._handle), None, 0, routine, event, 0, None)
    assert thread, ctypes.WinError(ctypes.get_last_error())
    kernel.CloseHandle(ctypes.c_void_p(thread))


@pytest.mark.slow  # a Windows process connects and stops: 5 s and more under Wine
@pytest.mark.parametrize(("event", "code"), [(CTRL_C, 130), (CLOSE, 143)])
def test_an_event_of_the_console_stops_the_motion(sim, until, event, code) -> None:
    """Wine's C runtime makes no SIGBREAK of Ctrl-Break, so that is left out."""
    process = start("woosh_pure", "--master", sim.master_uri, "goto", "B1")
    try:
        until(lambda: not sim.world.body.velocity.is_standing(), 60.0)
        console_event(process, event)
        out, err = process.communicate(timeout=60)
    finally:
        process.kill()
    assert sim.world.tasks.state is TaskState.CANCELLED
    assert sim.world.body.velocity.is_standing()
    assert process.returncode == code, err
    assert "stands still" in out
    assert "Traceback" not in err


@pytest.mark.slow
def test_a_recording_whose_console_is_closed_is_a_whole_bag(tmp_path) -> None:
    """The index is written before the process ends."""
    with (
        rosproto.Master() as master,
        rosproto.Node("/talker", master_uri=master.uri) as node,
        node.publisher("/words", String, latch=True) as words,
    ):
        words.publish(data="kept")
        process = start(
            "rosproto", "bag", "record", "--master", master.uri, "-O", str(tmp_path / "run.bag"), "/words"
        )
        try:
            words.wait_for_connection(timeout=60.0)
            console_event(process, CLOSE)
            _, err = process.communicate(timeout=60)
        finally:
            process.kill()
    assert [path.name for path in tmp_path.iterdir()] == ["run.bag"], err
    with rosproto.BagReader(tmp_path / "run.bag") as bag:
        assert bag.damage == []
        assert set(bag.topics) <= {"/words"}
