"""Damaged bags: cut anywhere, bytes changed, never closed; and mending them."""

from __future__ import annotations

import io

import pytest

from rosproto.bag import BagReader, BagWriter, recover, reindex
from rosproto.bag.output import BagOutputFile
from rosproto.errors import BagError, RosError
from rosproto.time import Time
from tests.unit.bag.bagmaker import COMPRESSIONS, String, bag_bytes, encoded, entries, plain, read

HEAD = 13 + 4096 + 8


@pytest.mark.parametrize("compression", COMPRESSIONS)
@pytest.mark.parametrize("close", [True, False], ids=["closed", "died"])
def test_a_bag_cut_anywhere_gives_its_first_messages(compression, close):
    what = entries(120)
    data = bag_bytes(what, compression, close=close)
    expected = encoded(what)
    best = 0
    for cut in [*range(13, len(data), 61), *range(HEAD, HEAD + 40), *range(len(data) - 40, len(data))]:
        bag = read(data[:cut])
        found = plain(bag.read_messages(raw=True))
        assert found == expected[: len(found)], cut
        assert len(found) >= best - 0 or cut < HEAD + 40
        assert bag.damage or (not close and bag.message_count in (0, len(found)))
        best = max(best, len(found)) if cut < len(data) - 40 else best
    assert best > 60


def test_cutting_later_never_gives_fewer_messages():
    what = entries(60)
    data = bag_bytes(what)
    counts = [read(data[:cut]).message_count for cut in range(HEAD, len(data), 23)]
    assert counts == sorted(counts)
    assert counts[-1] == 60


@pytest.mark.promise("A writer that died leaves whole chunks, and")
@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_a_writer_that_died_leaves_its_complete_chunks(compression):
    what = entries(120)
    bag = read(bag_bytes(what, compression, close=False))
    found = plain(bag.read_messages(raw=True))
    assert found == encoded(what)[: len(found)]
    assert len(found) > 80
    assert "never closed" in bag.damage[0]
    assert not bag.indexed


def test_a_chunk_whose_size_was_never_filled_in_is_read_to_its_end():
    what = entries(40)
    data = bytearray(bag_bytes(what, chunk_bytes=100_000, close=False) or b"")
    whole = bag_bytes(what, chunk_bytes=100_000)
    at = whole.index(b"op=\x05")
    sizes = whole.index(b"size=", at) + 5
    end = whole.index(b"op=\x04") - 30
    data = bytearray(whole[:end])
    data[sizes : sizes + 8] = bytes(
        8
    )  # uncompressed and compressed size, as rosbag leaves them until the end
    data[data.index(b"index_pos=") + 10 : data.index(b"index_pos=") + 18] = bytes(8)
    found = plain(read(bytes(data)).read_messages(raw=True))
    assert found == encoded(what)[: len(found)]
    assert len(found) >= 38


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_changed_bytes_give_a_value_or_a_ros_error(compression):
    data = bytearray(bag_bytes(entries(60), compression))
    for at in range(0, len(data), 29):
        data[at] ^= 0x41
        try:
            bag = read(bytes(data), skip_damaged=True)
            list(bag.read_messages(raw=True))
            bag.times(next(iter(bag.topics), "/none"))
        except RosError:
            pass
        data[at] ^= 0x41


@pytest.mark.parametrize("compression", ["bz2", "lz4"])
def test_a_damaged_chunk_is_an_error_that_says_what_to_do_or_is_left_out(compression):
    what = entries(120)
    data = bytearray(bag_bytes(what, compression))
    second = read(bytes(data)).chunks[1].pos
    data[second + 90] ^= 0xFF
    with pytest.raises(BagError, match="skip_damaged=True") as caught:
        list(read(bytes(data)).read_messages(raw=True))
    assert caught.value.offset == second
    bag = read(bytes(data), skip_damaged=True)
    found = plain(bag.read_messages(raw=True))
    expected = encoded(what)
    assert [e for e in expected if e in found] == found
    assert 80 < len(found) < 120
    assert any(f"byte {second}" in words for words in bag.damage)


@pytest.mark.parametrize("field", [b"op=\x04", b"count=", b"compression="])
def test_a_damaged_index_record_or_chunk_header_is_told_although_the_messages_are_read(field, tmp_path):
    """rosbag does not open such a bag: check and reindex say so, and fix writes one that it opens."""
    what = entries(120)
    data = bytearray(bag_bytes(what))
    path = tmp_path / "damaged.bag"
    assert read(bytes(data)).index_damage() == []
    second = read(bytes(data)).chunks[1].pos
    data[data.index(field, second)] ^= 1
    path.write_bytes(data)
    with BagReader(path) as bag:
        assert f"byte {second}" in bag.index_damage()[0]
    with pytest.raises(BagError, match=r"rosbag does not open such a bag.*bag fix"):
        reindex(path)
    assert path.read_bytes() == data
    recover(path, tmp_path / "fixed.bag")
    with BagReader(tmp_path / "fixed.bag") as bag:
        assert not bag.index_damage()
        assert not bag.damage


def test_a_scan_goes_on_behind_garbage_between_chunks():
    what = entries(120)
    data = bag_bytes(what, close=False)
    third = read(data).chunks[2].pos
    data = data[:third] + b"\xff" * 77 + data[third:]
    bag = read(data)
    assert plain(bag.read_messages(raw=True)) == plain(
        read(bag_bytes(what, close=False)).read_messages(raw=True)
    )
    assert any("goes on" in words for words in bag.damage)


def test_messages_whose_connection_record_is_lost_are_told():
    data = bytearray(bag_bytes(entries(60), close=False))
    at = data.index(b"op=\x07")
    data[at + 3] = 0x63
    bag = read(bytes(data))
    list(bag.read_messages(raw=True))
    assert any("record is lost" in words for words in bag.damage)


def test_an_index_position_that_lies_leads_to_a_scan():
    what = entries(60)
    data = bytearray(bag_bytes(what))
    at = data.index(b"index_pos=") + 10
    for lie in (1, 4117, len(data) - 1, 1 << 62):
        data[at : at + 8] = lie.to_bytes(8, "little")
        bag = read(bytes(data))
        assert "index is not usable" in bag.damage[0]
        assert plain(bag.read_messages(raw=True)) == encoded(what)


def test_a_huge_length_takes_no_memory():
    data = bytearray(bag_bytes(entries(5)))
    at = data.index(b"size=") + 5
    data[at : at + 8] = b"\xff\xff\xff\xff\xff\xff\xff\xff"
    bag = read(bytes(data), skip_damaged=True)
    list(bag.read_messages(raw=True))
    assert bag.damage


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_reindex_in_place_keeps_everything_that_is_whole(tmp_path, compression):
    what = entries(120)
    data = bag_bytes(what, compression, close=False)
    path = tmp_path / "died.bag"
    for cut in [HEAD, *range(HEAD + 500, len(data), 217), len(data)]:
        before = plain(read(data[:cut]).read_messages(raw=True))
        path.write_bytes(data[:cut])
        report = reindex(path)
        with BagReader(path) as bag:
            assert bag.damage == []
            assert bag.indexed
            assert plain(bag.read_messages(raw=True)) == before
        assert report.messages == len(before)
        assert report.damage


@pytest.mark.parametrize("compression", COMPRESSIONS)
@pytest.mark.parametrize("puts", [0, 1, 2])
def test_reindex_on_a_disk_that_is_still_full_changes_nothing(tmp_path, monkeypatch, compression, puts):
    """The messages of the cut-off chunk are nowhere else while they are written again."""
    data = bag_bytes(entries(120), compression, close=False)
    data = data[: read(data).chunks[-1].pos + 400]
    path = tmp_path / "died.bag"
    path.write_bytes(data)
    put, left = BagOutputFile.put, iter(range(puts))

    def full(self, pieces, at):
        if next(left, None) is None:
            raise OSError(28, "No space left on device")
        return put(self, pieces, at)

    with monkeypatch.context() as context:
        context.setattr(BagOutputFile, "put", full)
        with pytest.raises(
            BagError, match="cannot repair the bag: No space left on device; it is left as it"
        ):
            reindex(path)
    assert path.read_bytes() == data
    reindex(path)
    with BagReader(path) as bag:
        assert set(bag.compression()) == {compression}


def test_ctrl_c_while_mending_changes_nothing(tmp_path, monkeypatch):
    data = bag_bytes(entries(120), close=False)
    path = tmp_path / "died.bag"
    path.write_bytes(data[:-100])

    def interrupted(self, pieces, at):
        raise KeyboardInterrupt

    monkeypatch.setattr(BagOutputFile, "put", interrupted)
    with pytest.raises(KeyboardInterrupt):
        reindex(path)
    assert path.read_bytes() == data[:-100]


def test_reindex_leaves_a_sound_bag_as_it_is(tmp_path):
    path = tmp_path / "sound.bag"
    path.write_bytes(bag_bytes(entries(20)))
    assert reindex(path).damage == ()
    assert path.read_bytes() == bag_bytes(entries(20))


def test_reindex_refuses_damage_in_the_middle_and_recover_saves_the_rest(tmp_path):
    what = entries(120)
    data = bag_bytes(what, "lz4", close=False)
    third = read(data).chunks[2].pos
    path, saved = tmp_path / "bad.bag", tmp_path / "saved.bag"
    path.write_bytes(data[: third + 20] + b"\xff" * 50 + data[third + 20 :])
    with pytest.raises(BagError, match="rosproto bag fix"):
        reindex(path)
    report = recover(path, saved, compression="bz2")
    assert report.damage
    with BagReader(saved) as bag:
        found = plain(bag.read_messages(raw=True))
        assert bag.damage == []
    expected = encoded(what)
    assert report.messages == len(found) > 60
    assert [e for e in expected if e in found] == found
    with pytest.raises(BagError, match="already exists"):
        recover(path, saved)


def test_a_bag_can_be_continued_after_reindex(tmp_path):
    path = tmp_path / "died.bag"
    path.write_bytes(bag_bytes(entries(30), close=False))
    reindex(path)
    with BagWriter(path, append=True) as writer:
        writer.write("/chatter", String(data="more"), Time(500))
    with BagReader(path) as bag:
        assert [m.data for _, m, _ in bag.read_messages("/chatter")][-1] == "more"


def test_an_open_file_is_mended_and_stays_open(tmp_path):
    """A stream in memory, and a file of the system's."""
    data = bag_bytes(entries(30), close=False)[:-100]
    before = plain(read(data).read_messages(raw=True))
    path = tmp_path / "died.bag"
    path.write_bytes(data)
    with open(path, "r+b") as file:
        for stream in (io.BytesIO(data), file):
            assert reindex(stream).messages == len(before)
            bag = BagReader(stream)
            assert bag.indexed
            assert plain(bag.read_messages(raw=True)) == before
    with pytest.raises(BagError, match="damaged before its end"):
        reindex(io.BytesIO(data[: HEAD + 20] + b"\xff" * 50 + data[HEAD + 20 :]))


def test_an_index_section_that_is_cut_off_is_scanned():
    what = entries(30)
    data = bag_bytes(what)
    bag = BagReader(io.BytesIO(data[:-5]))
    assert plain(bag.read_messages(raw=True)) == encoded(what)
    assert bag.damage


@pytest.mark.parametrize("after", [b"\n", bytes(3000), b"second bag", b"\xff" * 9])
@pytest.mark.parametrize("count", [0, 60])
def test_bytes_behind_the_index_do_not_belong_to_the_bag(after: bytes, count: int):
    """The file header's counts say where the index ends, as in rosbag; what a copy appended is counted."""
    sound = bag_bytes(entries(count))
    more = bag_bytes(entries(5)) if after == b"second bag" else after
    with read(sound + more) as bag:
        assert bag.indexed
        assert not bag.damage
        assert bag.trailing_bytes == len(more)
        assert plain(bag.read_messages(raw=True)) == plain(read(sound).read_messages(raw=True))
    file = io.BytesIO(sound + more)
    with BagWriter(file, append=True) as writer:
        writer.write("/chatter", String(data="last"), 2000.0)
    assert read(file.getvalue()).trailing_bytes == 0
    assert len(read(file.getvalue())) == count + 1


def test_an_index_larger_than_one_read_is_read_whole(monkeypatch):
    """A record that lies across two reads, or is larger than one, is put together."""
    from rosproto.bag import index_section

    data = bag_bytes(entries(300), chunk_bytes=1)
    for block in (1, 50, 700):
        monkeypatch.setattr(index_section, "_BLOCK", block)
        with read(data) as bag:
            assert bag.indexed
            assert len(bag) == 300
        assert not read(data[:-1]).indexed
