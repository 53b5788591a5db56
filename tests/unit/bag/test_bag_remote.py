"""A bag behind the standard library's HTTP: what is fetched, and what becomes of servers that lie."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosproto.bag import BagReader, BagWriter, partitions
from rosproto.codec import message_class
from rosproto.errors import BagError
from tests.support.served_bag import served

pytest.importorskip("pyarrow", reason="pyarrow is not installed (extra arrow)")
pytest.importorskip("fsspec", reason="fsspec is not installed (extra remote)")
pytest.importorskip("aiohttp", reason="aiohttp, which fsspec needs for http, is not installed")

Image = message_class("sensor_msgs/Image")
String = message_class("std_msgs/String")


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """8 MB: pictures all the time, and a topic that speaks in a few chunks only."""
    path = tmp_path_factory.mktemp("remote") / "run.bag"
    with BagWriter(path) as writer:
        for i in range(80):
            writer.write("/image", Image(height=1, width=100_000, data=bytes(100_000)), float(i + 1))
            if i % 30 == 0:
                writer.write("/said", String(data=f"text {i}"), i + 1.5)
    return path


def test_only_the_chunks_it_needs(bag: Path) -> None:
    """Less than twice the bytes of the topic's chunks, the index included."""
    with served(bag.read_bytes()) as (url, sent):
        pieces = partitions(url, "/said")
        found = [text for piece in pieces for text in piece.table()["data"].to_pylist()]
        fetched = sum(sent)
    assert found == ["text 0", "text 30", "text 60"]
    needed = sum(piece.size for piece in pieces)
    assert fetched < 2 * needed < len(bag.read_bytes())


def test_the_same_as_from_the_disk(bag: Path) -> None:
    """All topics."""
    with served(bag.read_bytes()) as (url, _), BagReader(bag) as local:
        for piece in partitions(url, size=1 << 30):
            assert piece.table().equals(local.to_arrow(piece.topic).read_all())


@pytest.mark.promise("A server with wrong range answers causes an error")
@pytest.mark.parametrize(
    ("lie", "says"),
    [
        ("short", "bytes where|fails"),
        ("whole", "fails|bytes"),
        ("none", "no ranges|cannot"),
        ("fail", "fails|cannot"),
        ("larger", "fails|bytes where"),
    ],
)
def test_servers_that_lie(bag: Path, lie: str, says: str) -> None:
    """A sentence with the URL; never messages that are not in the bag."""
    with served(bag.read_bytes(), lie) as (url, _), pytest.raises(BagError, match=says) as caught:
        _ = [piece.table() for piece in partitions(url, "/image")]
    assert url in str(caught.value)


def test_a_size_that_is_too_small_is_a_bag_without_its_end(bag: Path) -> None:
    """As a file that was cut off there: what is whole is read, and not more than once."""
    with served(bag.read_bytes(), "smaller") as (url, _):
        found = [text for piece in partitions(url, "/said") for text in piece.table()["data"].to_pylist()]
    assert found == ["text 0", "text 30", "text 60"]


def test_nobody_there() -> None:
    """The place is named."""
    with served(b"") as (url, _):
        pass
    with pytest.raises(BagError, match="cannot be opened"):
        partitions(url)


def test_without_fsspec(monkeypatch: pytest.MonkeyPatch) -> None:
    """The error names the extra."""
    import sys

    monkeypatch.setitem(sys.modules, "fsspec", None)
    with pytest.raises(BagError, match=r"\.\[remote\]"):
        partitions("https://127.0.0.1:1/a.bag")


@pytest.mark.parametrize(
    ("lie", "says"),
    [
        ("absent", "it cannot be opened: the server answers 404 Not Found"),
        ("closed", "it cannot be opened: the server answers 403 Forbidden; it wants credentials"),
        ("whole", "its server gives no ranges of it, and a bag is read by position; download it first"),
        ("fail", "the server answers 500 Internal Server Error"),
    ],
)
def test_what_the_server_says_is_told(bag: Path, lie: str, says: str) -> None:
    """Not fsspec's words, for which everything is a file that is not found; and the URL once."""
    with served(bag.read_bytes(), lie) as (url, _), pytest.raises(BagError) as caught:
        _ = [piece.table() for piece in partitions(url, "/image")]
    assert says in str(caught.value)
    assert str(caught.value).count(url) == 1


def test_nobody_listens() -> None:
    """The system's reason."""
    with served(b"") as (url, _):
        pass
    with pytest.raises(BagError, match="it cannot be opened: Connection refused"):
        partitions(url)


def test_a_page_in_place_of_the_bag() -> None:
    """As a login answers."""
    with (
        served(b"<!DOCTYPE html><title>Log in</title>") as (url, _),
        pytest.raises(BagError, match="a web page"),
    ):
        partitions(url)


def test_a_server_that_fails_is_no_damage(bag: Path) -> None:
    """Nothing is skipped because the network fails: neither a chunk, nor what a scan has not come to yet."""
    data = bag.read_bytes()
    with served(data, "fail") as (url, _), pytest.raises(BagError, match="500"):
        _ = [piece.table() for piece in partitions(url, "/image", damaged="skip")]
    with served(data[: len(data) * 3 // 4], "fail") as (url, _), pytest.raises(BagError, match="500"):
        partitions(url, "/image", damaged="skip")


def test_a_reader_is_of_use_again_when_the_network_is(bag: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What failed is read when it is asked for again."""
    from rosproto.bag import open_bag, remote

    def fail(*_: object) -> bytes:
        raise ConnectionResetError(104, "Connection reset")

    with served(bag.read_bytes()) as (url, _), open_bag(url) as reader:
        with monkeypatch.context() as patch:
            patch.setattr(remote._RangeFile, "_fetch", fail)
            with pytest.raises(BagError, match="Connection reset"):
                next(reader.read_messages("/said"))
        found = [message.data for _, message, _ in reader.read_messages("/said")]
    assert found == ["text 0", "text 30", "text 60"]
