"""A bag behind the standard library's HTTP: what is fetched, and what becomes of servers that lie."""

from __future__ import annotations

import re
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

from rosproto.bag import BagReader, BagWriter, partitions
from rosproto.codec import message_class
from rosproto.errors import BagError

pytest.importorskip("pyarrow", reason="pyarrow is not installed (extra arrow)")
pytest.importorskip("fsspec", reason="fsspec is not installed (extra remote)")
pytest.importorskip("aiohttp", reason="aiohttp, which fsspec needs for http, is not installed")

Image = message_class("sensor_msgs/Image")
String = message_class("std_msgs/String")


@contextmanager
def served(data: bytes, lie: str = "") -> Iterator[tuple[str, list[int]]]:
    """A URL, and the bytes of each answer.

    `lie`: "short" gives half of every range; "whole" announces ranges, and gives everything; "none" knows none; "fail"
    answers 500 from the third request on; "larger" and "smaller" tell a size that the file has not.
    """
    sent: list[int] = []
    told = {"larger": len(data) + 5000, "smaller": len(data) - 5000}.get(lie, len(data))

    class Handler(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def do_HEAD(self) -> None:
            self.answer(200, b"", told)

        def do_GET(self) -> None:
            asked = re.fullmatch(r"bytes=(\d+)-(\d+)", self.headers.get("Range", ""))
            if lie == "fail" and len(sent) > 2:
                self.answer(500, b"", 0)
            elif asked is None or lie in ("whole", "none"):
                self.answer(200, data, len(data))
            else:
                first, last = int(asked[1]), min(int(asked[2]), len(data) - 1)
                if lie == "short" and last - first > 1:
                    last = (first + last) // 2
                body = data[first : last + 1]
                self.answer(206, body, len(body), f"bytes {first}-{last}/{told}")

        def answer(self, status: int, body: bytes, length: int, part: str = "") -> None:
            self.send_response(status)
            self.send_header("Content-Length", str(length))
            if lie != "none":
                self.send_header("Accept-Ranges", "bytes")
            if part:
                self.send_header("Content-Range", part)
            self.end_headers()
            try:
                self.wfile.write(body)
            except OSError:
                pass  # the client has seen enough
            sent.append(len(body))

        def log_message(self, *_: object) -> None:
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    thread = threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_address[1]}/run.bag", sent
    finally:
        server.shutdown()
        server.server_close()
        thread.join(5)


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
    with pytest.raises(BagError, match=r"woosh-pure\[remote\]"):
        partitions("https://127.0.0.1:1/a.bag")
