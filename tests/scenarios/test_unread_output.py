"""Commands whose output nobody reads: they stop the robot all the same, in time, and end."""

from __future__ import annotations

import signal
import socket
import subprocess
import sys
import time

import pytest

if sys.platform == "win32":
    pytest.skip("sends POSIX signals", allow_module_level=True)

from rosproto import Master, Node
from tests.support.extras import needs
from tests.support.load import crowd
from tests.support.ports import unused_port
from tests.support.terminal import Terminal
from tests.support.unread import ROOT, full_pipe, unread_command

CODES = {signal.SIGINT: 130, signal.SIGTERM: 143, signal.SIGHUP: 143, signal.SIGQUIT: 143}
SIGNALS = [
    signal.SIGINT,
    *(pytest.param(one, marks=pytest.mark.whole) for one in CODES if one != signal.SIGINT),
]
BOTH = "stdout stderr"
OUTPUTS = [BOTH, *(pytest.param(one, marks=pytest.mark.whole) for one in ("stdout", "stderr"))]
DRIVES = (
    ("move", "9"),
    ("rotate", "3000"),
    ("goto", "A1"),
    ("goto", "--pose", "5", "1", "0"),
    ("task", "pick", "A1"),
    ("charge", "C1"),
    ("shell", "-c", "chassis.move(9).wait(meanwhile=lambda: print('x' * 999, flush=True))"),
)
SOME_DRIVES = [*DRIVES[:3], *(pytest.param(words, marks=pytest.mark.whole) for words in DRIVES[3:])]


def standing(sim) -> bool:
    with sim.lock:
        return sim.world.body.velocity.is_standing()


def begin(command, sim, until) -> None:
    until(lambda: not standing(sim) or command.poll() is not None, 30.0, "the motion")
    assert command.poll() is None


@pytest.mark.promise("nobody reads what a `woosh` command prints")
@pytest.mark.parametrize("words", SOME_DRIVES, ids=lambda words: " ".join(words[:2]))
def test_a_signal_stops_every_motion_although_nobody_reads(words, sim, real_time, until):
    with unread_command("woosh", *words, "--master", sim.master_uri) as command:
        begin(command, sim, until)
        command.send_signal(signal.SIGTERM)
        until(lambda: standing(sim), 5.0 * crowd(), "the stop")
        assert command.wait(15 * crowd()) == 143


@pytest.mark.promise("nobody reads what a `woosh` command prints")
@pytest.mark.parametrize("full", OUTPUTS)
@pytest.mark.parametrize("number", CODES, ids=lambda number: number.name)
def test_a_signal_stops_the_robot_whichever_output_is_full(full, number, sim, real_time, until):
    with unread_command("woosh", "move", "9", "--master", sim.master_uri, full=full) as command:
        begin(command, sim, until)
        command.send_signal(number)
        until(lambda: standing(sim), 5.0 * crowd(), "the stop")
        assert command.wait(15 * crowd()) == CODES[number]


@pytest.mark.slow
@pytest.mark.promise("nobody reads what a `woosh` command prints")
@pytest.mark.parametrize("full", OUTPUTS)
def test_a_time_limit_fires_whichever_output_is_full(full, sim, real_time, until):
    words = ("goto", "A1", "--timeout", "1", "--master", sim.master_uri)
    with unread_command("woosh", *words, full=full) as command:
        begin(command, sim, until)
        until(lambda: standing(sim), 8.0 * crowd(), "the stop")
        assert command.wait(15 * crowd()) == 1


@pytest.mark.promise("SIGQUIT (Ctrl-\\\\) or SIGHUP to a `woosh` command")
@pytest.mark.parametrize("number", SIGNALS, ids=lambda number: number.name)
def test_a_signal_ends_a_drive_on_a_terminal_that_takes_nothing(number, sim, real_time, until):
    """As after Ctrl-S, or with a link to the terminal that is stuck."""
    words = ("drive", "--acknowledged", "--feedback-timeout", "5", "--master", sim.master_uri)
    with Terminal(*words, columns=120) as terminal:
        terminal.wait_for("sent +0.00")
        end = time.monotonic() + 20.0
        while standing(sim):
            assert time.monotonic() < end
            terminal.send("w")
            time.sleep(0.04)
        terminal.suspend()
        terminal.process.send_signal(number)
        until(lambda: standing(sim), 5.0 * crowd(), "the stop")
        assert terminal.process.wait(15 * crowd()) == CODES[number]
        assert terminal.restored


@pytest.fixture
def graph():
    """A master, and a node that counts what comes at /words."""
    with Master() as master, Node("/listener", master_uri=master.uri) as node:
        words = node.subscriber("/words", "std_msgs/String", queue_size=1000)
        yield master.uri, words


@pytest.mark.parametrize("number", SIGNALS, ids=lambda number: number.name)
def test_a_publisher_ends_by_a_signal(number, graph, until):
    uri, words = graph
    line = ("topic", "pub", "-r", "20", "/words", "std_msgs/String", "a")
    with unread_command("rosproto", *line, "--master", uri) as command:
        words.next(timeout=20.0)
        command.send_signal(number)
        assert command.wait(15 * crowd()) == CODES[number]
        until(lambda: words.connections == 0)


@pytest.mark.parametrize("server", ["bridge", "foxglove"])
def test_a_server_ends_in_its_time(server, graph):
    needs(server)
    words = (server, "--port", "0", "--for", "0.5", "--master", graph[0])
    with unread_command("rosproto", *words) as command:
        assert command.wait(30) == 0


@pytest.mark.parametrize("number", CODES, ids=lambda number: number.name)
def test_a_server_ends_by_a_signal(number, graph, until):
    needs("bridge")
    port = unused_port()

    def serves() -> bool:
        with socket.socket() as client:
            return client.connect_ex(("127.0.0.1", port)) == 0

    with unread_command("rosproto", "bridge", "--port", str(port), "--master", graph[0]) as command:
        until(serves, 30.0)
        command.send_signal(number)
        assert command.wait(15 * crowd()) in (0, 130)


FAILS_LATE = """
import gc, sys
from rosproto.cli import main
gc.disable()
class Late:
    def __del__(self): raise ValueError
a, b = Late(), Late()
a.itself = a  # found by the last collection
def late(): return b  # found when the interpreter takes its modules apart
if {collected}: del a
else: del a.itself
sys.exit(main())
"""


@pytest.mark.parametrize("collected", [True, False])
def test_a_command_ends_although_the_interpreter_prints_at_its_end(collected):
    """Python says of an error in a destructor that it is ignored, and waits for the reader of that sentence."""
    program = FAILS_LATE.format(collected=collected)
    with (
        full_pipe() as pipe,
        subprocess.Popen(
            [sys.executable, "-c", program, "--help"], stdout=subprocess.DEVNULL, stderr=pipe, cwd=ROOT
        ) as command,
    ):
        try:
            assert command.wait(30) == 0
        finally:
            command.kill()


def test_a_bag_is_played_to_its_end(graph, tmp_path):
    from rosproto.bag import BagWriter
    from rosproto.codec import message_class

    uri, words = graph
    text = message_class("std_msgs/String")
    with BagWriter(tmp_path / "a.bag") as bag:
        for number in range(20):
            bag.write("/words", text(data=str(number)), 1.0 + number * 0.01)
    line = ("bag", "play", str(tmp_path / "a.bag"), "--wait-for-subscribers", "--master", uri)
    with unread_command("rosproto", *line) as command:
        assert words.next(timeout=20.0).data == "0"
        assert command.wait(15 * crowd()) == 0
