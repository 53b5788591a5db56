"""What peers call their frames, nodes and parameters acts neither on a terminal nor in a picture."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from rosproto import BagWriter, Master, Node
from rosproto.bag.records import Connection
from rosproto.cli import main
from rosproto.codec import message_class
from rosproto.time import Time
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


def hostile_connections(path: Path) -> str:
    """A bag whose connections are called what they like: topic, type, md5sum, definition and header."""
    number = 0
    with BagWriter(path) as bag:
        for names in itertools.product(
            ("/t", RAW),
            ("std_msgs/String", RAW),
            ("992ce8a1687cec8c8bd883ec73ca41d1", RAW),
            ("string data\n", RAW),
        ):
            number += 1
            connection = Connection(-1, *names, {"callerid": RAW, "type": RAW, "md5sum": RAW})
            bag.write_raw(connection, b"\x03\0\0\0a\nb", Time(number, 0))
    return str(path)


@pytest.mark.promise("cannot control a terminal or forge a line")
@pytest.mark.parametrize(
    "line",
    [
        "info", "info --yaml", "info --json", "info --freq", "info --plain", "check", "echo BAG /t", "echo BAG /t --json",
        "echo BAG /t -p", "echo --all BAG *", "reindex", "fix BAG OUT", "filter BAG OUT m.nothing", "merge OUT BAG BAG",
        "compress", "export BAG csv", "export BAG npz", "export BAG mcap", "export BAG png",
    ],
)  # fmt: skip
def test_connections_of_a_bag(line: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Also those whose messages cannot be read; what it says of them is one line each."""
    files = {"BAG": hostile_connections(tmp_path / "evil.bag"), "OUT": str(tmp_path / "out.bag")}
    words = [files.get(word, word) for word in line.split()]
    main(["bag", *words, *([] if files["BAG"] in words else [files["BAG"]])])
    out, err = capfd.readouterr()
    assert "usage:" not in err
    assert wrongs_of(out) == []
    assert wrongs_of(err) == []
