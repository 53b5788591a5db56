"""`rosproto tf frames` and `tf monitor`."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from xml.etree import ElementTree

import pytest

from rosproto import Master, Node
from rosproto.cli import main
from rosproto.cli.exit_codes import CommandError
from rosproto.cli.tf import Arrivals, dot_of, report, svg_of, text_of
from rosproto.codec import message_class
from rosproto.tf import StaticTransformBroadcaster, Transform

FRAMES: dict[str, dict[str, Any]] = {
    "odom": {
        "parent": "map",
        "authority": "/slam",
        "static": False,
        "earliest": 10.0,
        "latest": 12.0,
        "samples": 21,
    },
    "base": {
        "parent": "odom",
        "authority": "/base",
        "static": False,
        "earliest": 12.0,
        "latest": 12.0,
        "samples": 1,
    },
    "laser": {
        "parent": "base",
        "authority": "/urdf",
        "static": True,
        "earliest": 0.0,
        "latest": 0.0,
        "samples": 1,
    },
    "imu<1>": {
        "parent": "base",
        "authority": "",
        "static": True,
        "earliest": 0.0,
        "latest": 0.0,
        "samples": 1,
    },
}


def test_the_picture_is_a_tree_without_overlaps() -> None:
    """A box a frame, children to the right of their parents, one line a transform."""
    picture = ElementTree.fromstring(svg_of(FRAMES, 12.5))
    names = [e.text for e in picture.iter() if e.get("class") == "name"]
    assert sorted(names) == sorted(["map", *FRAMES])
    boxes = [
        [float(e.get(key, 0)) for key in ("x", "y", "width", "height")]
        for e in picture.iter()
        if e.tag.endswith("rect") and e.get("rx")
    ]
    place = dict(zip(names, boxes, strict=True))
    for child, facts in FRAMES.items():
        assert place[child][0] > place[facts["parent"]][0] + place[facts["parent"]][2]
    assert abs(place["laser"][1] - place["imu<1>"][1]) >= place["laser"][3]
    assert len([e for e in picture.iter() if e.tag.endswith("path")]) == len(FRAMES)
    texts = {e.text for e in picture.iter()}
    assert {
        "/slam, 10.0 Hz, 0.50 s old",
        "/urdf, fixed",
        "an unknown node, fixed",
        "/base, once, 0.50 s old",
    } <= texts


def test_a_loop_of_frames_is_drawn_too() -> None:
    loop = {
        child: {**FRAMES["odom"], "parent": parent} for child, parent in (("a", "b"), ("b", "c"), ("c", "a"))
    }
    ElementTree.fromstring(svg_of(loop, 12.0))
    assert dot_of(loop, 12.0).count("->") == 3


def test_text_and_dot() -> None:
    assert "odom: in map; /slam, 10.0 Hz, 0.50 s old\n" in text_of(FRAMES, 12.5)
    assert '"base" -> "laser" [label="/urdf\\nfixed"];' in dot_of(FRAMES, 12.5)


@pytest.fixture(scope="module")
def graph() -> Iterator[str]:
    with (
        Master() as master,
        Node("/a", master_uri=master.uri) as node,
        StaticTransformBroadcaster(node) as frames,
    ):
        frames.send(Transform.planar("map", "odom", 1.0, 2.0, 1.5))
        yield master.uri


def test_frames_are_written_under_the_name_that_is_given(
    graph: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    at = ("--seconds", "0.5", "--master", graph)
    assert main(["tf", "frames", *at]) == 0
    assert capsys.readouterr().out == "wrote frames.svg\n"
    ElementTree.parse(tmp_path / "frames.svg")
    assert main(["tf", "frames", "-o", "f.dot", *at]) == 0
    assert "digraph" in (tmp_path / "f.dot").read_text()
    capsys.readouterr()
    assert main(["tf", "frames", "--format", "text", *at]) == 0
    assert capsys.readouterr().out == "odom: in map; /a, fixed\n"
    assert main(["tf", "frames", "--json", *at]) == 0
    assert json.loads(capsys.readouterr().out)["odom"]["parent"] == "map"
    assert main(["tf", "frames", "-o", "f.jpg", *at]) == 1
    assert not (tmp_path / "f.jpg").exists()


def test_monitor_on_a_graph(graph: str, capsys: pytest.CaptureFixture[str]) -> None:
    at = ("--every", "0.3", "--master", graph)
    assert main(["tf", "monitor", "-n", "1", *at]) == 0
    out = capsys.readouterr().out.splitlines()
    assert out[1].split() == ["odom", "map", "/a", "fixed"]
    assert main(["tf", "monitor", "nowhere", "-n", "1", *at]) == 1
    assert "no transform of frame 'nowhere'" in capsys.readouterr().err


@pytest.fixture
def arrivals() -> Arrivals:
    """odom and base ten times in a second, 20 and 50 ms late; one fixed."""
    found = Arrivals()
    send: Callable[..., None] = lambda *frames, **how: _send(found, *frames, **how)  # noqa: E731
    for i in range(11):
        send(("map", "odom"), at=5.0 + 0.1 * i, late=0.02, sender="/slam")
        send(("odom", "base"), at=5.0 + 0.1 * i, late=0.05 if i else 0.1, sender="/base")
    send(("base", "laser"), at=5.0, late=5.0, sender="/urdf", static=True)
    return found


def _send(
    found: Arrivals, frames: tuple[str, str], *, at: float, late: float, sender: str, static: bool = False
) -> None:
    transform = message_class("geometry_msgs/TransformStamped")(child_frame_id=frames[1])
    transform.header.frame_id = frames[0]
    stamp = at - late
    transform.header.stamp.secs = math.floor(stamp)
    transform.header.stamp.nsecs = round((stamp % 1.0) * 1e9)
    message = SimpleNamespace(transforms=[transform], _connection_header={"callerid": sender})
    found.add(message, at, static=static)


def test_rates_and_delays(arrivals: Arrivals) -> None:
    base, laser, odom = arrivals.facts([])
    assert (odom["frame"], odom["sender"], odom["static"]) == ("odom", "/slam", False)
    assert odom["rate"] == pytest.approx(10.0)
    assert odom["average_delay"] == pytest.approx(0.02)
    assert base["max_delay"] == pytest.approx(0.1)
    assert laser["average_delay"] is None
    text = report([base, laser, odom])
    assert "/base: 10.00 transforms/s, at most 0.1000 s late" in text
    assert text.splitlines()[2].split() == ["laser", "base", "/urdf", "fixed"]


def test_only_the_way_between_two_frames(arrivals: Arrivals) -> None:
    assert [one["frame"] for one in arrivals.facts(["laser", "odom"])] == ["base", "laser"]
    assert [one["frame"] for one in arrivals.facts(["base"])] == ["base", "odom"]
    with pytest.raises(CommandError, match="did you mean laser"):
        arrivals.facts(["lasr"])
