"""`rosproto graph`, `tf` and `doctor` on graphs of our own."""

from __future__ import annotations

import heapq
import json
import random
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import pytest

from rosproto import Master, Node
from rosproto.cli import main
from rosproto.cli.graph import Edge, svg
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


def test_a_large_graph_has_the_shape_of_a_screen() -> None:
    """As many topics as a chassis has: cards in columns, none over another; before it was 1136 by 4154 pixels."""
    edges = [Edge(f"/node_{i % 17}", f"/topic/number_{i}", "/listener" if i % 3 else "") for i in range(120)]
    picture = ElementTree.fromstring(svg(edges))
    width, height = int(picture.get("width", 0)), int(picture.get("height", 0))
    assert 0.8 < width / height < 2.5
    boxes = [
        [int(rect.get(key, 0)) for key in ("x", "y", "width", "height")]
        for rect in picture.iter()
        if rect.tag.endswith("rect") and rect.get("rx")
    ]
    assert len(boxes) == 17
    for number, (x, y, w, h) in enumerate(boxes):
        assert x + w <= width
        assert y + h <= height
        for x2, y2, w2, h2 in boxes[number + 1 :]:
            assert x + w <= x2 or x2 + w2 <= x or y + h <= y2 or y2 + h2 <= y
    texts = {(element.text or "").strip() for element in picture.iter()}
    assert {edge.topic for edge in edges} | {edge.publisher for edge in edges} <= texts


def random_edges(seed: int, nodes: int) -> list[Edge]:
    chance = random.Random(seed)
    names = ["", *(f"/node_{n}" + "x" * chance.randrange(20) for n in range(nodes))]
    return [
        Edge(chance.choice(names), f"/t{n}" + "y" * chance.randrange(25), chance.choice(names))
        for n in range(chance.choice((1, 2, 4)) * nodes)
    ]


@pytest.mark.parametrize("seed", range(20))
def test_few_numbers_of_columns_are_tried_and_the_best_is_among_them(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Trying each number for 1,000 nodes took 7 s."""
    edges = random_edges(seed, nodes=3 + 5 * seed)
    drawn = svg(edges)
    monkeypatch.setattr("rosproto.cli.graph._NEAR", len(edges))
    assert drawn == svg(edges)
    monkeypatch.undo()
    placed, place = 0, heapq.heapreplace

    def counted(columns: list[tuple[int, int]], column: tuple[int, int]) -> tuple[int, int]:
        nonlocal placed
        placed += 1
        return place(columns, column)

    monkeypatch.setattr("heapq.heapreplace", counted)
    svg(random_edges(seed, nodes=500))
    assert placed < 25 * 500


def test_a_png_is_a_png_or_an_error(
    graph: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """By Graphviz where it is; never text under such a name."""
    file = tmp_path / "g.png"
    monkeypatch.setattr("shutil.which", lambda name: None)
    assert main(["graph", "--master", graph, "-o", str(file)]) == 1
    assert not file.exists()
    assert ".svg" in capsys.readouterr().err
    fake = tmp_path / "dot"
    fake.write_text("#!/bin/sh\ncat >/dev/null; printf '%s' \"drawn$1\"\n")
    fake.chmod(0o755)
    monkeypatch.setattr("shutil.which", lambda name: str(fake))
    if sys.platform != "win32":
        assert main(["graph", "--master", graph, "-o", str(file)]) == 0
        assert file.read_bytes() == b"drawn-Tpng"
        fake.write_text("#!/bin/sh\ncat >/dev/null; echo no >&2; exit 3\n")
        assert main(["graph", "--master", graph, "-o", str(file)]) == 1
        assert "failed with code 3: no" in capsys.readouterr().err


@pytest.mark.skipif(shutil.which("dot") is None, reason="Graphviz is not installed")
def test_graphviz_draws_our_dot(graph: str, tmp_path: Path) -> None:
    """What it reads and writes is a picture."""
    assert main(["graph", "--master", graph, "-o", str(tmp_path / "g.png")]) == 0
    assert (tmp_path / "g.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["-o", "g.bmp"], ".svg"),
        (["-o", "g"], "--format"),
        (["-o", "g.png", "--format", "text"], "omit one of them"),
        (["--format", "png"], "-o FILE.png"),
    ],
)
def test_a_name_that_says_no_form_is_refused(
    graph: str, words: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    assert main(["graph", "--master", graph, *words]) == 1
    assert said in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


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
