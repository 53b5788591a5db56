"""`rosproto bag`: info, check, echo, filter, merge, compress, reindex, fix."""

from __future__ import annotations

import io
import json
import os
from collections.abc import Callable
from pathlib import Path

import pytest

from rosproto.bag import BagReader, BagWriter
from rosproto.cli import main
from rosproto.cli.bag_progress import Progress
from rosproto.codec import message_class
from rosproto.text import human_bytes

String = message_class("std_msgs/String")
Twist = message_class("geometry_msgs/Twist")
Run = Callable[..., tuple[int, str]]


@pytest.fixture
def bag(tmp_path: Path) -> str:
    """Ten seconds of two topics; /cmd falls silent in the second half, /said has two publishers."""
    path = tmp_path / "run.bag"
    with BagWriter(path, "lz4", 2000) as writer:
        for i in range(100):
            header = {"callerid": f"/node{i % 2}", "latching": "0"}
            writer.write("/said", String(data=str(i)), 1000.0 + i / 10, header=header)
            if i < 50:
                twist = Twist()
                twist.linear.x = float(i)
                writer.write("/cmd", twist, 1000.0 + i / 10)
    return str(path)


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    """Run `rosproto bag ...`; exit code, and what it printed on both streams."""

    def run(*words: object) -> tuple[int, str]:
        code = main(["bag", *map(str, words)])
        found = capsys.readouterr()
        return code, found.out + found.err

    return run


def contents(path: object, topic: str = "/said") -> list[str]:
    with BagReader(str(path)) as bag:
        assert bag.damage == []
        return [m.data for _, m, _ in bag.read_messages(topic)]


def test_info_tells_counts_and_draws_rates(run: Run, bag: str) -> None:
    """Rosbag's lines, and behind each topic when it was busy."""
    code, out = run("info", bag)
    assert code == 0
    said = next(line for line in out.splitlines() if "/said" in line)
    cmd = next(line for line in out.splitlines() if "/cmd" in line)
    assert "100 msgs" in said
    assert "(2 connections)" in said
    assert cmd.rstrip()[-1] == "▁", "silent at the end"
    assert said.rstrip()[-1] > "▄", "busy at the end"
    assert len(cmd.rstrip()) == len(said.rstrip()), "the curves stand below each other"
    assert "▁" not in run("info", "--plain", bag)[1]


def test_curves_of_a_bag_with_many_chunks_need_no_index_records(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The chunks' counts give the same curve as the times of the messages, to a chunk."""
    path = tmp_path / "many.bag"
    with BagWriter(path, chunk_bytes=1) as writer:
        for i in range(2400):
            if not 1000 <= i < 1400:
                writer.write("/said", String(data=str(i)), 1000.0 + i / 10)
            if i % 3 == 0:
                writer.write("/rare", String(), 1000.0 + i / 10)
    with monkeypatch.context() as patched:
        patched.setattr(BagReader, "times", None)
        fast = json.loads(run("info", "--json", path)[1])["curves"]
    monkeypatch.setattr("rosproto.cli.bag_info.FINE", 10**12)
    with BagWriter(path, append=True) as writer:  # a chunk of some length, or each is of one moment
        writer.write("/said", String(), 1239.9)
        writer.write("/said", String(), 1239.901)
        writer.flush()
    slow = json.loads(run("info", "--json", path)[1])["curves"]
    for topic, tolerance in (("/said", 2), ("/rare", 2)):
        assert sum(fast[topic]) == sum(slow[topic]) - (2 if topic == "/said" else 0)
        assert all(abs(a - b) <= tolerance for a, b in zip(fast[topic], slow[topic], strict=True))
    assert fast["/said"][11] == 0


def test_info_of_several_bags_as_json_is_a_line_for_each(run: Run, bag: str) -> None:
    """JSON Lines, as jq and others read them; YAML has its own sign between documents."""
    code, out = run("info", "--json", bag, bag)
    assert code == 0
    assert [json.loads(line)["path"] for line in out.splitlines()] == [bag, bag]
    assert run("info", "--yaml", bag, bag)[1].count("\n---\n") == 1


def test_play_wants_a_bag(run: Run) -> None:
    """A missing argument is wrong use, as with the other verbs."""
    code, out = run("play")
    assert code == 2
    assert "name one" in out


def test_info_as_json_and_yaml(run: Run, bag: str) -> None:
    """Facts for programs, one value with --key."""
    found = json.loads(run("info", "--json", "--freq", bag)[1])
    assert found["messages"] == 150
    assert found["topics"][1]["frequency"] == pytest.approx(10.0, rel=1e-3)
    assert sum(found["curves"]["/cmd"]) == 50
    assert run("info", "-y", "-k", "messages", bag)[1] == "150\n"
    assert run("info", "-y", "-k", "nothing", bag)[0] == 1
    assert "--yaml" in run("info", "-k", "messages", bag)[1]


def test_info_aligns_the_connections_behind_the_longest_type(run: Run, tmp_path: Path) -> None:
    """Of all types, also of one that is the second of its topic, as rosbag does."""
    path = tmp_path / "two.bag"
    with BagWriter(path) as bag:
        bag.write("/a", message_class("std_msgs/String")(), 1.0)
        bag.write("/a", message_class("geometry_msgs/PointStamped")(), 2.0)
    assert (
        "/a   2 msgs    : std_msgs/String            (2 connections)" in run("info", str(path), "--plain")[1]
    )


def test_info_of_an_empty_bag(run: Run, tmp_path: Path) -> None:
    """No messages: no span, no error."""
    BagWriter(tmp_path / "empty.bag").close()
    code, out = run("info", tmp_path / "empty.bag")
    assert code == 0
    assert "size:" in out
    assert run("check", tmp_path / "empty.bag")[0] == 0


def test_check_finds_damage_and_what_cannot_be_decoded(run: Run, bag: str, tmp_path: Path) -> None:
    """A sound bag is 0; a cut one and one whose bytes do not fit the definition are 1, with the reason."""
    assert run("check", bag) == (0, f"{bag}: sound, 150 messages\n")
    cut = tmp_path / "cut.bag"
    cut.write_bytes(Path(bag).read_bytes()[:-3000])
    code, out = run("check", cut)
    assert code == 1
    assert "NOT sound" in out
    wrong = tmp_path / "wrong.bag"
    with BagReader(bag) as good, BagWriter(wrong) as writer:
        for _, message, stamp in good.read_messages("/said", raw=True):
            writer.write_raw(message.connection, b"\xff\xff\xff\x7f", stamp)
    code, out = run("check", wrong)
    assert code == 1
    assert "cannot be decoded" in out


def test_check_notes_another_revision(run: Run, tmp_path: Path) -> None:
    """A type recorded with another definition is not damage, but told."""
    path = tmp_path / "old.bag"
    from rosproto.codec import define

    old = define("geometry_msgs/Twist", "float64 x\nfloat64 yaw\n")
    with BagWriter(path) as writer:
        writer.write("/cmd", old(), 1.0)
    code, out = run("check", path)
    assert code == 0
    assert "another revision" in out


def test_filter_by_topic_span_and_expression(run: Run, bag: str, tmp_path: Path) -> None:
    """What is kept is kept byte for byte, with its publisher."""
    out = tmp_path / "out.bag"
    code, text = run("filter", bag, out, "topic == '/said' and int(m.data) % 10 == 0 and t.secs < 1005")
    assert (code, text) == (0, f"{out}: 5 of 150 messages\n")
    assert contents(out) == ["0", "10", "20", "30", "40"]
    assert run("filter", bag, tmp_path / "b.bag", "--topics", "/s*", "-s", 2, "-u", 1, "--lz4")[0] == 0
    assert contents(tmp_path / "b.bag") == [str(i) for i in range(20, 31)]
    with BagReader(tmp_path / "b.bag") as found:
        assert {c.callerid for c in found.connections.values()} == {"/node0", "/node1"}


def test_filter_prints_what_it_looks_at(run: Run, bag: str, tmp_path: Path) -> None:
    """-p as in rosbag filter, with an expression or without one."""
    words = ("--topics", "/said", "-u", "0.25", "-p", "(t.secs, m.data)")
    _, text = run("filter", bag, tmp_path / "a.bag", "m.data == '1'", *words)
    assert text.splitlines()[:3] == [
        "NO MATCH (1000, '0')",
        "MATCH (1000, '1')",
        "NO MATCH (1000, '2')",
    ]
    _, text = run("filter", bag, tmp_path / "b.bag", *words)
    assert text.count("MATCH (1000") == 3
    assert contents(tmp_path / "b.bag") == ["0", "1", "2"]


def test_filter_refuses_what_would_destroy_or_run_code(run: Run, bag: str, tmp_path: Path) -> None:
    """The input as output, an existing output, an unknown topic, and code."""
    assert "is the input" in run("filter", bag, bag, "True")[1]
    (tmp_path / "there.bag").write_text("precious")
    assert "already exists" in run("filter", bag, tmp_path / "there.bag")[1]
    assert "no such topic" in run("filter", bag, tmp_path / "x.bag", "--topics", "/nowhere")[1]
    code, out = run("filter", bag, tmp_path / "x.bag", "__import__('os').system('true')")
    assert code == 2
    assert "filter" in out
    assert (tmp_path / "there.bag").read_text() == "precious"


def test_merge_is_by_time(run: Run, bag: str, tmp_path: Path) -> None:
    """Two halves give the whole again, in order, whichever comes first."""
    run("filter", bag, tmp_path / "a.bag", "-u", 4.95)
    run("filter", bag, tmp_path / "b.bag", "-s", 4.96)
    assert run("merge", tmp_path / "all.bag", tmp_path / "b.bag", tmp_path / "a.bag")[0] == 0
    assert contents(tmp_path / "all.bag") == [str(i) for i in range(100)]


@pytest.mark.parametrize(("option", "kind"), [("--lz4", "lz4"), ("--bz2", "bz2")])
def test_compress_and_decompress_keep_the_original(run: Run, bag: str, option: str, kind: str) -> None:
    """In place, the original beside it; a second original is not overwritten unasked."""
    before = Path(bag).read_bytes()
    assert run("decompress", bag)[0] == 0
    orig = Path(bag).with_suffix(".orig.bag")
    assert orig.read_bytes() == before
    with BagReader(bag) as found:
        assert set(found.compression()) == {"none"}
    code, out = run("compress", option, bag)
    assert code == 1
    assert "--force" in out
    assert run("compress", option, "-f", "-q", bag) == (0, "")
    with BagReader(bag) as found:
        assert set(found.compression()) == {kind}
    assert contents(bag) == [str(i) for i in range(100)]


def test_compress_into_a_directory_leaves_the_bag_alone(run: Run, bag: str, tmp_path: Path) -> None:
    """--output-dir, which is made, and a failure leaves nothing behind."""
    before = Path(bag).read_bytes()
    assert run("compress", "--output-dir", tmp_path / "out", bag)[0] == 0
    assert Path(bag).read_bytes() == before
    assert contents(tmp_path / "out" / "run.bag") == [str(i) for i in range(100)]
    broken = tmp_path / "broken.bag"
    broken.write_bytes(b"no bag at all")
    assert run("compress", broken)[0] == 1
    assert sorted(os.listdir(tmp_path)) == ["broken.bag", "out", "run.bag"]


def test_reindex_mends_what_a_dead_recorder_left(run: Run, bag: str, tmp_path: Path) -> None:
    """An .active file gets its index and its name; a sound bag is left as it is."""
    active = tmp_path / "dead.bag.active"
    with BagReader(bag) as found:
        cut = found.chunks[-1].pos
    active.write_bytes(Path(bag).read_bytes()[: cut + 50])
    code, out = run("reindex", active)
    assert code == 0
    assert "has an index now" in out
    said = contents(tmp_path / "dead.bag")
    assert 0 < len(said) < 100
    before = Path(bag).read_bytes()
    assert "nothing was changed" in run("reindex", bag)[1]
    assert Path(bag).read_bytes() == before


def test_reindex_can_mend_a_copy(run: Run, bag: str, tmp_path: Path) -> None:
    """With --output-dir the damaged bag stays as it is; what is there is replaced only with -f."""
    data = Path(bag).read_bytes()[:-50]
    (tmp_path / "cut.bag").write_bytes(data)
    (tmp_path / "out").mkdir()
    assert run("reindex", "-q", "--output-dir", tmp_path / "out", tmp_path / "cut.bag") == (0, "")
    assert contents(tmp_path / "out" / "cut.bag") == [str(i) for i in range(100)]
    assert (tmp_path / "cut.bag").read_bytes() == data
    again = ("reindex", "--output-dir", tmp_path / "out", tmp_path / "cut.bag")
    assert "already exists" in run(*again)[1]
    assert run(*again, "-f")[0] == 0
    assert "is the input" in run("reindex", "--output-dir", tmp_path, tmp_path / "cut.bag")[1]
    assert "cannot be copied" in run("reindex", "--output-dir", tmp_path / "no", tmp_path / "cut.bag")[1]
    (tmp_path / "out" / "dead.bag").write_text("old")
    (tmp_path / "dead.bag.active").write_bytes(data)
    assert (
        "already exists" in run("reindex", "--output-dir", tmp_path / "out", tmp_path / "dead.bag.active")[1]
    )
    assert run("reindex", "-f", "--output-dir", tmp_path / "out", tmp_path / "dead.bag.active")[0] == 0
    assert len(contents(tmp_path / "out" / "dead.bag")) == 100


def test_fix_saves_what_is_whole(run: Run, bag: str, tmp_path: Path) -> None:
    """Damage in the middle costs its chunk; the rest is in the new bag."""
    with BagReader(bag) as found:
        middle = found.chunks[len(found.chunks) // 2].pos
    data = bytearray(Path(bag).read_bytes())
    data[middle + 100 : middle + 140] = bytes(40)
    (tmp_path / "bad.bag").write_bytes(bytes(data))
    code, out = run("fix", tmp_path / "bad.bag", tmp_path / "good.bag")
    assert code == 0
    assert "damaged" in out
    assert 50 < len(contents(tmp_path / "good.bag")) < 100


def test_echo(run: Run, bag: str) -> None:
    """Text, CSV and JSON of a topic; a field with a path."""
    assert run("echo", bag, "/said", "-n", 1) == (0, 'data: "0"\n---\n')
    assert run("echo", bag, "/cmd/linear/x", "-n", 2) == (0, "0.0\n---\n1.0\n---\n")
    assert run("echo", bag, "/said", "-n", 1, "--json") == (0, '{"data": "0"}\n')
    assert "no topic" in run("echo", bag, "/nowhere")[1]


def test_errors_are_one_sentence(run: Run, tmp_path: Path) -> None:
    """Files that are not there, or no bags."""
    assert run("info", tmp_path / "none.bag")[0] == 1
    (tmp_path / "text.bag").write_text("hello, this is text")
    code, out = run("info", tmp_path / "text.bag")
    assert code == 1
    assert out.count("\n") == 1
    assert "not a bag" in out


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_progress_is_silent_when_short_or_not_on_a_terminal() -> None:
    """The line has share, rate and time left; it is taken away at the end."""
    stream = Terminal()
    with Progress("reading", 200, stream=stream) as progress:
        progress.step(100)
        assert progress.text(2.0) == "reading: 50 % (50/s, 2 s left)"
        assert stream.getvalue() == ""
        progress.show("reading: 50 %")
    assert stream.getvalue().endswith("\r")
    plain = io.StringIO()
    Progress("reading", stream=plain).show("anything")
    assert plain.getvalue() == ""
    few = Progress("reading", 3, stream=plain)
    assert few.text(1.0) == "reading: 1 s"
    few.step()
    assert few.text(1.0) == "reading: 33 % (1/s, 2 s left)"
    assert [human_bytes(n) for n in (512, 1 << 20, 5 << 30)] == ["0.5 KB", "1.0 MB", "5.0 GB"]
