"""Every option and choice of `rosproto bag`, run for real on small bags and one graph; what is left out is named.

What the verbs mean in depth is in tests/unit/cli/test_bag_*.py; here each option must be accepted and show an effect.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace

import pytest

from msgdefs.std_msgs.msg import Float64, String
from rosproto import BagReader, BagWriter, Master, Node
from rosproto.time import Time
from tests.support.options import Case, covered, every_pair, leaves, path_of, run, run_until

pytestmark = pytest.mark.whole


@pytest.fixture(scope="module")
def graph() -> Iterator[SimpleNamespace]:
    """A node that says something fifty times a second."""
    with (
        Master() as master,
        Node("/talker", master_uri=master.uri) as node,
        Node("/ear", master_uri=master.uri) as ear,
    ):
        words = node.publisher("/words", "std_msgs/String")
        ear.subscriber("/words", "std_msgs/String")
        ear.subscriber("/w/t", "std_msgs/String")
        over = threading.Event()

        def talk() -> None:
            while not over.wait(0.02):
                words.publish(data="word")

        thread = threading.Thread(target=talk, daemon=True)
        thread.start()

        def players() -> set[str]:
            """The players that have come, with their topics."""
            topics = node.master.get_system_state().publishers.items()
            return {
                name for topic, names in topics if topic != "/rosout" for name in names if "/play" in name
            }

        yield SimpleNamespace(uri=master.uri, players=players)
        over.set()
        thread.join(5.0)


@pytest.fixture
def bags(tmp_path: Path) -> Path:
    """a.bag and b.bag with /t and /u, cut.bag and part.bag without an end, packed.bag in bz2."""
    for name, compression in (("a", "none"), ("b", "none"), ("packed", "bz2")):
        with BagWriter(tmp_path / f"{name}.bag", compression=compression) as bag:
            for number in range(4):
                bag.write("/t", String(data=f"{name} {number}"), Time(10, number * 50_000_000))
                bag.write("/u", Float64(data=float(number)), Time(10, number * 50_000_000 + 1))
    data = (tmp_path / "a.bag").read_bytes()
    (tmp_path / "cut.bag").write_bytes(data[: len(data) * 3 // 4])
    (tmp_path / "part.bag").write_bytes(data[:-1])
    (tmp_path / "out").mkdir()
    return tmp_path


def has(*parts: str):
    return lambda r, p: all(part in r.out for part in parts)


def wrote(name: str, *topics: str):
    """The bag exists and has exactly these topics."""

    def check(result: object, folder: Path) -> bool:
        with BagReader(folder / name) as bag:
            return set(bag.topics) == set(topics or ("/t", "/u"))

    return check


def files(pattern: str, count: int = 1):
    return lambda r, p: len(list(p.glob(pattern))) >= count


def has_or_asks_for(pattern: str, extra: str):
    """The file is there, or the error names what to install."""
    return lambda r, p: f".[{extra}]" in r.err or bool(list(p.glob(pattern)))


# Exit codes.
MCAP, ARROW, ROS2 = (int(find_spec(name) is None) for name in ("mcap", "pyarrow", "rosbags"))

TABLE = [
    Case("info {d}/a.bag", has("/t", "std_msgs/String")),
    Case("info {d}/a.bag --yaml --key messages", lambda r, p: r.out.strip() == "8"),
    Case("info {d}/a.bag --freq --plain", lambda r, p: "/u" in r.out and r.out.isascii()),
    Case("info {d}/a.bag --json", lambda r, p: r.document["messages"] == 8),
    Case("check {d}/a.bag", lambda r, p: True),
    Case("check {d}/a.bag --quiet --json", lambda r, p: r.document is not None),
    Case("echo {d}/a.bag /t -n 1", has('data: "a 0"')),
    Case("echo {d}/a.bag /u --csv --filter m.data>2", has(",3.0")),
    Case("echo {d}/a.bag '/*' --json --all --noarr --nostr", lambda r, p: len(r.out.splitlines()) == 8),
    Case("echo {d}/a.bag /u/data --plot --clear --offset", has("/u/data")),
    Case("echo {d}/a.bag /u/data /u/data --plot --seconds 5", has("/u/data")),
    Case("echo {d}/a.bag /u -w 6 --timeout 1 --bag {d}/b.bag", has("data: 3.0000")),
    Case("echo {d}/part.bag /t --allow-damaged", has('data: "a 0"')),
    Case("filter {d}/part.bag {d}/o.bag --allow-damaged", wrote("o.bag")),
    Case("merge {d}/o.bag {d}/part.bag {d}/b.bag --allow-damaged", wrote("o.bag")),
    Case("compress {d}/part.bag --allow-damaged", files("part.orig.bag")),
    Case("decompress {d}/part.bag --allow-damaged", files("part.orig.bag")),
    Case("convert {d}/part.bag {d}/o.bag --allow-damaged", wrote("o.bag")),
    Case("export {d}/part.bag csv -o {d}/csv --allow-damaged", files("csv/*", 2)),
    Case("filter {d}/a.bag {d}/o.bag 'm.data == \"a 1\"' --topics /t --lz4", wrote("o.bag", "/t")),
    Case("filter {d}/a.bag {d}/o.bag --exclude /u --start 0 --duration 5 --bz2 --print topic", wrote("o.bag", "/t")),
    Case("merge {d}/o.bag {d}/a.bag {d}/b.bag --lz4", wrote("o.bag")),
    Case("merge {d}/o.bag {d}/a.bag --bz2", wrote("o.bag")),
    Case("compress {d}/a.bag --output-dir {d}/out --lz4 --quiet", files("out/a.bag")),
    Case("compress {d}/a.bag --force --bz2", files("a.orig.bag")),
    Case("decompress {d}/packed.bag --output-dir {d}/out --quiet", files("out/packed.bag")),
    Case("decompress {d}/packed.bag --force", files("packed.orig.bag")),
    Case("reindex {d}/cut.bag --output-dir {d}/out --quiet", lambda r, p: True),
    Case("reindex {d}/a.bag --force", lambda r, p: True),
    Case("fix {d}/a.bag {d}/o.bag --lz4", wrote("o.bag")),
    Case("fix {d}/a.bag {d}/o.bag --bz2", wrote("o.bag")),
    Case("export {d}/a.bag csv --output {d}/csv --topics /t --fields data --quiet", files("csv/*")),
    Case("export {d}/a.bag npz -o {d}/npz --exclude /t --start 0 --duration 9", files("npz*")),
    Case("export {d}/a.bag png --scale-depth -o {d}/png", code=1),  # no images in it
    Case("export {d}/a.bag --format csv -o {d}/c", files("c/*")),
    Case("export {d}/a.bag --format npz -o {d}/n", files("n*")),
    Case("export {d}/a.bag --format png -o {d}/p", code=1),
    Case("export {d}/a.bag --format mcap -o {d}/y.mcap", has_or_asks_for("y.mcap", "mcap"), code=MCAP),
    Case("export {d}/a.bag --format parquet -o {d}/t", has_or_asks_for("t*", "arrow"), code=ARROW),
    Case("export {d}/a.bag parquet -o {d}/t.parquet --topics /t", has_or_asks_for("t.parquet", "arrow"), code=ARROW),
    Case("convert {d}/a.bag {d}/b.mcap --lz4 --quiet", has_or_asks_for("b.mcap", "mcap"), code=MCAP),
    Case("convert {d}/a.bag {d}/c.bag --bz2", files("c.bag")),
    Case("convert {d}/a.bag {d}/two --ros2", has_or_asks_for("two/*.db3", "ros2"), code=ROS2),
    Case("export {d}/a.bag mcap -o {d}/x.mcap", lambda r, p: "[mcap]" in r.err or (p / "x.mcap").exists(),
         code=0 if find_spec("mcap") else 1),
]  # fmt: skip


RECORD = [
    Case("record /words --duration 2 -O {d}/r.bag --lz4 --force --quiet --buffsize 8 --chunksize 64 --tcpnodelay",
         wrote("r.bag", "/words")),
    Case("record --all --exclude '/rosout.*' --udp --duration 2 --output-prefix {d}/p --bz2 --size 5", files("p*.bag")),
    Case("record --regex '/wor.*' --limit 3 --publish --min-space 1 --output-name {d}/r.bag", wrote("r.bag", "/words")),
    Case("record /words --duration 1 --format bag -O {d}/r.bag", wrote("r.bag", "/words")),
    Case("record /words --duration 1 --format mcap -O {d}/r.mcap", has_or_asks_for("r.mcap", "mcap"), code=MCAP),
    Case("record --node /ear --duration 2 -O {d}/r.bag --repeat-latched", wrote("r.bag", "/words")),
]  # fmt: skip
PLAY = [
    Case("play {d}/a.bag --rate 2 --start 0.01 --duration 1 --queue 10 --quiet --delay 0.1 --topics /t"),
    Case("play --bags {d}/a.bag --clock --hz 50 --immediate --skip-empty 1"),
    Case("play {d}/a.bag --topics /t --prefix /w --wait-for-subscribers", lambda r, p: True),
    Case("play {d}/part.bag --immediate --allow-damaged"),
    Case("play {d}/a.bag --rate-control-topic /words --rate-control-max-delay 1"),
]
ENDLESS = [
    Case(
        "record /words --split --duration 1 --max-splits 2 --no-repeat-latched -O {d}/s.bag", files("s*.bag")
    ),
    Case("play {d}/a.bag --loop --keep-alive"),
    Case("play {d}/a.bag --pause"),
    Case("play {d}/a.bag --keep-alive --pause-topics /u"),
]
"""They go on until somebody ends them."""


@pytest.mark.parametrize("case", TABLE, ids=lambda case: case.line)
def test_option(case: Case, bags: Path) -> None:
    """On files alone."""
    ends(case, run("rosproto", ["bag", *case.words(d=bags)]), bags)


@pytest.mark.parametrize("case", [*RECORD, *PLAY], ids=lambda case: case.line)
def test_live_option(case: Case, bags: Path, graph: SimpleNamespace) -> None:
    """With a graph."""
    verb, *words = case.words(d=bags)
    ends(case, run("rosproto", ["bag", verb, "--master", graph.uri, *words]), bags)


@pytest.mark.parametrize("case", ENDLESS, ids=lambda case: case.line)
def test_live_option_until_ctrl_c(case: Case, bags: Path, graph: SimpleNamespace) -> None:
    """Ctrl-C is an orderly end."""
    verb, *words = case.words(d=bags)
    before = graph.players()  # the master may still have that of another test, which is leaving

    def begun(_: str) -> object:
        return graph.players() - before if verb == "play" else list(bags.glob("s_*.bag"))

    result = run_until(begun, "rosproto", ["bag", verb, "--master", graph.uri, *words])
    assert result.code in (0, 130), result
    ends(Case(case.line, case.check, code=result.code), result, bags)


def ends(case: Case, result: object, folder: Path) -> None:
    shown = f"{case.line}\n{result.out}\n{result.err}"
    assert result.code == case.code, shown
    assert "Traceback" not in result.err, shown
    check = case.check if case.check.__code__.co_argcount == 2 else lambda r, p: True
    assert check(result, folder), shown


def test_no_verb_and_no_option_is_left_out() -> None:
    """Every verb, and every pair of one and an option, choice or optional argument, is in this file."""
    used: set[tuple[str, str]] = set()
    paths: set[str] = set()
    for case in [*TABLE, *RECORD, *PLAY, *ENDLESS]:
        words = ["bag", *case.words(d=".")]
        used |= covered("rosproto", words)
        paths.add(path_of("rosproto", words))
    assert sorted({p for p in every_pair("rosproto") if p[0].startswith("rosproto bag ")} - used) == []
    assert {path for path in leaves("rosproto") if path.startswith("rosproto bag ")} - paths == set()
