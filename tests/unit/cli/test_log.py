"""`rosproto log`: levels, filters, and the loggers of a node."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import pytest

from rosproto import Master, Node
from rosproto.cli import main
from rosproto.cli.log import word_of
from rosproto.codec import message_class

Log = message_class("rosgraph_msgs/Log")
Out = Callable[..., tuple[int, str, str]]


def line(level: int, text: str, name: str = "/camera") -> Any:
    made = Log(level=level, name=name, msg=text, file="eye.py", line=7, function="look")
    made.header.stamp.secs = 1000
    return made


@pytest.fixture(scope="module")
def graph() -> Iterator[SimpleNamespace]:
    """Lines that wait on /rosout_agg for whoever comes: latched, a node each."""
    lines = [
        line(1, "details"), line(2, "all is well"), line(4, "hot\nvery"), line(8, "\x1b[2Jburnt"),
        line(16, "gone", "/base"),
    ]  # fmt: skip
    with Master() as master:
        nodes = [Node(f"/speaker{i}", master_uri=master.uri) for i in range(len(lines))]
        for node, message in zip(nodes, lines, strict=True):
            node.publisher("/rosout_agg", Log, latch=True).publish(message)
        yield SimpleNamespace(uri=master.uri, nodes=nodes)
        for node in nodes:
            node.close()


@pytest.fixture
def log(graph: SimpleNamespace, capsys: pytest.CaptureFixture[str]) -> Out:
    def call(*words: str) -> tuple[int, str, str]:
        code = main(["log", *words, "--master", graph.uri])
        return code, *capsys.readouterr()

    return call


def test_levels_have_words() -> None:
    assert [word_of(n) for n in (0, 1, 2, 3, 4, 8, 16, 20)] == [
        "debug", "debug", "info", "info", "warn", "error", "fatal", "fatal",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("words", "texts"),
    [
        ((), {"details", "all is well", "hot\nvery", "\x1b[2Jburnt", "gone"}),
        (("-l", "warn"), {"hot\nvery", "\x1b[2Jburnt", "gone"}),
        (("--node", "/base"), {"gone"}),
        (("--node", "cam*", "--level", "ERROR"), {"\x1b[2Jburnt"}),
        (("--match", "^(hot|all)"), {"all is well", "hot\nvery"}),
        (("--exclude", "o|e", "--level", "info"), {"\x1b[2Jburnt"}),
    ],
)
def test_lines_are_chosen(log: Out, words: tuple[str, ...], texts: set[str]) -> None:
    code, out, _ = log("echo", *words, "-n", str(len(texts)), "--json")
    assert code == 0
    assert {json.loads(one)["text"] for one in out.splitlines()} == texts


def test_a_line_says_when_how_bad_who_and_what(log: Out) -> None:
    """Several lines of one message stay together, and a node cannot write escapes into the terminal."""
    _, out, _ = log("echo", "-n", "1", "--match", "hot", "--source")
    head, more = out.splitlines()
    assert head.split(" ", 1)[1] == "WARN  /camera: hot"
    assert more.strip().startswith("very  [eye.py:7 look]")
    _, out, _ = log("echo", "-n", "1", "--match", "burnt")
    assert "\x1b" not in out
    assert "\\x1b[2Jburnt" in out


def test_silence_ends_where_a_time_is_given(log: Out) -> None:
    code, _, err = log("echo", "--match", "never said", "--timeout", "0.3")
    assert code == 1
    assert "no matching line within 0.3 s" in err
    assert log("echo", "--node", "/nobody", "--timeout", "0.1")[2].startswith(
        "WARNING: no node is called /nobody"
    )


@pytest.mark.parametrize("words", [("echo", "-l", "loud"), ("echo", "--match", "(")])
def test_what_is_no_filter_is_wrong_use(log: Out, words: tuple[str, ...]) -> None:
    with pytest.raises(SystemExit) as caught:
        log(*words)
    assert caught.value.code == 2


def test_levels_of_a_node_are_listed_and_set(log: Out) -> None:
    code, out, _ = log("list", "/speaker0", "--json")
    loggers = json.loads(out)
    assert code == 0
    assert "root" in loggers
    assert log("set", "speaker0", "root", "debug")[:2] == (0, "root: debug\n")
    assert log("get", "/speaker0", "root")[:2] == (0, "debug\n")
    assert log("set", "speaker0", "root", loggers["root"])[0] == 0
    assert "did you mean /speaker0" in log("list", "/speaker_0")[2]
    code, _, err = log("set", "/speaker0", "rot", "info")
    assert (code, "see: rosproto log list /speaker0" in err) == (1, True)


def test_without_an_aggregator_rosout_itself_is_read(capsys: pytest.CaptureFixture[str]) -> None:
    with Master() as master, Node("/talker", master_uri=master.uri) as node:
        publisher = node.publisher("/rosout", Log)
        words = ["log", "echo", "-n", "1", "--match", "hello", "--timeout", "60", "--master", master.uri]
        with node.clock.timer(0.02, lambda _: publisher.publish(line(2, "hello", "/talker"))):
            assert main(words) == 0
    assert "INFO  /talker: hello" in capsys.readouterr().out
