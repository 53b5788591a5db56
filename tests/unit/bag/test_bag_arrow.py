"""A topic as a table: what becomes of each kind of field, chosen columns, bounded batches, and what is refused."""

from __future__ import annotations

import io
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

from rosproto.bag import BagReader, BagWriter, Connection, RawMessage
from rosproto.codec import define, encode, message_class
from rosproto.errors import BagError, CodecError
from rosproto.time import Duration, Time

pa = pytest.importorskip("pyarrow", reason="pyarrow is not installed (extra arrow)")

Odometry = message_class("nav_msgs/Odometry")
Image = message_class("sensor_msgs/Image")
String = message_class("std_msgs/String")
Mixed = define(
    "my_msgs/Mixed",
    "time when  # of the measurement\n# seconds it took\nduration long\nuint8[] raw\nuint8[3] three\n"
    "bool yes\nstring name\nstring[] names\nfloat64[2] pair\nfloat32[] any\nmy_msgs/Part[] parts\n"
    "my_msgs/Part[1] one\nmy_msgs/Empty nothing\n"
    + "=" * 80 + "\nMSG: my_msgs/Part\nstring label\nint16 value  # V\n"
    + "=" * 80 + "\nMSG: my_msgs/Empty\n",
)  # fmt: skip
Part = type(Mixed().one[0])


def bag_of(entries: list[tuple[str, Any, Any]], compression: Any = "none", **options: Any) -> BagReader:
    file = io.BytesIO()
    with BagWriter(file, compression, **options) as bag:
        for topic, message, stamp in entries:
            bag.write(topic, message, stamp)
    return BagReader(file)


def test_each_kind_of_field() -> None:
    """Types, values, comments and what the schema tells of the topic."""
    message = Mixed(
        when=Time(5, 7), long=Duration(-1, 0), raw=b"ab", three=b"xyz", yes=True, name="n", names=["a", "b"],
        pair=[1.0, 2.0], any=[0.5], parts=[Part("p", 1), Part("q", -2)], one=[Part("r", 3)],
    )  # fmt: skip
    table = bag_of([("/t", message, Time(9, 1))]).to_arrow("/t").read_all()
    types = {name: str(table.schema.field(name).type) for name in table.schema.names}
    assert types == {
        "receive_time": "timestamp[ns, tz=UTC]",
        "when": "timestamp[ns, tz=UTC]",
        "long": "duration[ns]",
        "raw": "binary",
        "three": "fixed_size_binary[3]",
        "yes": "bool",
        "name": "dictionary<values=string, indices=int32, ordered=0>",
        "names": "list<item: string>",
        "pair": "fixed_size_list<item: double>[2]",
        "any": "list<item: float>",
        "parts": "list<item: struct<label: string, value: int16>>",
        "one": "fixed_size_list<item: struct<label: string, value: int16>>[1]",
        "nothing": "null",
    }
    row = table.drop_columns(["receive_time", "when", "long"]).to_pylist()[0]
    assert row == {
        "raw": b"ab", "three": b"xyz", "yes": True, "name": "n", "names": ["a", "b"], "pair": [1.0, 2.0],
        "any": [0.5], "parts": [{"label": "p", "value": 1}, {"label": "q", "value": -2}],
        "one": [{"label": "r", "value": 3}], "nothing": None,
    }  # fmt: skip
    assert table["when"].cast("int64").to_pylist() == [5_000_000_007]
    assert table["long"].cast("int64").to_pylist() == [-1_000_000_000]
    assert table["receive_time"].cast("int64").to_pylist() == [9_000_000_001]
    assert table.schema.field("when").metadata == {b"comment": b"of the measurement"}
    assert table.schema.field("long").metadata == {b"comment": b"seconds it took"}
    facts = table.schema.metadata
    assert (facts[b"topic"], facts[b"type"], facts[b"md5sum"]) == (
        b"/t", b"my_msgs/Mixed", Mixed._md5sum.encode(),
    )  # fmt: skip
    assert b"seconds it took" in facts[b"definition"]


@pytest.mark.parametrize("spread", [0, 1])
def test_messages_that_are_alike_give_what_others_give(spread: int) -> None:
    """As do those whose texts and arrays have many lengths: every value of every message, in either way."""
    made = []
    for i in range(70):
        many = i % 3 if spread else 2
        made.append(Mixed(
            when=Time(i, 7), long=Duration(-i, i), raw=bytes([i] * many), three=bytes([i, 0, 255]),
            yes=i % 2 == 0, name="n" * many, names=[], pair=[float(i), -1.0], any=[0.5 * i] * many,
            parts=[], one=[Part("r" * many, -i)],
        ))  # fmt: skip
    entries = [("/t", message, Time(100 + i)) for i, message in enumerate(made)]
    rows = bag_of(entries, chunk_bytes=900).to_arrow("/t").read_all()
    rows.validate(full=True)
    seen = rows.drop_columns(["receive_time", "when", "long"]).to_pylist()
    assert seen == [
        {
            "raw": m.raw, "three": m.three, "yes": m.yes, "name": m.name, "names": [], "pair": list(m.pair),
            "any": list(m.any), "parts": [], "one": [{"label": m.one[0].label, "value": m.one[0].value}],
            "nothing": None,
        }
        for m in made
    ]  # fmt: skip
    assert rows["when"].cast("int64").to_pylist() == [i * 10**9 + 7 for i in range(70)]
    assert rows["long"].cast("int64").to_pylist() == [-i * 10**9 + i for i in range(70)]


def test_units_of_known_fields() -> None:
    """From the comments of the bundled definitions; also for a robot that has a definition without comments."""
    Battery = message_class("woosh_msgs/Battery")
    schema = bag_of([("/b", Battery(), 1.0)]).to_arrow("/b").schema
    units = {field.name: (field.metadata or {}).get(b"unit", b"").decode() for field in schema}
    assert (units["batteryVoltage"], units["batteryPercentage"], units["tempMax"]) == ("V", "%", "°C")
    own = define("woosh_msgs/Battery", "uint8 batteryPercentage\nint64 tempMax\nfloat32 own  # seen, m/s\n")
    schema = bag_of([("/b", own(), 1.0)]).to_arrow("/b").schema
    assert schema.field("batteryPercentage").metadata == {b"unit": b"%"}
    assert schema.field("own").metadata == {b"comment": b"seen, m/s", b"unit": b"m/s"}
    assert schema.field("tempMax").metadata is None
    position = bag_of([("/o", Odometry(), 1.0)]).to_arrow("/o", ["pose.pose.position"]).schema.field(1)
    assert {position.type.field(i).metadata[b"unit"] for i in range(3)} == {b"m"}


def test_pandas_is_not_imported_for_nothing() -> None:
    """pyarrow's way to make an array of numpy's looks for pandas, which takes longer than the rest."""
    code = (
        "import io, sys; from rosproto.bag import BagReader, BagWriter; from rosproto.codec import message_class\n"
        "file = io.BytesIO(); bag = BagWriter(file); bag.write('/o', message_class('nav_msgs/Odometry')(), 1.0)\n"
        "bag.close(); assert BagReader(file).to_arrow('/o').read_all().num_rows == 1\n"
        "print('pandas' in sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True
    )
    assert done.stdout.strip() == "False"


def test_chosen_fields() -> None:
    """Each a column of its path, in the order asked for, once."""
    message = Odometry()
    message.pose.pose.position.x = 1.5
    message.header.frame_id = "map"
    bag = bag_of([("/odom", message, 1.0), ("/odom", message, 2.0)])
    table = bag.to_arrow(
        "/odom", ["pose.pose.position.x", "header.frame_id", "pose.pose.position.x"]
    ).read_all()
    assert table.schema.names == ["receive_time", "pose.pose.position.x", "header.frame_id"]
    assert table["pose.pose.position.x"].to_pylist() == [1.5, 1.5]
    both = bag.to_arrow("/odom", ["pose.pose", "pose.pose.position"]).read_all()
    assert both["pose.pose.position"].to_pylist() == [{"x": 1.5, "y": 0.0, "z": 0.0}] * 2
    assert both["pose.pose"].to_pylist()[0]["position"] == {"x": 1.5, "y": 0.0, "z": 0.0}


@pytest.mark.parametrize(
    ("path", "says"),
    [("pose.pose.x", "position, orientation"), ("nope", "header, child_frame_id"), ("", "header")],
)
def test_no_such_field(path: str, says: str) -> None:
    """The error names what there is."""
    bag = bag_of([("/odom", Odometry(), 1.0)])
    with pytest.raises(BagError, match=says):
        bag.to_arrow("/odom", [path])


def test_a_path_does_not_lead_into_an_array() -> None:
    """A list is a column as a whole."""
    with pytest.raises(BagError, match=r"parts is my_msgs/Part\[\], a column as a whole"):
        bag_of([("/t", Mixed(), 1.0)]).to_arrow("/t", ["parts.value"])


def test_batches_are_bounded() -> None:
    """A bag of 24 MB of pictures is never a table in memory."""
    image = Image(height=1, width=1_000_000, data=bytes(1_000_000))
    reader = bag_of([("/image", image, float(i)) for i in range(24)]).to_arrow("/image")
    sizes = [batch.num_rows for batch in reader]
    assert sum(sizes) == 24
    assert max(sizes) <= 5


def test_in_the_order_of_time_through_overlapping_chunks() -> None:
    """As messages are read."""
    entries = [("/s", String(data=str(i)), Time((i * 7) % 50)) for i in range(50)]
    table = bag_of(entries, "lz4", chunk_bytes=200).to_arrow("/s").read_all()
    stamps = table["receive_time"].cast("int64").to_pylist()
    assert stamps == sorted(stamps)
    assert sorted(table["data"].to_pylist()) == sorted(str(i) for i in range(50))


def test_a_span() -> None:
    """Both ends belong to it."""
    bag = bag_of([("/s", String(data=str(i)), Time(i)) for i in range(9)])
    table = bag.to_arrow("/s", start_time=Time(3), end_time=Time(5)).read_all()
    assert table["data"].to_pylist() == ["3", "4", "5"]
    assert bag.to_arrow("/s", start_time=Time(99)).read_all().num_rows == 0


def test_a_field_called_receive_time_keeps_its_name() -> None:
    """Ours gets an underscore then."""
    own = define("my_msgs/Own", "int32 receive_time\n")
    table = bag_of([("/t", own(4), 1.0)]).to_arrow("/t").read_all()
    assert table.schema.names == ["_receive_time", "receive_time"]
    assert table["receive_time"].to_pylist() == [4]


def test_a_message_of_another_form_is_the_codecs_error() -> None:
    """With the path of the field and the offset."""
    connection = Connection(0, "/s", "std_msgs/String", String._md5sum, String._full_text)
    raw = RawMessage("std_msgs/String", b"\xff\0\0\0ab", String._md5sum, (0, 0), connection)
    bag = bag_of([("/s", String(data="good"), 1.0), ("/s", raw, 2.0)])
    with pytest.raises(CodecError, match="255"):
        bag.to_arrow("/s").read_all()


def test_two_definitions_are_refused() -> None:
    """A table has one; the error names both md5sums."""
    connection = Connection(0, "/s", "my_msgs/Other", "1" * 32, "int8 x\n")
    raw = RawMessage("my_msgs/Other", b"\1", "1" * 32, (0, 0), connection)
    bag = bag_of([("/s", String(data="one"), 1.0), ("/s", raw, 2.0)])
    with pytest.raises(BagError, match="2 definitions") as caught:
        bag.to_arrow("/s")
    assert "1" * 32 in str(caught.value)


@pytest.mark.promise("does not fill a table")
def test_elements_of_no_bytes_do_not_fill_the_memory() -> None:
    """Four bytes that ask for four thousand million empty messages."""
    light = define("my_msgs/Light", "my_msgs/Nothing[] many\n" + "=" * 80 + "\nMSG: my_msgs/Nothing\n")
    connection = Connection(0, "/t", "my_msgs/Light", light._md5sum, light._full_text)
    raw = RawMessage("my_msgs/Light", b"\xff\xff\xff\xff", light._md5sum, (0, 0), connection)
    with pytest.raises(CodecError, match="no bytes"):
        bag_of([("/t", raw, 1.0)]).to_arrow("/t").read_all()


def test_text_that_is_not_utf8() -> None:
    """Arrow's strings are UTF-8: odd bytes become U+FFFD."""
    connection = Connection(0, "/s", "std_msgs/String", String._md5sum, String._full_text)
    raw = RawMessage("std_msgs/String", b"\2\0\0\0a\xff", String._md5sum, (0, 0), connection)
    assert bag_of([("/s", raw, 2.0)]).to_arrow("/s").read_all()["data"].to_pylist() == ["a�"]


def test_without_pyarrow_the_error_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    """And nothing else of the bag needs it."""
    bag = bag_of([("/s", String(data="x"), 1.0)])
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(BagError, match=r"\.\[arrow\]"):
        bag.to_arrow("/s")
    assert encode(next(iter(bag))[1]) == encode(String(data="x"))


def test_pandas_and_polars_in_one_line() -> None:
    """As the documentation has it."""
    pytest.importorskip("pandas")
    polars = pytest.importorskip("polars")
    bag = bag_of([("/s", String(data=f"t{i}"), float(i)) for i in range(3)])
    assert list(bag.to_arrow("/s").read_pandas()["data"]) == ["t0", "t1", "t2"]
    frame = polars.from_arrow(bag.to_arrow("/s").read_all())
    assert frame["data"].to_list() == ["t0", "t1", "t2"]
    assert np.dtype("datetime64[ns]") == bag.to_arrow("/s").read_all()["receive_time"].to_numpy().dtype
