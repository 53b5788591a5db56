"""What peers call their frames, nodes and parameters acts neither on a terminal nor in a picture."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from rosproto import Master, Node
from rosproto.cli import main
from rosproto.codec import message_class
from tests.support.hostile_peer import RAW, HostilePeer, wrongs_of

FORMS = ("text", "dot", "svg")


@pytest.fixture(scope="module")
def uri() -> Iterator[str]:
    """A node that sends hostile frames, and one parameter that says what it likes."""
    with Master() as master, Node("/evil", master_uri=master.uri) as node:
        moving = message_class("geometry_msgs/TransformStamped")(child_frame_id=RAW)
        moving.header.frame_id = "map" + RAW
        moving.transform.rotation.w = 1.0
        node.publisher("/tf", "tf2_msgs/TFMessage", latch=True).publish(transforms=[moving])
        one = message_class("dynamic_reconfigure/ParamDescription")(name=RAW, type="str", description=RAW)
        group = message_class("dynamic_reconfigure/Group")(name=RAW, parameters=[one])
        described: Any = message_class("dynamic_reconfigure/ConfigDescription")(groups=[group])
        node.publisher("/evil/parameter_descriptions", described._type, latch=True).publish(described)
        yield master.uri


def is_harmless(form: str, text: str) -> bool:
    """Nothing in it is obeyed or forged, and a picture can be read."""
    assert wrongs_of(text) == []
    if form == "svg":
        words = "".join(ElementTree.fromstring(text).itertext())
        assert "FORGED by a peer" in words
    return "FORGED by a peer" in text


@pytest.mark.parametrize("form", FORMS)
def test_frames(form: str, uri: str, tmp_path: Path) -> None:
    file = tmp_path / "frames"
    words = ["--seconds", "0.6", "--format", form, "-o", str(file)]
    assert main(["tf", "frames", *words, "--master", uri]) == 0
    assert is_harmless(form, file.read_text("utf-8"))


def test_the_monitor_of_frames(uri: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["tf", "monitor", "-n", "1", "--every", "0.3", "--master", uri]) == 0
    assert is_harmless("text", capsys.readouterr().out)


def test_dynparam(uri: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["dynparam", "describe", "/evil", "--master", uri]) == 0
    assert is_harmless("text", capsys.readouterr().out)


@pytest.mark.parametrize("form", FORMS)
def test_the_graph(form: str, tmp_path: Path) -> None:
    file = tmp_path / "graph"
    with HostilePeer() as peer:
        assert main(["graph", "--all", "--format", form, "-o", str(file), "--master", peer.uri]) == 0
    assert is_harmless(form, file.read_text("utf-8"))
