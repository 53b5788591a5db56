"""`rosproto bag export BAG parquet`: files that others read, whole or not there at all."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosproto.bag import BagWriter
from rosproto.cli import main
from rosproto.cli.bag_progress import Progress
from rosproto.codec import message_class

parquet = pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed (extra arrow)")

Odometry = message_class("nav_msgs/Odometry")
LaserScan = message_class("sensor_msgs/LaserScan")


@pytest.fixture
def bag(tmp_path: Path) -> str:
    path = tmp_path / "run.bag"
    with BagWriter(path, "lz4") as writer:
        for i in range(20):
            odometry = Odometry()
            odometry.pose.pose.position.x = i / 2
            odometry.header.frame_id = "odom"
            writer.write("/odom", odometry, 1000.0 + i)
            writer.write("/ns/scan", LaserScan(ranges=[float(i)] * i), 1000.5 + i)
    return str(path)


def test_a_file_a_topic(bag: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Named as CSV files are, and nothing is left beside them."""
    assert main(["bag", "export", bag, "parquet", "-o", str(tmp_path / "out")]) == 0
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == ["ns-scan.parquet", "odom.parquet"]
    assert str(tmp_path / "out" / "odom.parquet") in capsys.readouterr().out
    table = parquet.read_table(tmp_path / "out" / "ns-scan.parquet")
    assert table["ranges"].to_pylist()[3] == [3.0, 3.0, 3.0]
    assert table.schema.metadata[b"type"] == b"sensor_msgs/LaserScan"


def test_one_file_of_some_fields_and_a_span(bag: str, tmp_path: Path) -> None:
    """The form as an option, the output as a file."""
    out = tmp_path / "odom.parquet"
    line = (
        f"bag export --format parquet --topics /odom -o {out} -s 2 -u 3 {bag} --fields pose.pose.position.x"
    )
    assert main(line.split()) == 0
    table = parquet.read_table(out)
    assert table.schema.names == ["receive_time", "pose.pose.position.x"]
    assert table["pose.pose.position.x"].to_pylist() == [1.0, 1.5, 2.0, 2.5]


def test_pandas_polars_and_duckdb_read_it(bag: str, tmp_path: Path) -> None:
    """The same rows each."""
    out = tmp_path / "odom.parquet"
    assert main(["bag", "export", bag, "parquet", "--topics", "/odom", "-o", str(out)]) == 0
    wanted = [i / 2 for i in range(20)]
    pandas = pytest.importorskip("pandas")
    frame = pandas.read_parquet(out)
    assert [row["pose"]["position"]["x"] for row in frame["pose"]] == wanted
    assert str(frame["receive_time"].dtype) == "datetime64[ns, UTC]"
    polars = pytest.importorskip("polars")
    column = polars.read_parquet(out)["pose"].struct.field("pose").struct.field("position").struct.field("x")
    assert column.to_list() == wanted
    duckdb = pytest.importorskip("duckdb")
    rows = duckdb.sql(
        f"select pose.pose.position.x, header.frame_id from '{out}' order by receive_time"
    ).fetchall()
    assert rows == [(x, "odom") for x in wanted]


def test_two_topics_do_not_fit_one_file(bag: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The sentence says what to do."""
    assert main(["bag", "export", bag, "parquet", "-o", str(tmp_path / "x.parquet")]) != 0
    assert "choose one with --topics" in capsys.readouterr().err


@pytest.mark.parametrize("words", [[], ["csv", "--format", "csv"]])
def test_one_form_is_named(bag: str, words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """None or two are refused."""
    assert main(["bag", "export", bag, *words]) != 0
    assert "name one format" in capsys.readouterr().err


def test_what_fails_leaves_nothing(bag: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A bag with damage in its last chunk: a sentence, and no file."""
    out = tmp_path / "odom.parquet"
    data = bytearray(Path(bag).read_bytes())
    at = data.index(b"\x04\x22\x4d\x18")
    data[at + 40] ^= 0xFF
    Path(bag).write_bytes(data)
    assert main(["bag", "export", bag, "parquet", "--topics", "/odom", "-o", str(out)]) != 0
    assert "chunk at byte" in capsys.readouterr().err
    assert sorted(p.name for p in tmp_path.iterdir()) == ["run.bag"]


def test_the_bar_counts_messages_as_chunks_are_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A batch may be all of a topic: a bar that counted those would stand still."""
    path = tmp_path / "chunks.bag"
    steps: list[int] = []
    with BagWriter(path, chunk_bytes=1000) as writer:
        for i in range(50):
            writer.write("/scan", LaserScan(ranges=[1.0] * 300), 1000.0 + i)
    monkeypatch.setattr(Progress, "step", lambda self, count=1: steps.append(count))
    assert main(["bag", "export", str(path), "parquet"]) == 0
    assert steps == [1] * 50
