"""The library inside a program: importing it does nothing, and cycles of use leave nothing behind."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
import threading
import tracemalloc
from collections.abc import Iterator
from pathlib import Path

import pytest

from rosproto.master import Master
from rosproto.node import Node
from tests.support.victim import eventually

ROOT = Path(__file__).resolve().parents[2]
STRING = "std_msgs/String"

LOOK = """
import logging, os, signal, socket, sys, threading
def look():
    return {
        "threads": sorted(thread.name for thread in threading.enumerate()),
        "files": len(os.listdir("/proc/self/fd")) if os.path.isdir("/proc/self/fd") else 0,
        "signals": {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)},
        "environment": dict(os.environ),
        "directory": os.getcwd(),
        "root handlers": list(logging.getLogger().handlers),
        "root level": logging.getLogger().level,
        "our handlers": [h for n in ("rosproto", "rosproto.node", "ros") for h in logging.getLogger(n).handlers],
        "timeout": socket.getdefaulttimeout(),
        "recursion": sys.getrecursionlimit(),
        "switching": sys.getswitchinterval(),
        "excepthook": (sys.excepthook is sys.__excepthook__, threading.excepthook is threading.__excepthook__),
        "stdout": (sys.stdout is sys.__stdout__, sys.stderr is sys.__stderr__),
    }
before = look()
reads = []
real = type(os.environ).__getitem__
type(os.environ).__getitem__ = lambda self, key: (reads.append(key), real(self, key))[1]
"""


@pytest.mark.parametrize("module", ["rosproto", "rosproto.node", "rosproto.master", "rosproto.action", "rosproto.aio",
                                    "rosproto.bag", "rosproto.tf", "rosproto.recording", "woosh_pure"])  # fmt: skip
def test_importing_does_nothing_to_the_process(module: str) -> None:
    """No thread, file, signal handler, logging handler, default timeout; no ROS variable is read."""
    code = LOOK + f"import {module}\n" + (
        f"for name in getattr({module}, '__all__', ()): getattr({module}, name)\n"
        "type(os.environ).__getitem__ = real\n"
        "after = look()\n"
        "different = {key: (before[key], after[key]) for key in before if before[key] != after[key]}\n"
        "assert not different, different\n"
        "assert not [key for key in reads if str(key).startswith('ROS')], reads\n"
    )  # fmt: skip
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, cwd=ROOT)
    assert done.returncode == 0, done.stderr
    assert done.stdout == done.stderr == ""


def test_a_life_of_nodes_changes_no_settings() -> None:
    """After a master, nodes, topics and services were used and closed, the process is as it was (pitfall 37)."""
    code = LOOK + (
        "import time\n"
        "from rosproto import Master, Node\n"
        "with Master() as m, Node('/a', master_uri=m.uri) as a, Node('/b', master_uri=m.uri, intraprocess=False) as b:\n"
        "    a.publisher('/t', 'std_msgs/String', latch=True).publish(data='x')\n"
        "    assert b.subscriber('/t').next(10).data == 'x'\n"
        "    a.service_server('/s', 'std_srvs/Empty', lambda request: {})\n"
        "    b.service_client('/s', 'std_srvs/Empty').call()\n"
        "    b.params['/x'] = 1\n"
        "    assert socket.getdefaulttimeout() is None\n"
        "end = time.monotonic() + 10\n"
        "while look()['threads'] != before['threads'] and time.monotonic() < end: time.sleep(0.02)\n"
        "after = look()\n"
        "different = {key: (before[key], after[key]) for key in before if before[key] != after[key] and key != 'files'}\n"
        "assert not different, different\n"
        "assert after['files'] <= before['files'] + 1, (before['files'], after['files'])\n"
        "assert not [key for key in reads if str(key).startswith('ROS')], reads\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, cwd=ROOT)
    assert done.returncode == 0, done.stderr


def open_files() -> int:
    """Open files and sockets of this process; 0 where the system does not tell."""
    try:
        return len(os.listdir("/proc/self/fd"))
    except OSError:
        return 0


@pytest.fixture
def traced() -> Iterator[None]:
    """Memory allocated by Python is counted."""
    tracemalloc.start()
    yield
    tracemalloc.stop()


def held() -> int:
    """Bytes that Python holds, garbage collected."""
    gc.collect()
    return tracemalloc.get_traced_memory()[0]


@pytest.mark.slow
@pytest.mark.timeout(300)
@pytest.mark.parametrize("intraprocess", [False, True], ids=["tcp", "local"])
def test_a_thousand_subscriptions_leave_nothing(intraprocess: bool, traced: None) -> None:
    """Subscribed, connected, a message, closed: threads, sockets and memory are where they were."""
    with (
        Master() as master,
        Node("/source", master_uri=master.uri, intraprocess=intraprocess) as source,
        Node("/cycles", master_uri=master.uri, intraprocess=intraprocess) as node,
    ):
        publisher = source.publisher("/t", STRING, latch=True)
        publisher.publish(data="kept")

        def cycle() -> None:
            with node.subscriber("/t", STRING) as subscriber:
                assert subscriber.next(10).data == "kept"

        for _ in range(50):
            cycle()
        eventually(lambda: publisher.connections == 0)
        threads, files, memory = threading.active_count(), open_files(), held()
        for _ in range(1000):
            cycle()
        eventually(lambda: publisher.connections == 0)
        eventually(lambda: threading.active_count() <= threads + 2, 20, "the end of threads")
        eventually(lambda: open_files() <= files + 2, 20, "the end of sockets")
        grown = held() - memory
        assert grown < 300_000, f"{grown} bytes more are held after 1000 cycles"


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_two_hundred_nodes_leave_nothing(traced: None) -> None:
    """Opened with a publisher, a subscriber, services, a parameter subscription; closed."""
    with Master() as master:

        def cycle() -> None:
            with Node("/cycle", master_uri=master.uri, intraprocess=False) as node:
                publisher, subscriber = node.publisher("/own", STRING), node.subscriber("/own", STRING)
                publisher.wait_for_connection(10)
                publisher.publish(data="x")
                assert subscriber.next(10).data == "x"
                node.service_server("/s", "std_srvs/Empty", lambda request: {})
                node.service_client("/s", "std_srvs/Empty").call()
                node.params.subscribe("/p", lambda key, value: None)

        for _ in range(10):
            cycle()
        eventually(lambda: master.stats()["connections"] == 0, 20)
        threads, files, memory = threading.active_count(), open_files(), held()
        for _ in range(200):
            cycle()
        eventually(lambda: master.stats()["connections"] == 0, 20)
        eventually(lambda: threading.active_count() <= threads + 2, 20, "the end of threads")
        eventually(lambda: open_files() <= files + 2, 20, "the end of sockets")
        grown = held() - memory
        assert grown < 300_000, f"{grown} bytes more are held after 200 nodes"


def test_nodes_open_and_close_in_many_threads_at_once() -> None:
    """Eight threads, five lives each, all masters and nodes their own."""
    problems: list[BaseException] = []

    def live(number: int) -> None:
        try:
            for _ in range(5):
                with Master() as master, Node(f"/n{number}", master_uri=master.uri) as node:
                    node.publisher("/t", STRING, latch=True).publish(data=str(number))
                    assert node.subscriber("/t", STRING).next(20).data == str(number)
        except BaseException as error:
            problems.append(error)

    threads = [threading.Thread(target=live, args=(number,), daemon=True) for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
        assert not thread.is_alive()
    assert not problems
