"""`rosproto bag export`: CSV, NPZ, PNG, MCAP; what needs a package that is absent says which extra."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rosproto.bag import BagWriter, open_bag
from rosproto.cli import main
from rosproto.cli.bag_export import pixels_of
from rosproto.cli.exit_codes import CommandError
from rosproto.cli.export_parquet import file_name, file_names
from rosproto.codec import define, message_class
from rosproto.numeric.pngfile import encode_png
from tests.support.png import read_png

String = message_class("std_msgs/String")
Odometry = message_class("nav_msgs/Odometry")
Image = message_class("sensor_msgs/Image")
CompressedImage = message_class("sensor_msgs/CompressedImage")


@pytest.fixture
def bag(tmp_path: Path) -> str:
    """Odometry, text with everything CSV minds, and a picture."""
    path = tmp_path / "run.bag"
    with BagWriter(path) as writer:
        for i in range(5):
            odometry = Odometry()
            odometry.pose.pose.position.x = i / 2
            odometry.header.frame_id = "odom"
            writer.write("/odom", odometry, 1000.0 + i)
        writer.write(
            "/ns/said", String(data='a "b", c\nd'), 1000.5, header={"callerid": "/x", "latching": "1"}
        )
        image = Image(height=2, width=3, encoding="bgr8", step=10, data=bytes(range(20)))
        writer.write("/camera", image, 1001.25)
    return str(path)


def test_csv(bag: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A file a topic, columns as rostopic names them, quoting that readers understand."""
    import csv

    assert main(["bag", "export", bag, "csv", "-o", str(tmp_path / "out"), "--topics", "/odom", "/ns/*"]) == 0
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == ["ns-said.csv", "odom.csv"]
    with open(tmp_path / "out" / "odom.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["field.pose.pose.position.x"] for row in rows] == ["0.0", "0.5", "1.0", "1.5", "2.0"]
    assert rows[0]["%time"] == "1000000000000"
    with open(tmp_path / "out" / "ns-said.csv", newline="") as file:
        assert [row["field.data"] for row in csv.DictReader(file)] == ['a "b", c\nd']
    assert str(tmp_path / "out" / "odom.csv") in capsys.readouterr().out


def test_csv_of_some_fields_and_a_span(bag: str, tmp_path: Path) -> None:
    """Only what is asked for."""
    words = "--fields pose.pose.position.x header.frame_id --topics /odom -s 1 -u 2".split()
    assert main(["bag", "export", bag, "csv", "-o", str(tmp_path), *words]) == 0
    lines = (tmp_path / "odom.csv").read_text().splitlines()
    assert lines[0] == "%time,field.pose.pose.position.x,field.header.frame_id"
    assert lines[1:] == ["1001000000000,0.5,odom", "1002000000000,1.0,odom", "1003000000000,1.5,odom"]


def test_csv_of_some_fields_keeps_the_cell_of_an_empty_text(tmp_path: Path) -> None:
    """An empty text is an empty cell, and the columns behind it stay where they are; an empty array is none."""
    with BagWriter(tmp_path / "run.bag") as writer:
        for frame in ("", "map"):
            odometry = Odometry()
            odometry.header.frame_id, odometry.pose.pose.position.x = frame, 1.5
            writer.write("/odom", odometry, 1000.0)
        writer.write("/said", String(data=""), 1000.0)
        writer.write("/scan", message_class("sensor_msgs/LaserScan")(ranges=[]), 1000.0)
    words = ["bag", "export", str(tmp_path / "run.bag"), "csv", "-o", str(tmp_path)]
    fields = ["header.frame_id", "child_frame_id", "pose.pose.position.x"]
    assert main([*words, "--topics", "/odom", "--fields", *fields]) == 0
    lines = (tmp_path / "odom.csv").read_text().splitlines()
    assert lines[1:] == ["1000000000000,,,1.5", "1000000000000,map,,1.5"]
    assert main([*words, "--topics", "/said"]) == 0
    assert (tmp_path / "said.csv").read_text() == "%time,field.data\n1000000000000,\n"
    assert main([*words, "--topics", "/scan", "--fields", "ranges", "range_max"]) == 0
    assert (tmp_path / "scan.csv").read_text() == "%time,field.range_max\n1000000000000,0.0\n"


def test_npz(bag: str, tmp_path: Path) -> None:
    """A file a topic, an array a field; a span cuts all of them."""
    assert main(["bag", "export", bag, "npz", "-o", str(tmp_path / "all")]) == 0
    with np.load(tmp_path / "all" / "odom.npz") as arrays:
        assert arrays["pose.pose.position.x"].tolist() == [0.0, 0.5, 1.0, 1.5, 2.0]
        assert arrays["pose.covariance"].shape == (5, 36)
        assert arrays["header.frame_id"].tolist() == ["odom"] * 5
    assert main(["bag", "export", bag, "npz", "-o", str(tmp_path), "-s", "3.5", "--topics", "/odom"]) == 0
    with np.load(tmp_path / "odom.npz") as arrays:
        assert arrays["receive_time"].tolist() == [1004.0]


def test_file_names() -> None:
    """Legal on every system."""
    assert file_name("/camera/image_raw") == "camera-image_raw"
    assert file_name("/a:b/../c") == "a-b-c"
    assert file_name("/") == "topic"


@pytest.mark.parametrize(
    ("encoding", "step", "data", "expected"),
    [
        ("mono8", 3, [1, 2, 9, 3, 4, 9], [[1, 2], [3, 4]]),
        ("bgr8", 6, range(12), [[[2, 1, 0], [5, 4, 3]], [[8, 7, 6], [11, 10, 9]]]),
        ("rgba8", 8, range(16), [[[0, 1, 2, 3], [4, 5, 6, 7]], [[8, 9, 10, 11], [12, 13, 14, 15]]]),
        ("mono16", 4, [1, 0, 0, 1, 2, 0, 0, 2], [[1, 256], [2, 512]]),
        ("bgr16", 12, [1, 0, 2, 0, 3, 0] * 4, [[[3, 2, 1]] * 2] * 2),
    ],
)
def test_pixels(encoding: str, step: int, data: Any, expected: Any) -> None:
    """Rows with padding, channels in the order of the picture, both widths."""
    image = Image(height=2, width=2, encoding=encoding, step=step, data=bytes(data))
    assert pixels_of(image).tolist() == expected


def test_depth_in_metres_becomes_millimetres() -> None:
    """32FC1 with NaN and out-of-range values (REP 118)."""
    data = np.array([1.5, float("nan"), 100.0, 0.001], "<f4").tobytes()
    image = Image(height=1, width=4, encoding="32FC1", step=16, data=data)
    assert pixels_of(image).tolist() == [[1500, 0, 65535, 1]]
    big = np.array([258], ">u2").tobytes()
    image = Image(height=1, width=1, encoding="16UC1", step=2, data=big, is_bigendian=1)
    assert pixels_of(image).tolist() == [[258]]


def test_images_that_cannot_be_are_refused() -> None:
    """An unknown encoding, and too little data."""
    with pytest.raises(CommandError, match="known are"):
        pixels_of(Image(height=1, width=1, encoding="yuv422", step=2, data=b"12"))
    with pytest.raises(CommandError, match="but has 3"):
        pixels_of(Image(height=2, width=2, encoding="rgb8", step=6, data=b"123"))


@pytest.mark.parametrize(("form", "module", "extra"), [("png", "PIL", "[cli]"), ("mcap", "mcap", "[mcap]")])
def test_an_absent_package_names_the_extra(
    bag: str, tmp_path: Path, form: str, module: str, extra: str,
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    """What to install, in one sentence."""
    for name in [name for name in sys.modules if name == module or name.startswith(module + ".")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, module, None)
    if form == "png":
        with BagWriter(bag) as writer:
            writer.write("/camera", CompressedImage(format="jpeg", data=b"\xff\xd8"), 1000.0)
    assert main(["bag", "export", bag, form, "-o", str(tmp_path / "x")]) == 1
    assert f'pip install ".{extra}"' in capsys.readouterr().err


def test_png(
    bag: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file an image, named by its time, without Pillow; nothing to write is an error."""
    monkeypatch.setitem(sys.modules, "PIL", None)
    monkeypatch.setitem(sys.modules, "PIL.Image", None)
    assert main(["bag", "export", bag, "png", "-o", str(tmp_path / "out")]) == 0
    pixels = read_png((tmp_path / "out" / "camera" / "1001.250000000.png").read_bytes())
    assert pixels.shape == (2, 3, 3)
    assert pixels[0, 0].tolist() == [2, 1, 0]
    assert pixels[1, 0].tolist() == [12, 11, 10]
    assert main(["bag", "export", bag, "png", "--topics", "/odom"]) == 1
    assert "none of the topics has images" in capsys.readouterr().err


def test_depth_as_data_and_to_look_at(tmp_path: Path) -> None:
    """16-bit millimetres, the same in all pictures; --scale-depth gives each its whole range of greys."""
    path = tmp_path / "depth.bag"
    data = np.array([600, 0, 800], "<u2").tobytes()
    with BagWriter(path) as writer:
        writer.write("/depth", Image(height=1, width=3, encoding="16UC1", step=6, data=data), 1000.0)
    for words, expected in (([], [600, 0, 800]), (["--scale-depth"], [255, 0, 40])):
        out = tmp_path / f"out{len(words)}"
        assert main(["bag", "export", str(path), "png", "-o", str(out), *words]) == 0
        pixels = read_png((out / "depth" / "1000.000000000.png").read_bytes())
        assert pixels.reshape(-1).tolist() == expected


def test_a_compressed_png_is_written_as_it_is(tmp_path: Path) -> None:
    """No library is needed for what is one already."""
    picture = encode_png(np.zeros((2, 2), np.uint8))
    with BagWriter(tmp_path / "c.bag") as writer:
        writer.write("/c", CompressedImage(format="png", data=picture), 1000.0)
    assert main(["bag", "export", str(tmp_path / "c.bag"), "png", "-o", str(tmp_path / "out")]) == 0
    assert (tmp_path / "out" / "c" / "1000.000000000.png").read_bytes() == picture


def test_mcap(bag: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The ros1 profile: schema, channel with the publisher, and each message's bytes and time."""
    reader = pytest.importorskip("mcap.reader", reason="mcap is not installed (extra [mcap])")
    path = tmp_path / "run.mcap"
    assert main(["bag", "export", bag, "mcap", "-o", str(path)]) == 0
    with open(path, "rb") as file:
        found = reader.make_reader(file)
        assert found.get_header().profile == "ros1"
        messages = list(found.iter_messages(topics=["/ns/said"]))
    ((schema, channel, message),) = messages
    assert (schema.name, schema.encoding, channel.message_encoding) == ("std_msgs/String", "ros1msg", "ros1")
    assert schema.data.decode() == String._full_text
    assert channel.metadata["callerid"] == "/x"
    assert message.log_time == 1000_500_000_000
    assert message.data[4:] == b'a "b", c\nd'


@pytest.mark.parametrize("form", ["csv", "npz", "png", "mcap", "parquet"])
def test_nothing_is_replaced(bag: str, tmp_path: Path, form: str, capsys: pytest.CaptureFixture[str]) -> None:
    """As convert, filter and merge: what exists is refused, before anything is written."""
    for package in {"mcap": ["mcap"], "parquet": ["pyarrow"]}.get(form, []):
        pytest.importorskip(package)
    assert main(["bag", "export", bag, form, "--topics", "/camera"]) == 0
    made = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    assert len(made) == 2  # the bag, and what was made of it
    capsys.readouterr()
    assert main(["bag", "export", bag, form]) == 1
    assert "already exists; choose another name" in capsys.readouterr().err
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == made


@pytest.mark.parametrize(
    "words", ["convert {bag} {out}", "filter {bag} {out} True", "merge {out} {bag}", "fix {bag} {out}"]
)
def test_a_bag_is_not_replaced_either(
    bag: str, tmp_path: Path, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nor taken away, as one that could not be finished."""
    out = tmp_path / "yesterday.bag"
    out.write_bytes(b"yesterday")
    assert main(["bag", *words.format(bag=bag, out=out).split()]) == 1
    assert "already exists; choose another name" in capsys.readouterr().err
    assert out.read_bytes() == b"yesterday"


@pytest.mark.parametrize(
    ("words", "compression"),
    [
        ("convert {bag} {out}", "zstd"),
        ("convert --lz4 {bag} {out}", "lz4"),
        ("filter {bag} {out} True", "zstd"),
        ("merge {out} {bag}", "zstd"),
        ("fix {bag} {out}", "zstd"),
        ("export {bag} mcap -o {out}", "zstd"),
    ],
)
def test_mcap_is_compressed_in_one_way(bag: str, tmp_path: Path, words: str, compression: str) -> None:
    """By zstd, whichever command makes it, unless an option says otherwise."""
    pytest.importorskip("mcap", reason="mcap is not installed (extra mcap)")
    path = tmp_path / "made.mcap"
    assert main(["bag", *words.format(bag=bag, out=path).split()]) == 0
    with open_bag(path) as made:
        assert list(made.compression()) == [compression]
        assert made.message_count == 7


CLASHING = [
    "/a/b",
    "/a-b",
    "/A/B",
    "/scan",
    "/Scan",
    "/扫描",
    "/雷达",
    "/",
    "/aux",
    "/COM1",
    "/nul/",
    "/a//b",
    "/" + 300 * "x",
    "/" + 300 * "x" + "y",
]


def test_no_two_topics_share_a_file() -> None:
    """On systems that do not tell capitals, and where some names are devices; legal names keep the plain form."""
    names = file_names(CLASHING)
    assert len({name.lower() for name in names.values()}) == len(CLASHING)
    assert (names["/A/B"], names["/Scan"], names["/aux"]) == ("A-B", "Scan", "topic-aux")
    assert file_names(["/a-b", "/a/b"])["/a/b"] == "a-b"
    assert all(name.isascii() and len(name) < 180 for name in names.values())
    assert not {name.lower() for name in names.values()} & {"aux", "com1", "nul", "con"}
    assert names == file_names(reversed(CLASHING))


def test_names_that_cannot_be_told_apart_are_an_error() -> None:
    """Before anything is written: who makes a topic's name from another one's check sum."""
    other = file_names(["/a/b", "/a-b"])["/a-b"]
    with pytest.raises(CommandError, match="would be one file"):
        file_names(["/a/b", "/a-b", f"/{other.replace('-', '/')}"])


@pytest.mark.parametrize("form", ["csv", "npz"])
def test_every_topic_is_written(form: str, tmp_path: Path) -> None:
    """Eight topics whose names are alike are eight files, each with its own messages."""
    topics = CLASHING[:8]
    path = tmp_path / "alike.bag"
    with BagWriter(path) as writer:
        for number, topic in enumerate(topics):
            writer.write(topic, String(data=f"message {number}"), 1.0 + number)
    out = tmp_path / "out"
    assert main(["bag", "export", str(path), form, "-o", str(out)]) == 0
    files = sorted(p.name for p in out.iterdir())
    assert len({name.lower() for name in files}) == len(topics)
    if form == "csv":
        texts = {p.read_text("utf-8").splitlines()[1].split(",")[1] for p in out.iterdir()}
        assert texts == {f"message {number}" for number in range(len(topics))}


def test_npz_of_fields_that_numpy_has_names_for(tmp_path: Path) -> None:
    """/rosout has a field `file`; another type may have `args`, `self` or our own `receive_time`."""
    import numpy as np

    path = tmp_path / "rosout.bag"
    log = message_class("rosgraph_msgs/Log")(file="a.py", line=7)
    odd = define("a/Odd", "float64 receive_time\nint32 args\nint32 allow_pickle")
    with BagWriter(path) as writer:
        writer.write("/rosout", log, 1.0)
        writer.write("/odd", odd(receive_time=5.0, args=3), 2.0)
    assert main(["bag", "export", str(path), "npz", "-o", str(tmp_path / "out")]) == 0
    with np.load(tmp_path / "out" / "rosout.npz", allow_pickle=True) as arrays:
        assert arrays["file"].tolist() == ["a.py"]
        assert arrays["line"].tolist() == [7]
    with np.load(tmp_path / "out" / "odd.npz") as arrays:
        assert arrays["receive_time"].tolist() == [5.0]
        assert arrays["_receive_time"].tolist() == [2.0]
