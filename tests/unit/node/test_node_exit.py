"""A program that ends without closing its nodes takes them off the master all the same."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from rosproto.master import Master
from rosproto.node import MasterClient, shutdown
from tests.support.proxy import FaultProxy

OPEN = """
import os, sys, rosproto
from rosproto.node import shutdown
if sys.argv[2] != "as it is":
    shutdown.EXIT_SECONDS = shutdown.CLOSE_SECONDS = float(sys.argv[2])
node = rosproto.Node("/forgetful", master_uri=sys.argv[1])
publisher = node.publisher("/chatter", "std_msgs/String", latch=True)
node.service_server("/serve", "std_srvs/SetBool", lambda request: (True, ""))
node.on_shutdown(lambda reason: print("shutdown", repr(reason)))
print("open", flush=True)
sys.stdin.readline()
"""


@contextmanager
def program(uri: str, code: str = "", patience: str = "20") -> Iterator[subprocess.Popen[str]]:
    """A program that opens a node, waits for a line on its stdin, and does what `code` says.

    It has `patience` seconds for its end, so that a busy computer does not have it give up its farewell.
    """
    process = subprocess.Popen(
        [sys.executable, "-c", OPEN + code, uri, patience],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == "open\n"
        yield process
    finally:
        process.kill()
        process.communicate()


def registered(master: Master) -> list[str]:
    with MasterClient(master.uri, "/test") as client:
        return client.get_system_state().nodes


@pytest.mark.parametrize(
    "code",
    [
        "",
        "raise SystemExit(0)",
        "import logging; logging.warning('logging is set up after the node')",
        "import threading, time; threading.Thread(target=time.sleep, args=(0.1,)).start()",
    ],
    ids=["falls off the end", "exits", "logs", "leaves a thread"],
)
def test_a_node_that_was_not_closed_is_taken_off_the_master(code: str) -> None:
    with Master() as master, program(master.uri, code) as process:
        assert "/forgetful" in registered(master)
        out, _ = process.communicate("\n", timeout=90)
        assert (process.returncode, out) == (0, "shutdown ''\n")
        assert registered(master) == []


BUSY = """
import threading, time
def publish():
    try:
        while True:
            publisher.publish(data="on and on")
    except rosproto.RosError:
        pass  # the node is closed
hears = rosproto.Node("/hears", master_uri=sys.argv[1], intraprocess=False)
heard = threading.Event()
hears.subscriber("/chatter", "std_msgs/String", lambda message: heard.set() or time.sleep(0.002))
threading.Thread(target=publish, daemon=True).start()
heard.wait(20)
"""


def test_a_program_that_ends_amid_its_callbacks_says_nothing() -> None:
    """From CPython 3.12 on no thread can be begun then; links and servers that wanted one are no news."""
    with Master() as master, program(master.uri, BUSY) as process:
        out, errors = process.communicate("\n", timeout=90)
        assert (process.returncode, out, errors) == (0, "shutdown ''\n", "")


def test_it_is_taken_off_after_an_error_too() -> None:
    with Master() as master, program(master.uri, "1 / 0") as process:
        _, errors = process.communicate("\n", timeout=90)
        assert process.returncode == 1
        assert errors.count("Traceback") == 1
        assert registered(master) == []


def test_a_closed_node_is_not_closed_again() -> None:
    with Master() as master, program(master.uri, "node.close(); print('closed')") as process:
        out, errors = process.communicate("\n", timeout=90)
        assert (out, errors) == ("shutdown ''\nclosed\n", "")


def test_the_child_of_a_fork_leaves_its_parents_nodes_alone() -> None:
    """The child ends as a program does; only the parent's end takes the node off."""
    if not hasattr(__import__("os"), "fork"):
        pytest.skip("needs os.fork")
    code = (
        "pid = os.fork()\n"
        "if pid:\n"
        "    print(os.waitpid(pid, 0)[1], rosproto.node.MasterClient(sys.argv[1], '/x').lookup_node('/forgetful') != '')\n"
    )
    with Master() as master, program(master.uri, code) as process:
        out, _ = process.communicate("\n", timeout=90)
        assert out == "0 True\nshutdown ''\n"
        assert registered(master) == []


def test_a_master_that_hangs_does_not_hold_the_program_up() -> None:
    """The end is bounded (`EXIT_SECONDS`), and nothing is raised or logged as an error."""
    with Master() as master, FaultProxy("127.0.0.1", master.port) as proxy:
        with program(f"http://127.0.0.1:{proxy.port}", patience="as it is") as process:
            proxy.stall()
            _, errors = process.communicate("\n", timeout=shutdown.EXIT_SECONDS + 20)
            assert process.returncode == 0
            assert "Traceback" not in errors
        proxy.resume()
