"""`rosproto graph`, `tf` and `doctor` on graphs of our own."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import pytest

from rosproto import Master, Node
from rosproto.cli import main
from rosproto.tf import StaticTransformBroadcaster, Transform


@pytest.fixture(scope="module")
def graph() -> Iterator[str]:
    """Two nodes, one topic between them, one heard by nobody, one published by nobody, three frames."""
    with (
        Master() as master,
        Node("/a", master_uri=master.uri) as a,
        Node("/b", master_uri=master.uri) as b,
        StaticTransformBroadcaster(a) as frames,
    ):
        a.publisher("/cmd", "geometry_msgs/Twist")
        b.subscriber("/cmd", "geometry_msgs/Twist")
        a.publisher("/unheard", "std_msgs/String")
        b.subscriber("/unsaid", "std_msgs/String")
        frames.send(
            Transform.planar("map", "odom", 1.0, 2.0, 1.5),
            Transform.planar("odom", "base_link", 0.5, 0.0, 0.0),
        )
        yield master.uri


def test_text(graph: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Publishers with their topics and who hears them."""
    assert main(["graph", "--master", graph, "--node", "/a"]) == 0
    assert capsys.readouterr().out.startswith("/a\n  /cmd -> /b\n")


def test_dot_and_svg(graph: str, tmp_path: Path) -> None:
    """The file's name says the form; the SVG is well-formed and shows every name."""
    dot, svg = tmp_path / "g.dot", tmp_path / "g.svg"
    assert main(["graph", "--master", graph, "-o", str(dot)]) == 0
    assert '"/a" -> "/b" [label="/cmd"];' in dot.read_text()
    assert '"topic /unsaid" -> "/b";' in dot.read_text()
    assert main(["graph", "--master", graph, "-o", str(svg)]) == 0
    texts = {element.text for element in ElementTree.parse(svg).iter() if element.tag.endswith("text")}
    assert {"/a", "/b", "/cmd", "/unheard", "/unsaid"} <= texts


def test_graph_json(graph: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Edges with their types."""
    main(["graph", "--master", graph, "--json"])
    edges = json.loads(capsys.readouterr().out)
    assert {"publisher": "/a", "topic": "/cmd", "subscriber": "/b", "type": "geometry_msgs/Twist"} in edges


def test_tf_tree(graph: str, capsys: pytest.CaptureFixture[str]) -> None:
    """The frames, indented below their parents."""
    assert main(["tf", "tree", "--seconds", "0.5", "--master", graph]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.lstrip("└─ ").split()[0] for line in lines] == ["map", "odom", "base_link"]


def test_tf_echo(graph: str, capsys: pytest.CaptureFixture[str]) -> None:
    """The pose of one frame in another, as text and as JSON."""
    assert main(["tf", "echo", "map", "odom", "-n", "1", "--master", graph]) == 0
    assert "Translation: [1.000, 2.000, 0.000]" in capsys.readouterr().out
    main(["tf", "echo", "odom", "base_link", "-n", "1", "--json", "--master", graph])
    assert json.loads(capsys.readouterr().out)["translation"] == [0.5, 0.0, 0.0]


def test_tf_echo_of_an_unknown_frame(graph: str, capsys: pytest.CaptureFixture[str]) -> None:
    """It gives up in its time and names the frame."""
    assert main(["tf", "echo", "map", "nowhere", "--timeout", "0.3", "--master", graph]) == 1
    assert "nowhere" in capsys.readouterr().err


def test_doctor_of_a_healthy_graph(graph: str, capsys: pytest.CaptureFixture[str]) -> None:
    """All is well, and a topic without a publisher is worth a note."""
    assert main(["doctor", "--master", graph]) == 0
    out = capsys.readouterr().out
    assert "PROBLEM" not in out
    assert "/unsaid" in out


def test_doctor_finds_the_dead_and_the_absent(capsys: pytest.CaptureFixture[str]) -> None:
    """A node that died, a node with an unknown host name, a master that is not there: each with advice."""
    with Master() as master, Node("/a", master_uri=master.uri) as node:
        node.master.call("registerPublisher", "/t", "std_msgs/String", "http://127.0.0.1:9/")
        assert main(["doctor", "--master", master.uri]) == 1
        assert "cleanup" in capsys.readouterr().out
    assert main(["doctor", "--json", "--master", "http://127.0.0.1:9"]) == 1
    findings = json.loads(capsys.readouterr().out)
    assert findings[-1]["check"] == "master"
    assert findings[-1]["ok"] is False
    assert findings[-1]["advice"]
    assert main(["doctor", "--master", "http://no.such.host.invalid:11311"]) == 1
    assert "PROBLEM route" in capsys.readouterr().out
