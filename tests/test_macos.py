"""A session on macOS, as far as it can be imitated (tests/support/macos.py): names, sockets, 256 files."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = [pytest.mark.whole, pytest.mark.skipif(sys.platform != "linux", reason="puts macOS over Linux")]

ROOT = Path(__file__).resolve().parents[1]
BEGIN = "from tests.support import macos\nmacos.become_macos()\nimport rosproto, socket, sys, threading\n"


def run(program: str) -> str:
    """Run a program in a process that takes itself for one on macOS; its output."""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", BEGIN + program],
        capture_output=True, text=True, timeout=90, check=False, cwd=ROOT,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Traceback" not in done.stderr, done.stderr
    return done.stdout


def test_topics_services_parameters_and_actions() -> None:
    """Small messages and some that fill every buffer, both kinds of service, an answer that never comes."""
    run("""
with (
    rosproto.Master() as master,
    rosproto.Node("/one", master_uri=master.uri, intraprocess=False) as one,
    rosproto.Node("/two", master_uri=master.uri, intraprocess=False) as two,
):
    out = one.publisher("/bytes", "std_msgs/UInt8MultiArray", queue_size=100)
    heard = two.subscriber("/bytes", "std_msgs/UInt8MultiArray", queue_size=100)
    out.wait_for_connection(10)
    for size in (0, 1, 70_000, 3_000_000):
        out.publish(data=bytes(size))
        assert len(heard.next(10).data) == size
    never = threading.Event()

    def serve(request):
        if not request.data:
            never.wait(20)
        return {"success": True, "message": "x" * 300_000}

    with one.service_server("/serve", "std_srvs/SetBool", serve):
        for persistent in (False, True):
            with two.service_client("/serve", "std_srvs/SetBool", persistent=persistent) as client:
                for _ in range(3):
                    assert len(client.call(data=True, timeout=10).message) == 300_000
                try:
                    client.call(data=False, timeout=0.2)
                except rosproto.RosTimeout:
                    pass
                else:
                    raise AssertionError("it has no time limit")
        never.set()
    two.params["/p"] = {"a": [1, 2.5, "three"]}
    assert one.params["/p/a"] == [1, 2.5, "three"]
assert macos.seen["TCP_KEEPALIVE"] > 4, macos.seen
end = [t for t in threading.enumerate() if t.name.startswith("rosproto:")]
for thread in end:
    thread.join(10)  # one whose server is closed may wait for the processor
left = [t.name for t in end if t.is_alive()]
assert not left, left
""")


def test_connections_that_are_reset_while_they_are_accepted() -> None:
    """`accept` has no address for them, options and `getpeername` fail: the server lives on."""
    run("""
import time
from rosproto.transport import TcpServer
met = []
with TcpServer("127.0.0.1", 0, lambda sock, peer: met.append(peer)) as server:
    server._lock.acquire()  # holds up the loop in its first `_admit`, so that others wait to be accepted
    for _ in range(20):
        macos.reset(socket.create_connection(("127.0.0.1", server.port)))
    time.sleep(0.1)
    server._lock.release()
    with socket.create_connection(("127.0.0.1", server.port)) as sock:
        name = sock.getsockname()
        end = time.monotonic() + 10
        while name not in met:
            assert time.monotonic() < end, (met, macos.seen)
            time.sleep(0.01)
assert macos.seen["accept without address"] > 10, macos.seen
""")


def test_links_and_the_master_come_back() -> None:
    """Every connection of a publisher is cut under it, and the master is another one: all is found again."""
    run("""
with rosproto.Master() as first, rosproto.Node("/hears", master_uri=first.uri, intraprocess=False) as hears:
    heard = hears.subscriber("/words", "std_msgs/String", queue_size=10)
    for word in ("one", "two"):
        with rosproto.Node("/says", master_uri=first.uri, intraprocess=False) as says:
            says.publisher("/words", "std_msgs/String", latch=True).publish(data=word)
            assert heard.next(20).data == word
            for link in says._parts.topics._publications["/words"].all_links:
                link.sock.shutdown(socket.SHUT_RDWR)
            assert heard.next(20).data == word  # latched: again on the new link
    port = first.port
    first.close()
    with rosproto.Master(port=port), rosproto.Node("/says", master_uri=first.uri, intraprocess=False) as says:
        says.publisher("/words", "std_msgs/String", latch=True).publish(data="three")
        assert heard.next(20).data == "three"
""")


@pytest.mark.slow
def test_simulated_chassis_in_a_program_that_was_given_256_files() -> None:
    """Eight have more sockets than that: they ask for as many as they need."""
    run("""
import contextlib, os
from woosh_pure import Chassis, SimulatedChassis
with contextlib.ExitStack() as stack:
    for _ in range(8):
        sim = stack.enter_context(SimulatedChassis(speed=8))
        chassis = stack.enter_context(Chassis(sim.master_uri))
        assert chassis.battery.wait(20).percent == 87
    assert len(os.listdir("/proc/self/fd")) > 256, os.listdir("/proc/self/fd")
""")
