"""MCAP and bags beside the readers that others have: @mcap/core in JavaScript, rosbags in Python."""

from __future__ import annotations

import hashlib
import json
import sys
from pathlib import Path

import pytest

from rosproto.bag import BagReader, BagWriter
from rosproto.cli import main
from rosproto.codec import encode, message_class
from rosproto.time import Time
from tests.support import web_peers

pytest.importorskip("mcap", reason="mcap is not installed (extra mcap)")

String = message_class("std_msgs/String")
LaserScan = message_class("sensor_msgs/LaserScan")

CORE = """
import { readFileSync } from "node:fs";
import { createHash } from "node:crypto";
import { createRequire } from "node:module";
import { execFileSync } from "node:child_process";
const require = createRequire(%(package)s);
const { McapIndexedReader, McapStreamReader } = require("@mcap/core");
const bytes = new Uint8Array(readFileSync(%(path)s));
const unpack = "import sys, zstandard; sys.stdout.buffer.write(zstandard.decompress(sys.stdin.buffer.read()))";
const decompressHandlers = { zstd: (input) => new Uint8Array(execFileSync(%(python)s, ["-c", unpack], { input })) };
const show = (channel, schema, m) => say(channel.topic, schema.name, schema.encoding, channel.messageEncoding,
  Object.fromEntries(channel.metadata), String(m.logTime), createHash("md5").update(m.data).digest("hex"));
if (%(indexed)s) {
  const readable = { size: async () => BigInt(bytes.length),
    read: async (offset, length) => bytes.subarray(Number(offset), Number(offset + length)) };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
  say("profile", reader.header.profile, String(reader.statistics.messageCount));
  for await (const m of reader.readMessages()) {
    const channel = reader.channelsById.get(m.channelId);
    show(channel, reader.schemasById.get(channel.schemaId), m);
  }
} else {
  const reader = new McapStreamReader({ validateCrcs: true, decompressHandlers });
  reader.append(bytes);
  const channels = new Map(), schemas = new Map();
  for (let r; (r = reader.nextRecord()); ) {
    if (r.type === "Schema") schemas.set(r.id, r);
    if (r.type === "Channel") channels.set(r.id, r);
    if (r.type === "Message") { const c = channels.get(r.channelId); show(c, schemas.get(c.schemaId), r); }
  }
  say("end", reader.done());
}
"""


def a_bag(path: Path) -> list[tuple[str, str, str]]:
    """Topic, time and digest of each message, in the order of time."""
    expected = []
    with BagWriter(path, "lz4", 4000) as bag:
        for i in range(200):
            for topic, message in (
                ("/said", String(data=f"text {i}")),
                ("/scan", LaserScan(ranges=[1.0] * i)),
            ):
                stamp = Time(1000 + i, len(topic))
                bag.write(topic, message, stamp, header={"callerid": "/robot", "latching": "1"})
                digest = hashlib.md5(encode(message)).hexdigest()
                expected.append((topic, str(stamp.to_nsec()), digest))
    return expected


def told_by_core(path: Path, *, indexed: bool) -> list[list[object]]:
    package = web_peers.npm_module("@mcap/core/package.json")
    facts = {
        "package": json.dumps(str(package)),
        "path": json.dumps(str(path)),
        "indexed": json.dumps(indexed),
        "python": json.dumps(sys.executable),
    }
    import subprocess

    program = "const say = (...values) => console.log(JSON.stringify(values));\n" + CORE % facts
    done = subprocess.run(
        ["node", "--input-type=module", "-e", program],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return [json.loads(line) for line in done.stdout.splitlines()]


@pytest.mark.parametrize("indexed", [True, False])
def test_mcap_core_reads_what_is_converted(tmp_path: Path, indexed: bool) -> None:
    """Topic, type, encodings, header, time and bytes of every message; zstd is unpacked for it."""
    expected = a_bag(tmp_path / "a.bag")
    assert main(["bag", "convert", str(tmp_path / "a.bag"), str(tmp_path / "a.mcap")]) == 0
    told = told_by_core(tmp_path / "a.mcap", indexed=indexed)
    facts = [line for line in told if line[0] not in ("profile", "end")]
    assert [(line[0], line[5], line[6]) for line in facts] == expected
    assert {(line[1], line[2], line[3]) for line in facts} == {
        ("std_msgs/String", "ros1msg", "ros1"), ("sensor_msgs/LaserScan", "ros1msg", "ros1"),
    }  # fmt: skip
    assert all(line[4]["callerid"] == "/robot" and line[4]["latching"] == "1" for line in facts)
    assert ["profile", "ros1", "400"] in told or ["end", True] in told


def test_rosbags_reads_what_comes_back(tmp_path: Path) -> None:
    """A bag that went through MCAP, message by message."""
    rosbag1 = pytest.importorskip("rosbags.rosbag1", reason="rosbags is not installed")
    expected = a_bag(tmp_path / "a.bag")
    assert main(["bag", "convert", str(tmp_path / "a.bag"), str(tmp_path / "a.mcap")]) == 0
    assert main(["bag", "convert", str(tmp_path / "a.mcap"), str(tmp_path / "b.bag")]) == 0
    with rosbag1.Reader(tmp_path / "b.bag") as theirs:
        found = [(c.topic, str(t), hashlib.md5(data).hexdigest()) for c, t, data in theirs.messages()]
    assert found == expected
    with BagReader(tmp_path / "b.bag") as bag:
        assert [
            (t, str(s.to_nsec()), hashlib.md5(r.data).hexdigest()) for t, r, s in bag.read_messages(raw=True)
        ] == expected


@pytest.mark.parametrize("compression", ["none", "lz4"])
def test_the_package_of_its_makers_reads_what_is_converted(tmp_path: Path, compression: str) -> None:
    """By its index and as a stream, checksums included: each message, its channel, schema and times."""
    from mcap.reader import NonSeekingReader, SeekingReader

    expected = a_bag(tmp_path / "a.bag")
    options = [] if compression == "none" else [f"--{compression}"]
    assert main(["bag", "convert", str(tmp_path / "a.bag"), str(tmp_path / "a.mcap"), *options]) == 0
    for make in (SeekingReader, NonSeekingReader):
        with open(tmp_path / "a.mcap", "rb") as file:
            reader = make(file, validate_crcs=True)
            told = list(reader.iter_messages(log_time_order=True))
        assert [(c.topic, str(m.log_time), hashlib.md5(m.data).hexdigest()) for _, c, m in told] == expected
        assert all(m.publish_time == m.log_time for _, _, m in told)
        assert {(s.name, s.encoding, c.message_encoding) for s, c, _ in told} == {
            ("std_msgs/String", "ros1msg", "ros1"), ("sensor_msgs/LaserScan", "ros1msg", "ros1"),
        }  # fmt: skip
        assert all(c.metadata["callerid"] == "/robot" and c.metadata["latching"] == "1" for _, c, _ in told)
        assert {s.data.decode() for s, c, _ in told if c.topic == "/scan"} == {LaserScan._full_text}
