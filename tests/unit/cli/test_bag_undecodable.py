"""One topic without a usable definition stops no command; what needs its fields goes on without it."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

import rosproto
from rosproto.bag import BagReader, BagWriter, Connection
from rosproto.cli import main
from rosproto.codec import message_class
from tests.support.waiting import until

String, Int32 = message_class("std_msgs/String"), message_class("std_msgs/Int32")
DEFINITIONS = {
    "empty": "",
    "protobuf": 'syntax = "proto3";\nmessage Odd { int32 a = 1; }\n',
    "incomplete": "int32 a\nno_such/Type b\n",
    "damaged": "int32 a\n\udcff\udcfe ### garbage\n",
}
MD5SUM = "a" * 32


@pytest.fixture(params=DEFINITIONS)
def bag(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """Three texts on /good, and three messages on /odd that nobody can decode."""
    path = tmp_path / "run.bag"
    odd = Connection(0, "/odd", "my_pkg/Odd", MD5SUM, DEFINITIONS[request.param])
    with BagWriter(path) as writer:
        for i in range(3):
            writer.write("/good", String(data=f"s{i}"), 100.0 + i)
            writer.write_raw(odd, b"\x01\x02", 100.0 + i)
    return str(path)


def test_export_goes_on_without_it(bag: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The exit code tells it, unless --allow-damaged or --exclude is given; the sentence names a command."""
    for form in ("csv", "npz"):
        out = tmp_path / form
        assert main(["bag", "export", bag, form, "-o", str(out)]) == 1
        said = capsys.readouterr().err
        assert "left out: /odd: the bag has no usable definition of my_pkg/Odd" in said
        assert "rosproto bag filter --exclude /odd" in said
        assert "raw=" not in said
        assert [path.name for path in out.iterdir()] == [f"good.{form}"]
    assert len((tmp_path / "csv" / "good.csv").read_text().splitlines()) == 4
    for n, words in enumerate((["--allow-damaged"], ["--exclude", "/odd"])):
        assert main(["bag", "export", bag, "csv", "-o", str(tmp_path / str(n)), *words]) == 0


def test_filter_copies_it_unless_the_expression_asks_for_its_fields(
    bag: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """An expression about the topic or the time decides as for other topics, and the bytes stay the same."""
    new = str(tmp_path / "new.bag")
    assert main(["bag", "filter", bag, new, "topic == '/odd' or m.data == 's1'"]) == 0
    with BagReader(new) as written:
        assert [(topic, m.data, m.md5sum) for topic, m, _ in written.read_messages("/odd", raw=True)] == (
            [("/odd", b"\x01\x02", MD5SUM)] * 3
        )
        assert [m.data for _, m, _ in written.read_messages("/good")] == ["s1"]
    capsys.readouterr()
    assert main(["bag", "filter", bag, str(tmp_path / "fields.bag"), "m.data != 's1'"]) == 1
    assert capsys.readouterr().err.count("left out: /odd") == 1
    with BagReader(tmp_path / "fields.bag") as written:
        assert [m.data for _, m, _ in written.read_messages()] == ["s0", "s2"]
    words = ["bag", "filter", bag, str(tmp_path / "three.bag"), "m.data != 's1'", "--exclude", "/odd"]
    assert main(words) == 0


def test_echo_goes_on_without_it(bag: str, capsys: pytest.CaptureFixture[str]) -> None:
    """All the other topics are printed."""
    assert main(["bag", "echo", bag, "/*"]) == 1
    printed = capsys.readouterr()
    assert printed.out.count("data:") == 3
    assert "left out: /odd" in printed.err


def test_check_does_not_contradict_itself(bag: str, capsys: pytest.CaptureFixture[str]) -> None:
    """A definition that is not usable is not said to be used."""
    assert main(["bag", "check", bag, "--json"]) == 1
    (report,) = map(json.loads, capsys.readouterr().out.splitlines())
    assert len(report["problems"]) == 1
    assert not report["notes"]


@pytest.fixture
def master(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """For what publishes."""
    with rosproto.Master(port=0) as running:
        monkeypatch.setenv("ROS_MASTER_URI", running.uri)
        yield running.uri


def test_play_publishes_it_as_it_is(bag: str, master: str) -> None:
    """Bytes, type, md5sum and definition are those of the bag, as by rosbag play."""
    found: list[tuple[bytes, dict[str, str]]] = []

    def take(message: rosproto.AnyMsg) -> None:
        found.append((message._buff, dict(message._connection_header or {})))

    with rosproto.Node("/watcher", master_uri=master) as node, node.subscriber("/odd", None, take, raw=True):
        words = ["bag", "play", bag, "-r", "10", "-q", "--topics", "/odd", "--wait-for-subscribers"]
        assert main(words) == 0
        until(lambda: len(found) == 3)
    assert [data for data, _ in found] == [b"\x01\x02"] * 3
    assert (found[0][1]["type"], found[0][1]["md5sum"]) == ("my_pkg/Odd", MD5SUM)


def test_play_of_two_types_on_one_topic_leaves_the_second_out(
    tmp_path: Path, master: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """A node publishes a topic with one type; the other messages are reported, and the rest is played."""
    path = str(tmp_path / "two.bag")
    with BagWriter(path) as writer:
        for i in range(3):
            writer.write("/x", String(data="a"), 100.0 + i / 10)
            writer.write("/x", Int32(data=7), 100.0 + i / 10)
            writer.write("/y", Int32(data=8), 100.0 + i / 10)
    assert main(["bag", "play", path, "-i", "-d", "0"]) == 1
    said = capsys.readouterr().err
    assert said.count("left out: /x was recorded with different definitions") == 1
    assert "6 messages" in said
