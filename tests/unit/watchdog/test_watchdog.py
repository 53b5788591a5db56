"""The watchdog process of a program that is killed, stopped, forked, or closed."""

from __future__ import annotations

import json
import logging
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from rosproto.codec import encode, message_class
from rosproto.master import Master
from rosproto.node import Node, NodeClient
from rosproto.protocol.handshake import encode_header, subscriber_header
from rosproto.watchdog import LastMessage, Watchdog, WatchedNode
from rosproto.watchdog.protocol import ROUNDS, SILENCE_SECONDS, Prepare, watchdog_name
from rosproto.watchdog.watchdog import MAX_LOOKS_WITHOUT_REPORT, Watch
from tests.support import attacks
from tests.support.load import crowd

ROOT = Path(__file__).resolve().parents[3]
TWIST = message_class("geometry_msgs/Twist")
SIGNALS = pytest.mark.skipif(os.name != "posix", reason="needs SIGKILL and SIGSTOP")
PROMISED = 0.5
LOAD = 1.5  # seconds more that a computer with other work may take


class Robot:
    """Hears /cmd_vel, and how fast it is told to drive."""

    def __init__(self) -> None:
        self.master = Master(host="127.0.0.1", port=0)
        self.node = Node("/robot", master_uri=self.master.uri, rosout=False)
        self.heard: list[tuple[float, float]] = []
        self.node.subscriber("/cmd_vel", TWIST, self._on, queue_size=100)

    def _on(self, message: Any) -> None:
        self.heard.append((time.monotonic(), message.linear.x))

    @property
    def speed(self) -> float | None:
        return self.heard[-1][1] if self.heard else None

    @property
    def zeros(self) -> int:
        return sum(speed == 0.0 for _, speed in self.heard)

    def close(self) -> None:
        self.node.close()
        self.master.close()


class Program:
    """`tests.support.watched_program`, in a process."""

    def __init__(self, master_uri: str) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", "tests.support.watched_program", master_uri],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            cwd=ROOT,
        )
        self.watchdog = self.said()["watchdog"]

    def said(self) -> dict[str, Any]:
        assert self.process.stdout is not None
        line: dict[str, Any] = json.loads(self.process.stdout.readline())
        return line

    def ask(self, word: str) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(f"{word}\n".encode())
        self.process.stdin.flush()

    def close(self) -> None:
        self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout):
            assert pipe is not None
            pipe.close()


def until(condition: Callable[[], object], seconds: float = 20.0) -> float:
    """How long it took until it held."""
    began = time.monotonic()
    while not condition():
        assert time.monotonic() - began < seconds, "it did not happen"
        time.sleep(0.005)
    return time.monotonic() - began


def alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


@pytest.fixture
def robot() -> Iterator[Robot]:
    made = Robot()
    yield made
    made.close()


@pytest.fixture
def program(robot: Robot) -> Iterator[Program]:
    made = Program(robot.master.uri)
    until(lambda: robot.speed == 0.3)
    yield made
    made.close()


@SIGNALS
def test_a_killed_program_is_followed_by_zero_and_by_the_end_of_its_watchdog(
    robot: Robot, program: Program
) -> None:
    program.process.kill()
    assert until(lambda: robot.speed == 0.0) < PROMISED + LOAD
    until(lambda: not alive(program.watchdog))
    until(lambda: robot.zeros == 5)
    assert "_rosproto_watchdog" not in str(robot.node.master.get_system_state()), "it has left the graph"


@pytest.mark.promise("and are delivered also when it is killed then")
@SIGNALS
def test_what_a_killed_watchdog_has_sent_is_still_delivered(robot: Robot, program: Program) -> None:
    """A reset would discard what is on its way, as it does for a velocity; the connection ends without one."""
    name = watchdog_name("/program")
    with NodeClient(robot.node.master.lookup_node(name), "/late") as slave:
        _, host, port = slave.request_topic("/cmd_vel", [["TCPROS"]])
    header = subscriber_header(
        topic="/cmd_vel", type_name=TWIST._type, md5sum=TWIST._md5sum, callerid="/late"
    )
    with attacks.connect((str(host), int(str(port))), encode_header(header)) as sock:
        attacks.read_header(sock)
        program.process.kill()
        until(lambda: robot.zeros >= ROUNDS - 1)
        os.kill(program.watchdog, signal.SIGKILL)
        until(lambda: not alive(program.watchdog))
        for _ in range(ROUNDS - 1):
            assert attacks.read_frame(sock)
        while sock.recv(4096):
            pass


@SIGNALS
def test_a_stopped_program_is_followed_by_zero_and_told_when_it_goes_on(
    robot: Robot, program: Program
) -> None:
    os.kill(program.process.pid, signal.SIGSTOP)
    took = until(lambda: robot.speed == 0.0)
    assert SILENCE_SECONDS - 0.2 < took < SILENCE_SECONDS + LOAD * crowd()
    os.kill(program.process.pid, signal.SIGCONT)
    until(lambda: robot.speed == 0.3)
    program.process.kill()
    until(lambda: robot.speed == 0.0)


@SIGNALS
def test_a_killed_watchdog_is_started_again_and_watches_on(robot: Robot, program: Program) -> None:
    os.kill(program.watchdog, signal.SIGKILL)
    again = program.said()["watchdog"]
    assert again != program.watchdog
    program.process.kill()
    assert until(lambda: robot.speed == 0.0) < PROMISED + LOAD
    until(lambda: not alive(again))


@pytest.mark.promise("It sends only the messages it received before the motion")
@SIGNALS
def test_what_stands_is_not_sent_a_zero(robot: Robot, program: Program) -> None:
    program.ask("standing")
    until(lambda: robot.zeros >= 4)  # the program has run on, so the watchdog has been told
    program.process.kill()
    program.process.wait()
    before = len(robot.heard)
    until(lambda: not alive(program.watchdog))
    assert len(robot.heard) <= before + 1, "one message of the program itself may have been on its way"


@SIGNALS
def test_a_forked_child_that_holds_the_pipe_does_not_hide_the_end(robot: Robot, program: Program) -> None:
    program.ask("fork")
    child = program.said()["forked"]
    program.process.kill()
    assert until(lambda: robot.speed == 0.0) < PROMISED + LOAD
    until(lambda: not alive(program.watchdog))
    os.kill(child, signal.SIGKILL)


@pytest.mark.promise("It sends only the messages it received before the motion")
@SIGNALS
def test_an_orderly_end_takes_the_watchdog_along_and_sends_nothing(robot: Robot, program: Program) -> None:
    program.ask("close")
    assert program.process.wait(10) == 0
    assert not alive(program.watchdog)
    assert {speed for _, speed in robot.heard} == {0.3}


@SIGNALS
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT"])
def test_signals_that_end_programs_do_not_end_it_before_its_parent(
    robot: Robot, program: Program, name: str
) -> None:
    os.kill(program.watchdog, getattr(signal, name))
    program.process.kill()
    assert until(lambda: robot.speed == 0.0) < PROMISED + LOAD


@SIGNALS
def test_it_has_no_terminal_and_is_in_no_group_of_its_parent() -> None:
    with Watchdog() as watchdog:
        assert watchdog.pid is not None
        assert os.getpgid(watchdog.pid) != os.getpgid(0)
        assert os.getsid(watchdog.pid) != os.getsid(0)


@pytest.mark.promise("It sends only the messages it received before the motion")
@SIGNALS
def test_one_that_was_never_needed_ends_with_its_program() -> None:
    with Watchdog() as watchdog:
        pid = watchdog.pid
        assert pid is not None
        assert alive(pid)
    assert not alive(pid)


def test_where_it_cannot_be_started_one_warning_says_so(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(sys, "frozen", True, raising=False)
    with caplog.at_level(logging.WARNING), Watchdog() as watchdog:
        for _ in range(3):
            watch = watchdog.watch(WatchedNode("http://127.0.0.1:1", "/x"))
            assert not watch.ready
            watch.arm()
            watch.drop()
    assert [record.levelname for record in caplog.records] == ["WARNING"]
    assert "there is no watchdog" in caplog.text


@pytest.mark.skipif(os.name != "posix", reason="needs /bin/echo")
def test_an_interpreter_that_is_another_program_is_given_up(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """`sys.executable` of an embedded Python may be anything: it ends, or says what is not a line."""
    monkeypatch.setattr("rosproto.watchdog.watchdog.MAX_RESTARTS", 0)
    monkeypatch.setattr(sys, "executable", "/bin/echo")
    with caplog.at_level(logging.WARNING), Watchdog() as watchdog:
        watch = watchdog.watch(WatchedNode("http://127.0.0.1:1", "/x"))
        assert not watch.ready
    assert caplog.text.count("there is no watchdog") == 1


def test_a_master_that_is_away_is_told_once_and_nothing_waits_for_ever(
    caplog: pytest.LogCaptureFixture,
) -> None:
    with caplog.at_level(logging.WARNING), Watchdog() as watchdog:
        for _ in range(2):
            assert not watchdog.watch(WatchedNode("http://127.0.0.1:1", "/x")).ready
    assert caplog.text.count("the watchdog is not ready") == 1
    assert "ready again" not in caplog.text


def zero() -> LastMessage:
    return LastMessage("/cmd_vel", TWIST._type, TWIST._full_text, encode(TWIST()))


@pytest.mark.promise("another node takes the name of the watchdog")
def test_a_watchdog_that_is_no_longer_ready_is_told_and_so_is_the_end_of_that(
    robot: Robot, caplog: pytest.LogCaptureFixture
) -> None:
    program = "/some_program"
    with caplog.at_level(logging.WARNING, "rosproto.watchdog"), Watchdog() as watchdog:
        watch = watchdog.watch(WatchedNode(robot.master.uri, program), messages=[zero()])
        assert watch.ready
        with Node(watchdog_name(program), master_uri=robot.master.uri, rosout=False) as taker:
            taker.publisher("/anything", TWIST)
            until(lambda: "the watchdog is no longer ready" in caplog.text)
            until(lambda: "the watchdog is ready again" in caplog.text)
            assert watch.ready
            names = robot.node.master.get_system_state().publishers["/cmd_vel"]
        assert names == [watchdog_name(program, 1)]


@SIGNALS
@pytest.mark.slow
def test_a_watchdog_that_does_not_report_is_told(robot: Robot, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING, "rosproto.watchdog"), Watchdog() as watchdog:
        watch = watchdog.watch(WatchedNode(robot.master.uri, "/some_program"), messages=[zero()])
        assert watchdog.pid is not None
        os.kill(watchdog.pid, signal.SIGSTOP)
        try:
            until(lambda: "it has not reported for" in caplog.text)
            assert not watch.ready
        finally:
            os.kill(watchdog.pid, signal.SIGCONT)
        until(lambda: "the watchdog is ready again" in caplog.text)


def test_no_thread_stays_behind() -> None:
    before = {thread.name for thread in threading.enumerate()}
    with Watchdog():
        assert any("watchdog" in thread.name for thread in threading.enumerate())
    assert not {t.name for t in threading.enumerate() if "rosproto:watchdog" in t.name} - before


def test_a_pause_of_the_program_is_not_a_silence_of_its_watchdog(monkeypatch: pytest.MonkeyPatch) -> None:
    """What the watchdog reported meanwhile is unread; only a watchdog that goes on without a report is silent."""
    watch = Watch(Watchdog(), Prepare(1, WatchedNode("http://127.0.0.1:1", "/program"), armed=True))
    watch.answered("")
    hours = time.monotonic() + 7200.0
    monkeypatch.setattr(time, "monotonic", lambda: hours)
    assert [watch.look() for _ in range(MAX_LOOKS_WITHOUT_REPORT)] == [False] * MAX_LOOKS_WITHOUT_REPORT
    watch.answered("")
    looks = [watch.look() for _ in range(MAX_LOOKS_WITHOUT_REPORT + 1)]
    assert looks == [False] * MAX_LOOKS_WITHOUT_REPORT + [True]
    watch.disarm()
    assert not watch.look()
