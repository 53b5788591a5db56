"""`rosproto bag record` and `play` on graphs of our own, and the keyboard."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from rosproto import Master, Node
from rosproto.bag import BagReader, BagWriter, open_bag
from rosproto.cli import main
from rosproto.cli.bag_play import _Console, _split_remappings
from rosproto.cli.bag_progress import Progress
from rosproto.cli.bag_record import add_record_arguments, progress_line, recorder_options, seconds_of
from rosproto.cli.exit_codes import CommandError
from rosproto.cli.keys import WindowsKeys, open_keys
from rosproto.cli.parser import Parser
from rosproto.codec import message_class
from rosproto.node.clock import NodeClock
from rosproto.recording import RecorderStats
from rosproto.time import Time
from tests.support.waiting import until

String = message_class("std_msgs/String")


@pytest.fixture
def graph() -> Iterator[tuple[str, Node]]:
    """A node that says something 200 times a second, and has a latched topic."""
    with Master() as master, Node("/talker", master_uri=master.uri) as node:
        said = node.publisher("/said", String, queue_size=1000)
        node.publisher("/kept", String, latch=True).publish(data="kept")
        ended = threading.Event()

        def talk() -> None:
            number = 0
            while not ended.wait(0.005):
                said.publish(data=str(number))
                number += 1

        thread = threading.Thread(target=talk, daemon=True)
        thread.start()
        yield master.uri, node
        ended.set()
        thread.join(20)


def test_record_until_a_limit(
    graph: tuple[str, Node], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """So many messages of each named topic, then it ends by itself; the bag has its own name."""
    uri, _ = graph
    name = tmp_path / "run"
    assert main(["bag", "record", "--master", uri, "/said", "-l", "20", "-O", str(name), "--lz4"]) == 0
    with BagReader(tmp_path / "run.bag") as bag:
        said = [int(m.data) for _, m, _ in bag.read_messages("/said")]
        assert set(bag.compression()) == {"lz4"}
    assert said == list(range(said[0], said[0] + 20))
    assert "20 messages" in capsys.readouterr().err
    assert os.listdir(tmp_path) == ["run.bag"]


def test_record_by_pattern_for_some_time(graph: tuple[str, Node], tmp_path: Path) -> None:
    """-e and -x take whole names, -o adds the date, --duration ends it, -q says nothing."""
    uri, _ = graph
    words = ["-e", "/s.*", "/k.*", "-x", "/kep.", "-o", str(tmp_path / "run"), "--duration", "2s", "-q"]
    assert main(["bag", "record", "--master", uri, *words]) == 0
    (path,) = tmp_path.iterdir()
    assert path.name.startswith("run_20")
    with BagReader(path) as bag:
        assert list(bag.topics) == ["/said"]


def test_record_what_a_node_hears(graph: tuple[str, Node], tmp_path: Path) -> None:
    """--node takes the topics that node subscribes."""
    uri, _ = graph
    with Node("/hearer", master_uri=uri) as hearer, hearer.subscriber("/kept", String) as kept:
        kept.next(20)
        words = ["--node", "/hearer", "-O", str(tmp_path / "run.bag"), "-l", "1"]
        assert main(["bag", "record", "--master", uri, *words]) == 0
    with BagReader(tmp_path / "run.bag") as bag:
        assert list(bag.topics) == ["/kept"]


def test_recording_in_simulated_time_waits_for_the_clock(
    graph: tuple[str, Node],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Nothing is stamped with 0: recording begins with the first /clock, in its time."""
    uri, node = graph
    node.params["/use_sim_time"] = True
    ended, asked = threading.Event(), threading.Semaphore(0)
    wait_for_time = NodeClock.wait_for_time

    def counted(clock: NodeClock, timeout: float | None = 10.0) -> bool:
        asked.release()
        return wait_for_time(clock, timeout)

    monkeypatch.setattr(NodeClock, "wait_for_time", counted)

    def tick() -> None:
        seconds = 5000
        for _ in range(2):  # asked again, it has said that it waits
            asked.acquire(timeout=20)
        with node.publisher("/clock", "rosgraph_msgs/Clock") as clock:
            while not ended.wait(0.01):
                clock.publish(clock=Time(seconds, 0))
                seconds += 1

    thread = threading.Thread(target=tick, daemon=True)
    thread.start()
    try:
        words = ["/said", "/kept", "-l", "1", "-O", str(tmp_path / "run.bag")]
        assert main(["bag", "record", "--master", uri, *words]) == 0
    finally:
        ended.set()
        thread.join(20)
    assert "waiting for /clock" in capsys.readouterr().err
    with BagReader(tmp_path / "run.bag") as bag:
        assert bag.start_time is not None
        assert bag.start_time.secs >= 5000


@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals on Windows")
def test_keys_steer_a_real_player(graph: tuple[str, Node], tmp_path: Path) -> None:
    """In a terminal: space pauses, s steps, space goes on, Ctrl-C ends; the terminal is as it was."""
    import pty
    import signal
    import subprocess
    import termios

    uri, node = graph
    with BagWriter(tmp_path / "run.bag") as writer:
        for i in range(1000):
            writer.write("/x", String(data=str(i)), 10.0 + i)
    ours, theirs = pty.openpty()
    before = termios.tcgetattr(theirs)
    words = [
        sys.executable,
        "-m",
        "rosproto",
        "bag",
        "play",
        "--master",
        uri,
        "--pause",
        str(tmp_path / "run.bag"),
    ]
    with node.subscriber("/x", "std_msgs/String", queue_size=100) as heard:
        player = subprocess.Popen(
            [*words, "-r", "20", "--wait-for-subscribers"], stdin=theirs, stdout=theirs, stderr=theirs,
            env=os.environ | {"PYTHONPATH": str(Path(__file__).resolve().parents[3]), "ROS_IP": "127.0.0.1"},
        )  # fmt: skip
        try:
            seen = ""
            while "[PAUSED]" not in seen:
                seen += os.read(ours, 4096).decode()
            os.write(ours, b"s")
            assert heard.next(20).data == "0"
            os.write(ours, b"ss")
            assert [heard.next(20).data for _ in range(2)] == ["1", "2"]
            os.write(ours, b" ")
            assert [heard.next(20).data for _ in range(3)] == ["3", "4", "5"]
            player.send_signal(signal.SIGINT)
            assert player.wait(20) == 130
        finally:
            player.kill()
            player.wait()
    assert termios.tcgetattr(theirs) == before
    os.close(ours)
    os.close(theirs)


def test_options_that_contradict_each_other(capsys: pytest.CaptureFixture[str]) -> None:
    """One sentence each; and what the good ones mean."""
    parser = argparse.ArgumentParser()
    add_record_arguments(parser)
    for words in (["--split"], ["--max-splits", "3"], ["-o", "a", "-O", "b"]):
        with pytest.raises(CommandError):
            recorder_options(parser.parse_args(words))
    options = recorder_options(parser.parse_args("--split --size 1.5 --duration 2m -b 0".split()))
    assert (options["split_bytes"], options["split_seconds"]) == (1_572_864, 120.0)
    assert options["max_seconds"] is None
    assert options["buffer_bytes"] > 1 << 50, "0 is without bound"
    assert [seconds_of(text) for text in ("30", "1.5s", "2h")] == [30.0, 1.5, 7200.0]
    with pytest.raises(argparse.ArgumentTypeError):
        seconds_of("soon")
    assert main(["bag", "record", "/x", "--master", "http://127.0.0.1:1"]) == 4
    assert capsys.readouterr().err.count("\n") == 1


def test_the_progress_line_has_rate_size_and_losses() -> None:
    """What is shown while recording."""
    before = RecorderStats(0, 0, 1 << 20, 0, 2, 1.0, "x.bag")
    text = progress_line(RecorderStats(500, 3, 21 << 20, 9 << 20, 2, 3.0, "x.bag"), before)
    assert text == "3 s  500 messages  2 topics  21.0 MB  10.0 MB/s  9.0 MB wait for the disk  3 DROPPED"


def test_play(graph: tuple[str, Node], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Remapped and prefixed, to a subscriber that is waited for."""
    uri, node = graph
    with BagWriter(tmp_path / "run.bag") as writer:
        for i in range(10):
            writer.write("/x", String(data=str(i)), 10.0 + i * 0.01)
    with node.subscriber("/re/y", "std_msgs/String", queue_size=100) as heard:
        words = ["--wait-for-subscribers", "x:=y", "-p", "/re", "-r", "2"]
        assert main(["bag", "play", "--master", uri, str(tmp_path / "run.bag"), *words]) == 0
        assert [heard.next(20).data for _ in range(10)] == [str(i) for i in range(10)]
    assert "10 messages" in capsys.readouterr().err


def test_play_of_a_topic_that_the_bag_has_not_plays_the_others(
    graph: tuple[str, Node], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As rosbag play does, with a warning; of none of them there is nothing to play."""
    path = tmp_path / "some.bag"
    with BagWriter(path) as bag:
        bag.write("/a", message_class("std_msgs/String")(data="x"), 1.0)
    with graph[1].subscriber("/a", "std_msgs/String") as heard:
        play = ["bag", "play", "--master", graph[0], str(path), "-i", "--wait-for-subscribers", "--topics"]
        assert main([*play, "/nowhere", "/a"]) == 0
        assert heard.next(20).data == "x"
    assert "no messages on topic '/nowhere'; there are /a" in capsys.readouterr().err
    assert main([*play, "/nowhere"]) == 1


def test_mcap_is_recorded_and_played(graph: tuple[str, Node], tmp_path: Path) -> None:
    """What was heard is said again, by the same verbs."""
    pytest.importorskip("mcap", reason="mcap is not installed (extra mcap)")
    uri, node = graph
    path = tmp_path / "run.mcap"
    words = ["--format", "mcap", "/said", "-l", "8", "-O", str(path), "-q"]
    assert main(["bag", "record", "--master", uri, *words]) == 0
    with open_bag(path) as bag:
        said = [message.data for _, message, _ in bag]
        assert not bag.damage
    assert len(said) == 8
    with node.subscriber("/again/said", "std_msgs/String", queue_size=100) as heard:
        words = ["--wait-for-subscribers", "-p", "/again", "-q"]
        assert main(["bag", "play", "--master", uri, str(path), *words]) == 0
        assert [heard.next(20).data for _ in range(8)] == said


@pytest.mark.skipif(os.name != "posix", reason="kills by a signal")
def test_a_recorder_of_mcap_that_is_killed(graph: tuple[str, Node], tmp_path: Path) -> None:
    """SIGKILL in the middle: the file opens, and has every message of its whole chunks."""
    pytest.importorskip("mcap", reason="mcap is not installed (extra mcap)")
    path = tmp_path / "run.mcap"
    words = ["--format", "mcap", "/said", "-O", str(path), "-q", "--chunksize", "1"]
    command = [sys.executable, "-m", "rosproto", "bag", "record", "--master", graph[0], *words]
    process = subprocess.Popen(command, stderr=subprocess.DEVNULL)
    try:
        until(lambda: any(file.stat().st_size > 4000 for file in tmp_path.iterdir()), 30.0, "a recording")
        assert process.poll() is None
    finally:
        process.kill()
        process.wait(10)
    (left,) = tmp_path.iterdir()
    with open_bag(left) as bag:
        numbers = [int(message.data) for _, message, _ in bag]
        assert "was not finished" in bag.damage[0]
    assert len(numbers) > 5
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))


@pytest.mark.parametrize("words", ["-q a b -l 3", "a -q b -l 3", "-l 3 -q a b", "a -l 3 -q b"])
def test_words_may_stand_between_options(words: str) -> None:
    """As with rosbag, which takes them in any order."""
    parser = Parser()
    add_record_arguments(parser)
    found = parser.parse_args(words.split())
    assert (found.topics, found.limit, found.quiet) == (["a", "b"], 3, True)
    with pytest.raises(SystemExit):
        parser.parse_args(["a", "--no-such-option"])


def test_remappings_and_bags_in_one_row() -> None:
    """Words with := are remappings, global or not; the rest are bags."""
    assert _split_remappings(["a.bag", "/x:=/y", "z:=w"]) == (["a.bag"], {"/x": "/y", "/z": "/w"})
    with pytest.raises(ValueError, match="no bag"):
        _split_remappings(["/x:=/y"])
    with pytest.raises(CommandError, match="not a remapping"):
        _split_remappings(["a.bag", "/x:="])


class Typed:
    """Stands for a keyboard."""

    def __init__(self, typed: str) -> None:
        self._typed = list(typed)

    def read(self, timeout: float) -> list[str]:
        typed, self._typed = self._typed, []
        return typed


class Played:
    """Stands for a player."""

    def __init__(self) -> None:
        self.paused = False
        self.pause_on_topics = True
        self.steps = 0

    def pause(self) -> None:
        self.paused = True

    def resume(self) -> None:
        self.paused = False

    def step(self) -> None:
        self.steps += 1


def test_space_pauses_and_s_steps() -> None:
    """The keys of rosbag play; others do nothing."""
    player = Played()
    for typed, paused, steps in ((" ", True, 0), ("s", True, 1), ("xs", True, 2), (" ", False, 2)):
        _Console(Progress("", quiet=True), Typed(typed))(player)  # type: ignore[arg-type]
        assert (player.paused, player.steps) == (paused, steps)


def test_t_switches_the_pause_topics() -> None:
    """Off, and on again."""
    player = Played()
    for expected in (False, True):
        _Console(Progress("", quiet=True), Typed("t"))(player)  # type: ignore[arg-type]
        assert player.pause_on_topics is expected


@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals on Windows")
def test_single_keys_from_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    """Keys come without Enter; afterwards the terminal is as before."""
    import pty
    import termios

    ours, theirs = pty.openpty()
    with os.fdopen(theirs, "r", closefd=True) as stdin:
        monkeypatch.setattr(sys, "stdin", stdin)
        before = termios.tcgetattr(stdin.fileno())
        with open_keys(driving=False) as keys:
            assert keys.read(0.0) == []
            os.write(ours, b" s")
            typed: list[str] = []
            while len(typed) < 2:
                typed += keys.read(0.0)
            assert typed == [" ", "s"]
        assert termios.tcgetattr(stdin.fileno()) == before
    os.close(ours)


def test_keys_from_a_windows_console() -> None:
    """Through msvcrt, without waiting."""
    import types

    waiting = list("s ")
    console = types.SimpleNamespace(kbhit=lambda: bool(waiting), getwch=lambda: waiting.pop(0))
    keys = WindowsKeys(console)
    assert keys.read(0.0) == ["s", " "]
    assert keys.read(0.0) == []
