"""Chunks on their way to the file and from it: compressed and read by several threads, in order all the same."""

from __future__ import annotations

import errno
import gc
import io
import platform
import subprocess
import sys
import sysconfig
import threading

import numpy as np
import pytest

from rosproto.bag import BagReader, BagWriter, output
from rosproto.bag import time_order as ahead
from rosproto.codec import message_class
from rosproto.errors import BagError
from rosproto.time import Time
from tests.support.waiting import until

UInt8MultiArray = message_class("std_msgs/UInt8MultiArray")
PACKED = ["bz2", "lz4"]


@pytest.fixture(params=[1, 3], ids=["one helper", "three helpers"])
def helpers(request, monkeypatch):
    """Whatever the machine has."""
    monkeypatch.setattr(output, "worker_count", lambda: request.param)
    monkeypatch.setattr(ahead, "worker_count", lambda: request.param)
    return request.param


def blocks(count: int, size: int = 100_000) -> list[UInt8MultiArray]:
    """Messages that differ, some of them easy to compress."""
    rng = np.random.default_rng(count)
    return [UInt8MultiArray(data=rng.integers(0, 4 if i % 3 else 256, size, np.uint8)) for i in range(count)]


def write(file, messages, compression: str, chunk_bytes: int = 150_000) -> BagWriter:
    writer = BagWriter(file, compression, chunk_bytes)
    for i, message in enumerate(messages):
        writer.write("/blocks", message, Time(i, 0))
    return writer


def indices(bag: BagReader) -> list[int]:
    return [stamp.secs for _, _, stamp in bag.read_messages()]


@pytest.mark.parametrize("compression", PACKED)
def test_chunks_are_in_the_order_they_were_written(helpers, compression):
    """And every message is what it was."""
    file = io.BytesIO()
    messages = blocks(30)
    write(file, messages, compression).close()
    with BagReader(file) as bag:
        assert bag.damage == []
        assert [chunk.pos for chunk in bag.chunks] == sorted(chunk.pos for chunk in bag.chunks)
        assert len(bag.chunks) == 15
        found = [(stamp.secs, message.data.tobytes()) for _, message, stamp in bag.read_messages()]
    assert found == [(i, message.data.tobytes()) for i, message in enumerate(messages)]


@pytest.mark.parametrize("compression", PACKED)
def test_the_same_bytes_whatever_the_number_of_helpers(monkeypatch, compression):
    files = []
    for count in (1, 2, 3):
        monkeypatch.setattr(output, "worker_count", lambda count=count: count)
        file = io.BytesIO()
        write(file, blocks(12), compression).close()
        files.append(file.getvalue())
    assert files[0] == files[1] == files[2]


def test_flush_waits_for_what_is_on_its_way(helpers, tmp_path):
    path = tmp_path / "a.bag"
    writer = write(path, blocks(9), "lz4")
    writer.flush()
    with BagReader(path) as bag:
        assert indices(bag) == list(range(9))
    assert writer.size == path.stat().st_size
    writer.close()


def test_a_chunk_gets_into_the_file_without_another_call(helpers, tmp_path):
    """A recording that is killed later loses no chunk that was full."""
    path = tmp_path / "a.bag"
    writer = write(path, blocks(4), "lz4")
    until(lambda: len(BagReader(path).chunks) >= 2, what="two chunks in the file")
    writer.close()


class Disk(io.BytesIO):
    """A disk with so much room."""

    def __init__(self, room: int) -> None:
        super().__init__()
        self.room = room

    def write(self, data) -> int:
        if self.tell() + len(data) > self.room:
            super().write(memoryview(data)[: max(self.room - self.tell(), 0)])
            raise OSError(errno.ENOSPC, "No space left on device")
        return super().write(data)


@pytest.mark.parametrize("compression", ["none", *PACKED])
def test_a_disk_that_fills_up_while_others_compress(helpers, compression):
    """The error comes with a later write or with close, counts what is lost, and the file ends with a whole chunk."""
    messages = blocks(40)
    disk = Disk(700_000)
    writer = BagWriter(disk, compression, 150_000)

    def go() -> None:
        for i, message in enumerate(messages):
            writer.write("/blocks", message, Time(i, 0))
        writer.close()

    with pytest.raises(BagError, match="No space left on device") as caught:
        go()
    with pytest.raises(BagError, match="No space left"):
        writer.write("/blocks", messages[0], 1)
    try:
        writer.close()
    except BagError:
        pass  # no room for the contents either
    with BagReader(disk) as bag:
        found = indices(bag)
    assert found == list(range(len(found)))
    assert found
    lost = writer.message_count - len(found)
    assert f" {lost} messages were not in the file yet and are lost" in str(caught.value)
    assert caught.value.offset is not None
    assert caught.value.offset <= 700_000


def test_compression_that_fails_is_reported_and_nothing_later_is_written(helpers, monkeypatch):
    calls: list[int] = []

    def compress(data: bytes) -> bytes:
        calls.append(1)
        if len(calls) > 2:
            raise MemoryError("no memory for it")
        return real(data)

    from rosproto.bag import compression, writer

    real = compression.compressor("lz4")
    monkeypatch.setattr(writer, "compressor", lambda name: compress)
    file = io.BytesIO()

    def go() -> None:
        write(file, blocks(20), "lz4").close()

    with pytest.raises(BagError, match="no memory for it"):
        go()
    with BagReader(file) as bag:
        assert indices(bag) in ([0, 1], [0, 1, 2, 3])  # the third call may have been for the second chunk


def test_a_signal_handler_may_close_the_bag_during_a_write(monkeypatch):
    """Also while a chunk is written to the file: nothing waits for itself."""
    file = io.BytesIO()
    bag = BagWriter(file, "lz4", 150_000)
    put, closed = output.BagOutputFile.put, []

    def interrupted(self, pieces, at):
        if threading.current_thread() is threading.main_thread() and at > 300_000 and not closed:
            closed.append(at)
            bag.close()
        return put(self, pieces, at)

    monkeypatch.setattr(output.BagOutputFile, "put", interrupted)
    for i, message in enumerate(blocks(20)):
        if closed:
            break
        bag.write("/blocks", message, Time(i, 0))
        bag.flush()
    with BagReader(file) as found:
        assert indices(found)


def test_memory_on_its_way_is_bounded(monkeypatch):
    """A disk that is slower than the writer holds the writer up."""
    monkeypatch.setattr(output, "worker_count", lambda: 1)
    monkeypatch.setattr(output, "AHEAD_BYTES", 500_000)
    writer = BagWriter(io.BytesIO(), "bz2", 150_000)
    for i, message in enumerate(blocks(20)):
        writer.write("/blocks", message, Time(i, 0))
        assert writer._chunks._bytes <= 500_000
    writer.close()


def test_no_thread_is_left_of_writing_and_reading(helpers, tmp_path):
    path = tmp_path / "a.bag"
    write(path, blocks(20), "lz4").close()
    bag = BagReader(path)
    abandoned = bag.read_messages()
    next(abandoned)
    bag.close()
    names = {"rosproto:bag writer", "rosproto:bag reader"}
    until(
        lambda: not names & {thread.name for thread in threading.enumerate()}, what="the end of the threads"
    )


def test_a_program_that_never_closes_its_bag_ends_and_keeps_the_whole_chunks(tmp_path):
    path = tmp_path / "a.bag"
    code = (
        "import sys; from rosproto.bag import BagWriter, output; output.worker_count = lambda: 2\n"
        "from rosproto.codec import message_class; import numpy as np\n"
        "message = message_class('std_msgs/UInt8MultiArray')(data=np.zeros(400_000, np.uint8))\n"
        "bag = BagWriter(sys.argv[1], 'bz2', 300_000)\n"
        "for i in range(12): bag.write('/a', message, i)\n"
    )
    subprocess.run([sys.executable, "-c", code, str(path)], check=True, timeout=60)
    with BagReader(path) as bag:
        assert indices(bag) == list(range(12))
        assert not bag.indexed


def test_a_file_somebody_else_closed_is_an_error(tmp_path):
    with (tmp_path / "a.bag").open("w+b") as file:
        writer = write(file, blocks(1), "lz4")
    with pytest.raises(BagError, match="closed file"):
        writer.flush()


class Dribble(io.BytesIO):
    """A raw file that takes and gives little at a time."""

    def write(self, data) -> int:
        return super().write(memoryview(data)[:70_000])

    def read(self, size=-1) -> bytes:
        return super().read(min(size, 70_000))


@pytest.mark.parametrize("compression", ["none", *PACKED])
def test_files_that_take_and_give_a_part_of_what_is_asked(compression):
    file = Dribble()
    write(file, blocks(6), compression).close()
    assert indices(BagReader(file)) == list(range(6))


def test_damage_ahead_is_told_when_its_turn_comes(helpers, tmp_path):
    file = io.BytesIO()
    write(file, blocks(20), "lz4").close()
    data = bytearray(file.getvalue())
    with BagReader(io.BytesIO(bytes(data))) as bag:
        at = bag.chunks[5].pos
    data[at + 80 : at + 200] = b"\xff" * 120
    found: list[int] = []
    with BagReader(io.BytesIO(bytes(data))) as bag:
        times = (stamp.secs for _, _, stamp in bag.read_messages())
        with pytest.raises(BagError, match=f"chunk at byte {at}"):
            found.extend(times)
    assert found == list(range(10))
    with BagReader(io.BytesIO(bytes(data)), skip_damaged=True) as bag:
        assert indices(bag) == [*range(10), *range(12, 20)]
        assert len(bag.damage) == 1


def test_what_is_read_ahead_never_exceeds_its_budget(helpers, monkeypatch):
    """Larger chunks are read when their turn comes, or memory would hold several of them."""
    monkeypatch.setattr(ahead, "AHEAD_BYTES", 1_000_000)
    file = io.BytesIO()
    writer = BagWriter(file, "lz4", 90_000)
    for i, message in enumerate([*blocks(6, 100_000), *blocks(4, 1_200_000), *blocks(6, 100_000)]):
        writer.write("/blocks", message, Time(i, 0))
    writer.close()
    real, held = ahead.ReadAhead._try, []

    def watched(self, info):
        data = real(self, info)
        held.append(0 if data is None else len(data.blob))
        return data

    monkeypatch.setattr(ahead.ReadAhead, "_try", watched)
    with BagReader(file) as bag:
        assert indices(bag) == list(range(16))
    assert sum(size > 0 for size in held) >= 8
    assert max(held, default=0) * (2 * helpers + 2) <= 1_000_000


def test_a_picture_of_6_mb_is_read_ahead(monkeypatch):
    """The caller has something else to do than to unpack it."""
    monkeypatch.setattr(ahead, "worker_count", lambda: 1)
    file = io.BytesIO()
    write(file, blocks(6, 6_000_000), "lz4").close()
    with BagReader(file) as bag:
        readers: list[int | None] = []
        read = bag._read_chunk
        monkeypatch.setattr(
            bag,
            "_read_chunk",
            lambda info, max_bytes=None: (readers.append(max_bytes), read(info, max_bytes))[1],
        )
        assert indices(bag) == list(range(6))
    assert readers.count(None) == 1


def test_two_iterations_at_once_do_not_disturb_each_other(helpers):
    file = io.BytesIO()
    write(file, blocks(20), "lz4").close()
    with BagReader(file) as bag:
        pairs = list(zip(bag.read_messages(), bag.read_messages(start_time=5.0), strict=False))
    assert [(a[2].secs, b[2].secs) for a, b in pairs] == [(i, i + 5) for i in range(15)]


def test_a_message_outlives_reader_and_iteration(tmp_path):
    """Its arrays are views of the chunk, which they keep; nothing writes into that memory again."""
    path = tmp_path / "a.bag"
    messages = blocks(6)
    write(path, messages, "lz4").close()
    with BagReader(path) as bag:
        kept = [message for _, message, _ in bag.read_messages()]
    gc.collect()
    assert [k.data.tobytes() for k in kept] == [m.data.tobytes() for m in messages]


FAULTS = """
import resource, sys
from rosproto.bag import BagReader
def faults():
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt
fewest = sys.maxsize
for _ in range(20):
    before = faults()
    with BagReader(sys.argv[1]) as bag:
        assert sum(1 for _ in bag.read_messages(raw="view")) == 20
    fewest = min(fewest, faults() - before)
print(fewest)  # in half of the readings a thread that has just started takes another arena of the allocator
"""


@pytest.mark.skipif(
    platform.libc_ver()[0] != "glibc" or bool(sysconfig.get_config_var("Py_GIL_DISABLED")),
    reason="is about the allocator of glibc; a Python without the GIL has another one",
)
@pytest.mark.parametrize("size", [500_000, 3_000_000])
def test_chunks_are_unpacked_into_memory_that_was_used_before(tmp_path, size):
    """The system would give new pages for each chunk, one fault for each: 2400 or 14600 here."""
    path = tmp_path / "a.bag"
    write(path, blocks(20, size), "lz4").close()
    done = subprocess.run(
        [sys.executable, "-c", FAULTS, str(path)], capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) < 20 * size / 4096 / 4
