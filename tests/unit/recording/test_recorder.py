"""`Recorder`: limits that end it, several definitions, headers, errors."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from rosproto import Master, Node
from rosproto.bag import BagReader, create_bag
from rosproto.bag.output import BagOutputFile
from rosproto.codec import AnyMsg, define, message_class
from rosproto.errors import BagError, MasterError
from rosproto.node.clock import NodeClock
from rosproto.recording import Recorder, TopicSelection
from rosproto.recording.buffer import Entry, TopicReceiver, _connection

String = message_class("std_msgs/String")
ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture
def nodes() -> Iterator[tuple[Node, Node, Node]]:
    with (
        Master() as master,
        Node("/one", master_uri=master.uri) as one,
        Node("/two", master_uri=master.uri) as two,
        Node("/recorder", master_uri=master.uri) as three,
    ):
        yield one, two, three


def test_publishers_that_disagree_are_both_recorded(nodes: tuple[Node, Node, Node], tmp_path: Path) -> None:
    """One topic, two definitions: each message is stored with its own publisher's."""
    one, two, recorder_node = nodes
    other = define("my_msgs/Other", "int32 x\nstring name\n")
    strings, others = one.publisher("/a", String), two.publisher("/a", other)
    with Recorder(recorder_node, tmp_path / "a.bag", ["/a"], limit=2) as recorder:
        strings.wait_for_connection(20)
        others.wait_for_connection(20)
        strings.publish(data="text")
        others.publish(other(x=7, name="seven"))
        assert recorder.wait(20)
    with BagReader(tmp_path / "a.bag") as bag:
        found = {c.callerid: (c.type, c.md5sum) for c in bag.connections.values()}
        messages = sorted((getattr(m, "data", None) or m.name) for _, m, _ in bag.read_messages())
    assert found == {"/one": ("std_msgs/String", String._md5sum), "/two": ("my_msgs/Other", other._md5sum)}
    assert messages == ["seven", "text"]


def test_datagrams_are_recorded(tmp_path: Path) -> None:
    """`unreliable`, as `rosbag record --udp`: the same bag."""
    with (
        Master() as master,
        Node("/one", master_uri=master.uri, intraprocess=False) as one,
        Node("/recorder", master_uri=master.uri, intraprocess=False) as node,
    ):
        publisher = one.publisher("/a", String)
        with Recorder(node, tmp_path / "a.bag", ["/a"], limit=1, unreliable=True) as recorder:
            publisher.wait_for_connection(20)
            (link,) = publisher.stats()
            publisher.publish(data="text")
            assert recorder.wait(20)
    assert link.transport == "UDPROS"
    with BagReader(tmp_path / "a.bag") as bag:
        (connection,) = bag.connections.values()
        assert (connection.callerid, connection.md5sum) == ("/one", String._md5sum)
        assert [m.data for _, m, _ in bag.read_messages()] == ["text"]


def test_it_ends_by_size_and_by_time(nodes: tuple[Node, Node, Node], tmp_path: Path) -> None:
    """`wait` tells; the file is finished then, without close."""
    one, _, node = nodes
    publisher = one.publisher("/a", String, queue_size=1000)
    with (
        Recorder(node, tmp_path / "size.bag", ["/a"], max_bytes=20_000) as by_size,
        Recorder(node, tmp_path / "time.bag", ["/a"], max_seconds=0.2) as by_time,
    ):
        publisher.wait_for_connection(20)
        assert by_time.wait(20)
        assert (tmp_path / "time.bag").exists()
        assert not by_size.wait(0)
        while not by_size.finished:
            publisher.publish(data="x" * 1000)
            by_size.wait(0.001)
        assert (tmp_path / "size.bag").exists()
        assert by_size.paths == [tmp_path / "size.bag"]
    assert 20_000 <= (tmp_path / "size.bag").stat().st_size < 200_000


def test_topics_of_the_recording_process_itself(nodes: tuple[Node, Node, Node], tmp_path: Path) -> None:
    """A program can record what it publishes itself, with `all` and with topics that come later."""
    _, _, node = nodes
    selection = TopicSelection(all=True, exclude=["/rosout.*"])
    with Recorder(node, tmp_path / "a.bag", selection=selection, poll=0.05, limit=1) as recorder:
        assert recorder.topics == []
        latched = node.publisher("/own", String, latch=True)
        latched.publish(data="mine")
        assert recorder.wait(20)
    with BagReader(tmp_path / "a.bag") as bag:
        assert [(t, m.data) for t, m, _ in bag.read_messages()] == [("/own", "mine")]


def test_stats_tell_how_it_stands(nodes: tuple[Node, Node, Node], tmp_path: Path) -> None:
    """Messages, bytes, topics, and the final name of the file."""
    one, _, node = nodes
    publisher = one.publisher("/a", String)
    with Recorder(node, prefix=str(tmp_path / "run"), topics=["/a", "/nobody"]) as recorder:
        recorder.wait_for_topics(1)
        publisher.wait_for_connection(20)
        publisher.publish(data="x")
        while recorder.stats().messages < 1:
            recorder.wait(0.01)
        stats = recorder.stats()
        assert (stats.messages, stats.dropped, stats.topics) == (1, 0, 2)
        assert os.path.exists(stats.path + ".active")
        with pytest.raises(TimeoutError, match="fewer than 2"):
            recorder.wait_for_topics(2, timeout=0.05)
    assert os.path.exists(stats.path)
    assert not [t for t in threading.enumerate() if t.name.startswith("rosproto:record")]


def test_a_publisher_without_definition_gets_ours_if_it_is_the_same() -> None:
    """A bag must say how to read it; but only by a definition that has the md5sum."""
    header = {"type": "std_msgs/String", "md5sum": String._md5sum, "callerid": "/c", "latching": "1"}
    made = _connection("/a", header)
    assert made.definition == String._full_text
    assert (made.callerid, made.latching) == ("/c", True)
    assert _connection("/a", header | {"md5sum": "0" * 32}).definition == ""
    assert _connection("/a", header | {"type": "no_msgs/Such"}).definition == ""


@pytest.mark.promise("records messages of further publishers under a header with the same layout")
@pytest.mark.parametrize("bound", ["number", "characters"])
def test_headers_of_publishers_are_bounded(
    bound: str, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """One that says another header with every connection fills neither memory nor bag: what is read alike goes to
    a connection that is there, the rest is left out and told of once.
    """
    if bound == "number":
        monkeypatch.setattr("rosproto.recording.buffer.MAX_CONNECTIONS", 20)
    else:
        monkeypatch.setattr("rosproto.recording.buffer.MAX_CONNECTION_CHARACTERS", 2000)
    taken: list[Entry] = []
    tap = TopicReceiver("/a", SimpleNamespace(clock=NodeClock()), SimpleNamespace(put=taken.append))  # type: ignore[arg-type]

    def send(**header: str) -> None:
        message = AnyMsg()
        message._buff = b""
        message._connection_header = {"type": "std_msgs/String", "md5sum": String._md5sum, **header}
        tap(message)

    for i in range(200):
        send(callerid=f"/c{i}")
    assert len(taken) == 200
    assert len({id(entry.message.connection) for entry in taken}) == len(tap._known) <= 30
    for i in range(200):
        send(callerid=f"/d{i}", md5sum=f"{i:032x}")
        send(callerid=f"/d{i}", latching="1")
    assert len(taken) == 200
    assert len([one for one in caplog.records if "different headers" in one.message]) == 1


def test_a_file_that_is_there_is_not_replaced(nodes: tuple[Node, Node, Node], tmp_path: Path) -> None:
    """Unless asked; the error comes before anything is subscribed."""
    (tmp_path / "a.bag").write_text("precious")
    with pytest.raises(BagError, match="already exists"):
        Recorder(nodes[2], tmp_path / "a.bag", ["/a"])
    assert (tmp_path / "a.bag").read_text() == "precious"
    Recorder(nodes[2], tmp_path / "a.bag", ["/a"], overwrite=True).close()
    with BagReader(tmp_path / "a.bag") as bag:
        assert bag.message_count == 0
    with pytest.raises(BagError, match="cannot open"):
        Recorder(nodes[2], tmp_path / "nowhere" / "a.bag", ["/a"])


FULL = """
import resource, sys
resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))  # the disk ends here
from rosproto.cli import main
sys.exit(main(["bag", "record", "/a", "-O", sys.argv[1], "--master", sys.argv[2], "--chunksize", "16"]))
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no limit for file sizes on Windows")
def test_a_full_disk_ends_the_command_with_one_sentence(
    nodes: tuple[Node, Node, Node], tmp_path: Path
) -> None:
    """A real error of the operating system: exit code 1, and every whole chunk can be read."""
    one, _, _ = nodes
    publisher = one.publisher("/a", String, queue_size=1000)
    path = tmp_path / "run.bag"
    process = subprocess.Popen(
        [sys.executable, "-c", FULL, str(path), one.master_uri],
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": str(ROOT), "ROS_IP": "127.0.0.1"},
    )
    try:
        publisher.wait_for_connection(30)
        number = 0
        while process.poll() is None:
            publisher.publish(data=f"{number:01000}")
            number += 1
            threading.Event().wait(0.001)
            assert number < 30_000
        said = process.communicate(timeout=10)[1]
    finally:
        process.kill()
        process.wait()
    assert process.returncode == 1, said
    assert "cannot write: File too large" in said
    assert "readable up to byte" in said
    assert "Traceback" not in said
    (left,) = tmp_path.iterdir()
    with BagReader(left) as bag:
        numbers = [int(m.data) for _, m, _ in bag.read_messages()]
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    assert len(numbers) > 100


def test_writing_that_fails_is_raised_once(
    nodes: tuple[Node, Node, Node], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By `wait`, and then not again by `close`; `error` keeps it."""
    one, _, node = nodes
    publisher = one.publisher("/a", String)
    recorder = Recorder(node, tmp_path / "a.bag", ["/a"], chunk_bytes=1)
    publisher.wait_for_connection(20)

    def full(self: BagOutputFile, pieces: object, at: int) -> int:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(BagOutputFile, "put", full)
    publisher.publish(data="x")
    with pytest.raises(BagError, match="No space left"):
        recorder.wait(20)
    recorder.close()
    assert isinstance(recorder.error, BagError)


def test_the_error_names_the_bag_that_is_left(
    nodes: tuple[Node, Node, Node], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """There was no room for a chunk, but for the table of contents: the bag is finished and has its name."""
    one, _, node = nodes
    publisher = one.publisher("/a", String)
    recorder = Recorder(node, tmp_path / "a.bag", ["/a"], chunk_bytes=1)
    publisher.wait_for_connection(20)
    put = BagOutputFile.put

    def full(self: BagOutputFile, pieces: Sequence[bytes], at: int) -> int:
        monkeypatch.setattr(BagOutputFile, "put", put)
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(BagOutputFile, "put", full)
    publisher.publish(data="x")
    with pytest.raises(BagError, match=r"a\.bag: cannot write: No space left") as caught:
        recorder.wait(20)
    recorder.close()
    assert caught.value.path is not None
    with BagReader(caught.value.path) as bag:
        assert (bag.damage, bag.message_count) == ([], 0)


def test_the_name_of_each_bag_is_told(nodes: tuple[Node, Node, Node], tmp_path: Path) -> None:
    """As rosbag record -p: latched, on /begin_write."""
    one, two, node = nodes
    publisher = one.publisher("/a", String)
    with (
        two.subscriber("/begin_write", String, queue_size=10) as told,
        Recorder(node, tmp_path / "a", ["/a"], split_bytes=5000, chunk_bytes=1, announce=True) as recorder,
    ):
        publisher.wait_for_connection(20)
        assert told.next(20).data == str(tmp_path / "a_0.bag")
        for _ in range(3):
            publisher.publish(data="x" * 3000)
        assert told.next(20).data == str(tmp_path / "a_1.bag")
    assert [path.name for path in recorder.paths][:2] == ["a_0.bag", "a_1.bag"]


def test_a_disk_with_too_little_room_ends_it_before_it_is_full(
    nodes: tuple[Node, Node, Node], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The bag is closed and whole; the error says how much is left."""
    one, _, node = nodes
    publisher = one.publisher("/a", String)
    monkeypatch.setattr("rosproto.recording.recorder.LOOK_EVERY", 0.0)
    room = shutil.disk_usage(tmp_path)
    monkeypatch.setattr(shutil, "disk_usage", lambda folder: room._replace(free=90 << 20))
    recorder = Recorder(node, tmp_path / "a.bag", ["/a"], min_free_bytes=100 << 20)
    publisher.wait_for_connection(20)
    publisher.publish(data="x")
    with pytest.raises(BagError, match="90 MB are left on the disk, less than the 100"):
        recorder.wait(20)
    recorder.close()
    with BagReader(tmp_path / "a.bag") as bag:
        assert bag.damage == []
        assert bag.indexed


@pytest.mark.skipif(os.name == "nt", reason="os.kill ends the process there")
def test_ctrl_c_while_it_subscribes_leaves_nothing_behind(
    nodes: tuple[Node, Node, Node], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The interrupt ends the wait for the subscriptions, not one of them: all are taken back."""
    one, _, recorder_node = nodes
    with one.batch():
        for number in range(40):
            one.publisher(f"/topic_{number}", String)
    subscribe, interrupted = recorder_node.subscriber, threading.Event()

    def interrupted_at_the_third(topic: str, *given: Any, **options: Any) -> Any:
        if topic == "/topic_3":
            os.kill(os.getpid(), signal.SIGINT)
            assert interrupted.wait(20.0)
        return subscribe(topic, *given, **options)

    close = Recorder.close

    def noted(recorder: Recorder) -> None:
        interrupted.set()
        close(recorder)

    monkeypatch.setattr(recorder_node, "subscriber", interrupted_at_the_third)
    monkeypatch.setattr(Recorder, "close", noted)
    with pytest.raises(KeyboardInterrupt):
        Recorder(recorder_node, tmp_path / "a.bag", [f"/topic_{number}" for number in range(40)])
    assert not any("/recorder" in names for names in one.master.get_system_state().subscribers.values())
    assert not any(path.suffix == ".active" for path in tmp_path.iterdir())


@pytest.mark.skipif(os.name == "nt", reason="os.kill ends the process there")
def test_ctrl_c_while_it_opens_the_bag_leaves_no_unfinished_one(
    nodes: tuple[Node, Node, Node], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The bag is made in the thread that sees to its end: the interrupt comes when the file is there."""
    _, _, recorder_node = nodes

    def interrupted(*given: Any, **options: Any) -> Any:
        writer = create_bag(*given, **options)
        os.kill(os.getpid(), signal.SIGINT)
        return writer

    monkeypatch.setattr("rosproto.recording.files.create_bag", interrupted)
    with pytest.raises(KeyboardInterrupt):
        Recorder(recorder_node, tmp_path / "a.bag", ["/topic"])
    assert [path.name for path in tmp_path.iterdir()] == ["a.bag"]
    with BagReader(tmp_path / "a.bag") as bag:
        assert bag.damage == []
        assert bag.indexed
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("rosproto:record")]


def test_a_topic_that_the_master_refuses_ends_the_recording_at_its_start(
    nodes: tuple[Node, Node, Node], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The error of the thread that subscribes is raised to the caller."""

    def refuses(*given: Any, **options: Any) -> Any:
        raise MasterError("registerSubscriber", 0, "no more topics")

    monkeypatch.setattr(nodes[2], "subscriber", refuses)
    with pytest.raises(MasterError, match="no more topics"):
        Recorder(nodes[2], tmp_path / "a.bag", ["/a"])
