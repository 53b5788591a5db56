"""Names of the files, splits, and what is repeated in each file."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from rosproto.bag import BagReader, Connection, RawMessage
from rosproto.bag.output import BagOutputFile
from rosproto.errors import BagError
from rosproto.recording import BagSeries, bag_name
from rosproto.time import Time

PLAIN = Connection(-1, "/a", "std_msgs/String", "992ce8a1687cec8c8bd883ec73ca41d1", "string data\n", {})


def message(text: str, **header: str) -> RawMessage:
    connection = (
        PLAIN if not header else Connection(-1, "/a", PLAIN.type, PLAIN.md5sum, "string data\n", header)
    )
    data = len(text).to_bytes(4, "little") + text.encode()
    return RawMessage(PLAIN.type, data, PLAIN.md5sum, (0, 0), connection)


def test_names_are_rosbags() -> None:
    """prefix_date_number.bag; a .bag in the prefix is taken off."""
    assert re.fullmatch(r"\d{4}(-\d\d){5}\.bag", bag_name())
    assert re.fullmatch(r"run_\d{4}(-\d\d){5}_3\.bag", bag_name("run.bag", number=3))
    assert bag_name("dir/x", dated=False) == "dir/x.bag"
    assert bag_name("x.bag", dated=False, number=0) == "x_0.bag"
    with pytest.raises(ValueError, match="the bag has no name"):
        bag_name(dated=False)


def test_active_while_written(tmp_path: Path) -> None:
    """A name that ends in .bag is a whole bag."""
    series = BagSeries(lambda n: str(tmp_path / "x.bag"))
    series.write("/a", message("1"), Time(1, 0))
    assert os.listdir(tmp_path) == ["x.bag.active"]
    series.close()
    assert os.listdir(tmp_path) == ["x.bag"]
    assert series.size == os.path.getsize(tmp_path / "x.bag")
    with pytest.raises(BagError, match="already exists"):
        BagSeries(lambda n: str(tmp_path / "x.bag"))
    BagSeries(lambda n: str(tmp_path / "x.bag"), overwrite=True).close()


def test_what_a_dead_recorder_left_is_not_replaced(tmp_path: Path) -> None:
    """Its .active file is all there is of that recording; with overwrite=True it goes."""
    path = str(tmp_path / "x.bag")
    died = BagSeries(lambda n: path, chunk_bytes=1)
    died.write("/a", message("kept"), Time(1, 0))
    died._writer._output.close()
    with pytest.raises(BagError, match=r"x\.bag\.active: a recording of that name .* reindex"):
        BagSeries(lambda n: path)
    with BagReader(died.active_path) as bag:
        assert bag.message_count == 1
    BagSeries(lambda n: path, overwrite=True).close()
    with BagReader(path) as bag:
        assert bag.message_count == 0


def test_splits_by_time_repeat_latched_messages_of_every_publisher(tmp_path: Path) -> None:
    """Each bag starts with the last latched message of each caller, stamped as the split's first message."""
    series = BagSeries(lambda n: str(tmp_path / f"{n}.bag"), split_seconds=10.0)
    series.write("/a", message("from x", callerid="/x", latching="1"), Time(100, 0))
    series.write("/a", message("from y", callerid="/y", latching="1"), Time(101, 0))
    series.write("/a", message("in the first"), Time(109, 999_999_999))
    series.write("/a", message("in the second"), Time(110, 0))
    series.write("/a", message("after a gap"), Time(175, 0))
    series.close()
    assert [Path(p).name for p in series.paths] == ["0.bag", "1.bag", "2.bag"]
    assert series.messages == 5
    contents = []
    for path in series.paths:
        with BagReader(path) as bag:
            contents.append([m.data for _, m, _ in bag.read_messages()])
    assert contents[0] == ["from x", "from y", "in the first"]
    assert sorted(contents[1]) == ["from x", "from y", "in the second"]
    assert sorted(contents[2]) == ["after a gap", "from x", "from y"]


def test_only_the_newest_are_kept(tmp_path: Path) -> None:
    """With `keep`, the oldest bags are deleted."""
    series = BagSeries(lambda n: str(tmp_path / f"{n}.bag"), split_seconds=1.0, keep=2, repeat_latched=False)
    for second in range(6):
        series.write("/a", message(str(second)), Time(second, 0))
    series.close()
    assert sorted(os.listdir(tmp_path)) == ["4.bag", "5.bag"]


def test_a_full_disk_keeps_the_active_name_and_what_is_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After the error the file reads up to its last whole chunk."""
    series = BagSeries(lambda n: str(tmp_path / "x.bag"), chunk_bytes=1)
    for number in range(3):
        series.write("/a", message(str(number)), Time(number, 0))

    def full(self: BagOutputFile, pieces: object, at: int) -> int:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(BagOutputFile, "put", full)
    with pytest.raises(BagError, match="No space left on device"):
        series.write("/a", message("3"), Time(3, 0))
    with pytest.raises(BagError):
        series.close()
    with BagReader(tmp_path / "x.bag.active") as bag:
        assert [m.data for _, m, _ in bag.read_messages()] == ["0", "1", "2"]
        assert not bag.indexed
