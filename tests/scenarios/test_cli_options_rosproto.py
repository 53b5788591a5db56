"""Every command, option and choice of `rosproto`, run for real on one graph; what is left out is named."""

from __future__ import annotations

import inspect
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest

from rosproto import BagWriter, Master, Node
from rosproto.codec import message_class
from rosproto.tf import StaticTransformBroadcaster, Transform
from rosproto.time import Time
from tests.support.options import Case, Result, covered, every_pair, leaves, offers_json, path_of, run
from tests.support.tunable import Tunable

pytestmark = pytest.mark.whole

ELSEWHERE = ("rosproto bag", "rosproto run", "rosproto bridge", "rosproto foxglove")
"""In test_cli_options_bag.py, in tests/unit/rospy, and in tests/unit/cli/test_bridge_command.py and beside it."""
DEFINITION = "float64 depth\nstring unit\n"


@pytest.fixture(scope="module")
def graph(tmp_path_factory: pytest.TempPathFactory) -> Iterator[SimpleNamespace]:
    """A graph with everything that the table below speaks of, and a folder with files."""
    folder = tmp_path_factory.mktemp("graph")
    _files(folder)
    with (
        Master() as master,
        Node("/a", master_uri=master.uri) as a,
        Node("/ns/b", master_uri=master.uri) as b,
        StaticTransformBroadcaster(a) as frames,
    ):
        frames.send(
            Transform.planar("map", "odom", 1.0, 2.0, 0.0), Transform.planar("odom", "base_link", 0.5, 0, 0)
        )
        a.publisher("/scan", "sensor_msgs/LaserScan", latch=True).publish(ranges=[1.0, 2.0, float("inf")])
        a.publisher("/name", "std_msgs/String", latch=True).publish(data="two words")
        a.service_server("/set", "std_srvs/SetBool", lambda r: {"success": r.data, "message": "as told"})
        b.service_server("/ns/reset", "std_srvs/Empty", lambda _: None)
        b.subscriber("/heard", "std_msgs/String")
        Tunable(b, "/tuned")
        log = message_class("rosgraph_msgs/Log")(
            level=4, name="/heater", msg="warm", file="oven.py", line=3, function="heat"
        )
        a.publisher("/rosout_agg", "rosgraph_msgs/Log", latch=True).publish(log)
        a.params["/p"] = {"x": 1, "text": "one\ntwo"}
        over = threading.Event()
        noise = threading.Thread(target=_publish, args=(a, over), daemon=True)
        noise.start()
        yield SimpleNamespace(uri=master.uri, folder=folder, a=a, b=b, master=master)
        over.set()
        noise.join(5.0)


def _publish(node: Node, over: threading.Event) -> None:
    """/level counts and /warm is stamped with now, at about 50 Hz."""
    from msgdefs.std_msgs.msg import Header

    level = node.publisher("/level", "std_msgs/Float64")
    warm = node.publisher("/warm", "sensor_msgs/Temperature")
    for number in range(1_000_000):
        if over.wait(0.02):
            return
        level.publish(data=float(number % 10))
        warm.publish(header=Header(stamp=Time.from_sec(time.time()), frame_id="box"), temperature=20.5)


def _files(folder: Path) -> None:
    (folder / "pkg" / "msg").mkdir(parents=True)
    (folder / "pkg" / "msg" / "Depth.msg").write_text(DEFINITION)
    (folder / "p.yaml").write_text('{"speed": 2, "turn": "fast"}')
    (folder / "size.yaml").write_text("{size: 3}")
    (folder / "bytes").write_bytes(b"\x00\x01")
    (folder / "text").write_text("first\nsecond")
    (folder / "two.json").write_text('{"data": "one"}\n---\n{"data": "two"}\n')
    with BagWriter(folder / "t.bag") as bag:
        for index in range(3):
            bag.write("/t", _string(f"word {index}"), Time(10 + index, 0))
        bag.write("/u", _string("other"), Time(13, 0))
    (folder / "part.bag").write_bytes((folder / "t.bag").read_bytes()[:-1])


def _string(text: str) -> object:
    from msgdefs.std_msgs.msg import String

    return String(data=text)


def has(*parts: str):
    """All of these are in the output."""
    return lambda result: all(part in result.out for part in parts)


def lines(*expected: str):
    """The output is exactly these lines."""
    return lambda result: result.out.splitlines() == list(expected)


def is_json(check):
    """The output is one JSON document that passes."""
    return lambda result: check(result.document)


TOPIC = [
    Case("topic list", has("/scan\n", "/level\n")),
    Case("topic list /ns --json", is_json(lambda d: all(t["name"].startswith("/ns/") for t in d))),
    Case("topic list '/sc*'", lines("/scan")),
    Case("topic list -v", has("\nPublished topics:\n", " * /scan [sensor_msgs/LaserScan] 1 publisher\n")),
    Case("topic list --publishers", lambda r: "/scan" in r.out and "/heard" not in r.out),
    Case("topic list --subscribers", lambda r: "/heard" in r.out and "/scan" not in r.out),
    Case("topic list --host", has("Host [127.0.0.1]:\n  /")),
    Case("topic list --host --json", is_json(lambda d: "/scan" in d["127.0.0.1"])),
    Case("topic list --bag {folder}/t.bag", lines("/t", "/u")),
    Case("topic list --bag {folder}/part.bag --allow-damaged", lines("/t", "/u")),
    Case("topic list /t --bag {folder}/t.bag", has("3 message(s) from ")),
    Case("topic list --verbose", has("Subscribed topics:")),
    Case("topic info scan", has("Type: sensor_msgs/LaserScan\n", " * /a (http://")),
    Case("topic info /scan --json", is_json(lambda d: d["publishers"] == ["/a"])),
    Case("topic type /scan", lines("sensor_msgs/LaserScan")),
    Case("topic type /scan/header/frame_id --json", is_json(lambda d: d["field_type"] == "string")),
    Case("topic find std_msgs/Float64", lines("/level")),
    Case("topic find std_msgs/Float64 --json", is_json(lambda d: d == ["/level"])),
    Case("topic echo /name -n 1", lines('data: "two words"', "---")),
    Case("topic echo /name -n 1 --json", is_json(lambda d: d == {"data": "two words"})),
    Case("topic echo /scan/ranges[0:2] -n 1", lines("[1.0, 2.0]", "---")),
    Case("topic echo /warm -n 1 --csv", has("%time,field.header.seq,", ",box,20.5,")),
    Case("topic echo /name -n 1 --clear", lambda r: r.out == 'data: "two words"\n---\n'),
    Case(
        "topic echo /level -n 2 --filter 'm.data > 7 and topic == \"/level\"'",
        lambda r: {"data: 8.0", "data: 9.0"} >= {*r.out.split("\n---\n")} - {""},
    ),
    Case("topic echo /scan -n 1 --noarr", has('ranges: "<array type: float32, length: 3>"')),
    Case("topic echo /name -n 1 --nostr", lines('data: "<string length: 9>"', "---")),
    Case("topic echo /warm/header/stamp -n 1 --offset --json", is_json(lambda d: d["secs"] > 1e9)),
    Case("topic echo /t --bag {folder}/t.bag", has("word 0", "word 2")),
    Case("topic echo /t --bag {folder}/part.bag --allow-damaged", has("word 0", "word 2")),
    Case("topic echo / --bag {folder}/t.bag --all --json", lambda r: len(r.out.splitlines()) == 4),
    Case(
        "topic echo /level/data /warm/temperature --plot --seconds 5 -n 20",
        has("* /level/data  ", "+ /warm/temperature  20.5", "now"),
    ),
    Case("topic echo /level/data /warm -n 1", code=2),
    Case("topic echo /level/data --plot -n 2", has("/level/data  ", "|")),
    Case("topic echo /warm/temperature -w 8 -n 1", lines("20.50000", "---")),
    Case("topic echo /nothing --timeout 0.2", lambda r: "nobody publishes it" in r.err, code=1),
    Case("topic echo '/l*' -n 1 --json", is_json(lambda d: isinstance(d["data"], float))),
    Case("topic hz /level -n 1", has("subscribed to [/level]\naverage rate: ", "std dev:")),
    Case("topic hz /level /warm -n 1 --wall-time", has("topic", "/level", "/warm", "min_delta")),
    Case("topic hz /level -n 1 --json --window 5", is_json(lambda d: d["/level"]["count"] == 4)),
    Case("topic hz /level -n 1 --filter 'm.data < 0'", has("no new messages")),
    Case("topic hz '/lev*' -n 1 --tcpnodelay", has("average rate")),
    Case("topic bw /level -n 1 --window 10", has("average: ", "window: 10")),
    Case("topic bw /level /warm -n 1 --wall-time --json", is_json(lambda d: 8 in d["/level"]["sizes"])),
    Case("topic delay /warm -n 1", has("average delay: 0.")),
    Case(
        "topic delay /warm /level -n 1", lambda r: "/level (std_msgs/Float64) has no header" in r.err, code=1
    ),
    Case(
        "topic delay /warm -n 1 --json --window 3 --wall-time --tcpnodelay",
        is_json(lambda d: d["/warm"]["count"] <= 3),
    ),
    Case(
        "topic delay /warm -n 1 --filter 'm.temperature > 99'", lambda r: r.out == "subscribed to [/warm]\n"
    ),
]
PUB = [
    (Case("topic pub /s std_msgs/String -r 50 -n 20 -- 'at a rate'"), "at a rate"),
    (Case("topic pub /s std_msgs/String --rate 50 -n 5 --latch '{{data: latched}}'"), "latched"),
    (Case("topic pub /s std_msgs/String --once once --json", is_json(lambda d: d["published"] == 1)), "once"),
    (Case("topic pub /s std_msgs/String -n 2 --file {folder}/two.json"), "two"),
    (Case("topic pub /s std_msgs/String -f - --json", is_json(lambda d: d["published"] == 2), stdin='{"data": "x"}\n---\n{"data": "y"}'), "y"),
    (Case("topic pub /s std_msgs/String", stdin="data: piped"), "piped"),
    (Case("topic pub /s std_msgs/Header auto -r 20 -n 3 -s --use-rostime", lambda r: "carries std_msgs/String" in r.err), ""),
]  # fmt: skip
NODE = [
    Case("node list", has("/a\n", "/ns/b\n")),
    Case("node list /ns", lines("/ns/b")),
    Case("node list --uris", lambda r: all(line.startswith("http://") for line in r.out.splitlines())),
    Case("node list --all --json", is_json(lambda d: {n["name"] for n in d} >= {"/a", "/ns/b"})),
    Case("node list -a", has(" \t/a\n")),
    Case(
        "node info /a",
        has("Node [/a]\n", " * /scan [sensor_msgs/LaserScan]\n", " * /set\n", f"Pid: {os.getpid()}"),
    ),
    Case("node info /a /ns/b --json", is_json(lambda d: [n["name"] for n in d] == ["/a", "/ns/b"])),
    Case("node ping /a --count 2", lambda r: r.out.count("xmlrpc reply") == 2),
    Case("node ping --all --timeout 2 --json", is_json(lambda d: all(n["answers"] == 1 for n in d))),
    Case("node cleanup --timeout 1", lines("every node answers")),
    Case("node cleanup --json", is_json(lambda d: d == [])),
    Case("node machine", lines("127.0.0.1")),
    Case("node machine 127.0.0.1 --json", is_json(lambda d: "/a" in d["127.0.0.1"])),
]
SERVICE = [
    Case("service list", has("/set\n", "/ns/reset\n")),
    Case("service list /ns --nodes", has("/ns/reset /ns/b\n")),
    Case("service list --json", is_json(lambda d: {"name": "/set", "nodes": ["/a"]} in d)),
    Case("service info /set", has("Node: /a\n", "Type: std_srvs/SetBool\nArgs: data")),
    Case("service info set --json", is_json(lambda d: d["args"] == ["data"])),
    Case("service type /set", lines("std_srvs/SetBool")),
    Case("service type /set --json", is_json(lambda d: d == "std_srvs/SetBool")),
    Case("service find std_srvs/Empty", lines("/ns/reset")),
    Case("service find std_srvs/Empty --json", is_json(lambda d: d == ["/ns/reset"])),
    Case("service node /set", lambda r: r.out == "/a\n"),
    Case("service node set --json", is_json(lambda d: d == ["/a"])),
    Case("service node /sets", code=1),
    Case("service uri /set", lambda r: r.out.startswith("rosrpc://127.0.0.1:")),
    Case("service uri /set --json", is_json(lambda d: d.startswith("rosrpc://"))),
    Case("service args /set", lines("data")),
    Case("service args /set --json", is_json(lambda d: d == ["data"])),
    Case("service call /set true", has("success: True", 'message: "as told"')),
    Case("service call /set '{{data: false}}' --json", is_json(lambda d: d["success"] is False)),
    Case(
        "service call /set",
        lambda r: r.out.count("success") == 2,
        stdin='{"data": true}\n---\n{"data": false}',
    ),
    Case("service call /set 1 --type std_srvs/SetBool --timeout 3 --wait", has("success: True")),
]
PARAM = [
    Case("param set /q '{{a: [1, two]}}'", lambda r, g: g.a.params["/q"] == {"a": [1, "two"]}),
    Case("param set /t --textfile {folder}/text", lambda r, g: g.a.params["/t"] == "first\nsecond"),
    Case("param set /b --binfile {folder}/bytes", lambda r, g: g.a.params["/b"] == b"\x00\x01"),
    Case("param set /n -", lambda r, g: g.a.params["/n"] == 5, stdin="5"),
    Case("param get /p/x", lambda r: r.out == "1\n"),
    Case("param get /p --json", is_json(lambda d: d["x"] == 1)),
    Case("param get /p --pretty", lines("text: |", "  one", "  two", "x: 1")),
    Case("param list", has("/p/x\n", "/p/text\n")),
    Case("param list /p --json", is_json(lambda d: d == ["/p/text", "/p/x"])),
    Case("param search p", lines("/p")),
    Case("param search p --json", is_json(lambda d: d == "/p")),
    Case("param dump", has("p:\n", "  x: 1\n")),
    Case(
        "param dump {folder}/out.json /p --json",
        lambda r, g: json.loads((g.folder / "out.json").read_text())["x"] == 1,
    ),
    Case(
        "param load {folder}/p.yaml /loaded",
        lambda r, g: g.a.params["/loaded"] == {"speed": 2, "turn": "fast"},
    ),
    Case("param load -", lambda r, g: g.a.params["/top"] == 7, stdin='{"top": 7}'),
    Case("param delete /loaded", lambda r, g: "/loaded" not in g.a.params),
]
DEFINITIONS = [
    *(case for kind, name, part, package in (
        ("msg", "std_msgs/Header", "uint32 seq", "std_msgs"),
        ("srv", "std_srvs/SetBool", "bool data", "std_srvs"),
        ("action", "tf2_msgs/LookupTransform", "string target_frame", "tf2_msgs"),
    ) for case in (
        Case(f"{kind} show {name}", has(part)),
        Case(f"{kind} show {name}.{kind} --raw --json", is_json(lambda d, part=part: part in d[0]["definition"])),
        Case(f"{kind} info {name.partition('/')[2]} --raw", has(f"[{name}]:\n", part)),
        Case(f"{kind} info {name} --json", is_json(lambda d, name=name: d[0]["type"] == name)),
        Case(f"{kind} list", has(f"{name}\n")),
        Case(f"{kind} list --json", is_json(lambda d, name=name: name in d)),
        Case(f"{kind} package {package}", has(f"{name}\n")),
        Case(f"{kind} package {package} --single-line", lambda r, name=name: r.out.count("\n") == 1 and name in r.out),
        Case(f"{kind} package {package} --json", is_json(lambda d, name=name: name in d)),
        Case(f"{kind} packages", has(f"{package}\n")),
        Case(f"{kind} packages -s", lambda r, package=package: r.out.count("\n") == 1 and package in r.out.split()),
        Case(f"{kind} packages --json --single-line", is_json(lambda d, package=package: package in d)),
    )),
    Case("msg show /t --bag {folder}/t.bag", lambda r: "it has: std_msgs/String" in r.err, code=1),
    Case("msg show std_msgs/String --bag {folder}/t.bag", lines("string data", "")),
    Case("msg info std_msgs/String --bag {folder}/t.bag --raw", has("string data")),
    *(Case(f"msg {verb} std_msgs/String --bag {{folder}}/part.bag --allow-damaged", has("string data"))
      for verb in ("show", "info")),
    *(Case(f"{kind} {verb} x/Y --bag {{folder}}/part.bag --allow-damaged",
           lambda r: "messages only" in r.err, code=2)
      for kind in ("srv", "action") for verb in ("show", "info")),
    *(Case(f"{kind} {verb} x/Y --bag {{folder}}/t.bag", lambda r: "messages only" in r.err, code=2)
      for kind in ("srv", "action") for verb in ("show", "info")),
    Case("msg show pkg/Depth --msg-path {folder}/pkg", lines("float64 depth", "string unit", "")),
    Case("msg info Depth --msg-path {folder}", has("[pkg/Depth]:")),
    Case("msg list --msg-path {folder}", has("pkg/Depth\n")),
    Case("msg md5 std_msgs/String", lines("992ce8a1687cec8c8bd883ec73ca41d1")),
    Case("msg md5 String --json", is_json(lambda d: d == {"std_msgs/String": "992ce8a1687cec8c8bd883ec73ca41d1"})),
    Case("srv md5 std_srvs/Empty", lines("d41d8cd98f00b204e9800998ecf8427e")),
    Case("srv md5 std_srvs/Empty --json", is_json(lambda d: list(d) == ["std_srvs/Empty"])),
    *(Case(f"{kind} {line} --msg-path {{folder}}", lambda r: r.out != "") for kind, line in (
        ("msg", "md5 pkg/Depth"), ("msg", "package pkg"), ("msg", "packages"), ("srv", "show std_srvs/Empty"),
        ("srv", "info std_srvs/Trigger"), ("srv", "list"), ("srv", "md5 std_srvs/Empty"), ("srv", "package std_srvs"),
        ("srv", "packages"), ("action", "show tf2_msgs/LookupTransform"), ("action", "info LookupTransform"),
        ("action", "list"), ("action", "package tf2_msgs"), ("action", "packages"),
    )),
]  # fmt: skip
REST = [
    Case("graph", has("/a\n  /level -> (nobody)\n")),
    Case("graph --format text --node /ns/b", has("(nobody publishes)\n  /heard -> /ns/b")),
    Case("graph --format=dot", lambda r: r.out.startswith("digraph ros {")),
    Case("graph --format svg --output {folder}/g.svg", lambda r, g: "<svg" in (g.folder / "g.svg").read_text()),
    Case("graph --format png", code=1),  # no text for a terminal
    Case("graph --format pdf", code=1),
    Case("graph --all --json", is_json(lambda d: "/rosout" in {edge["topic"] for edge in d})),
    Case("tf tree --seconds 0.4", has("map\n", "odom", "base_link")),
    Case("tf tree --seconds 0.4 --json", is_json(lambda d: d["odom"]["parent"] == "map")),
    Case("tf frames --seconds 0.4 --output {folder}/f.svg", lambda r, g: "base_link" in (g.folder / "f.svg").read_text()),
    Case("tf frames --seconds 0.4 --format text", has("odom: in map; /a, fixed\n")),
    Case("tf frames --seconds 0.4 --format dot -o {folder}/f.gv", has("wrote ")),
    Case("tf frames --seconds 0.4 --format svg -o {folder}/g.svg", has("wrote ")),
    Case("tf frames --format png -o {folder}/g.svg", code=1),
    Case("tf frames --format pdf -o {folder}/g.svg", code=1),
    Case("tf frames --seconds 0.4 --json", is_json(lambda d: d["odom"]["static"])),
    Case("tf monitor odom base_link -n 1 --every 0.4", has("base_link", "fixed")),
    Case("tf monitor -n 1 --every 0.4 --json", is_json(lambda d: [one["frame"] for one in d] == ["base_link", "odom"])),
    Case("log echo -n 1 --source --match warm --level warn", has("WARN  /heater: warm", "[oven.py:3 heat]")),
    Case("log echo -n 1 --node '/heat*' --exclude cold --timeout 5 --json", is_json(lambda d: d["level"] == "warn")),
    Case("log list /a", has("root ")),
    Case("log list a --json", is_json(lambda d: "root" in d)),
    Case("log get /a root", lambda r: r.out.strip() in ("debug", "info", "warn", "error")),
    Case("log get /a root --json", is_json(lambda d: isinstance(d, str))),
    *(Case(f"log set /a root {level}", has(f"root: {level}")) for level in ("debug", "error", "fatal", "warn", "info")),
    Case("log set /a root info --json", is_json(lambda d: d == {"logger": "root", "level": "info"})),
    Case("dynparam list", has("/tuned\n")),
    Case("dynparam list --json", is_json(lambda d: d == ["/tuned"])),
    Case("dynparam get /tuned --timeout 4", has("speed: ")),
    Case("dynparam get /tuned mode --json", is_json(lambda d: d == "slow")),
    Case("dynparam describe /tuned --timeout 4", has("speed (double")),
    Case("dynparam describe /tuned --json", is_json(lambda d: len(d) == 4)),
    Case("dynparam set /tuned size 4 --timeout 4", has("size: 4\n")),
    Case("dynparam set /tuned '{{size: 5}}' --json", is_json(lambda d: d["size"] == 5)),
    Case("dynparam dump /tuned {folder}/a.yaml --timeout 4", lambda r, g: "speed:" in (g.folder / "a.yaml").read_text()),
    Case("dynparam load /tuned {folder}/size.yaml --timeout 4", has("size: 3")),
    Case("dynparam load /tuned {folder}/size.yaml --json", is_json(lambda d: d["size"] == 3)),
    Case("tf echo map base_link -n 2 --rate 20 --timeout 3", lambda r: r.out.count("- Translation: [1.500, 2.000, 0.000]") == 2),
    Case("tf echo map base_link -n 1 --json", is_json(lambda d: d["translation"] == [1.5, 2.0, 0.0])),
    Case("doctor", has("ok      master: ")),
    Case("doctor --json", is_json(lambda d: all(f["ok"] is not False for f in d))),
    *(Case(f"completion {shell}", has("rosproto completion _words")) for shell in ("bash", "zsh", "fish", "powershell")),
]  # fmt: skip
TABLE = [*TOPIC, *NODE, *SERVICE, *PARAM, *DEFINITIONS, *REST]
WITHOUT_MASTER = ("msg", "srv", "action", "completion", "master", "run")
BY_HAND = [Case("node kill /x"), Case("node kill --all"), Case("node kill /x --json")]
"""What the last tests of this file run: it needs nodes, or processes, of its own."""
ALL = [*TABLE, *(case for case, _ in PUB), *BY_HAND]
ROSOUT = ("--no-rosout", "--rosout-log")  # one excludes the other
MASTER = [
    "--host",
    "127.0.0.1",
    "--port",
    "0",
    "--advertise",
    "localhost",
    "--allow",
    "127.0.0.1",
]


def with_master(words: list[str], uri: str, *more: str) -> list[str]:
    """Options right behind the command: what stands behind `--` is none."""
    if words[0] not in WITHOUT_MASTER:
        more = ("--master", uri, *more)
    at = 1 if words[0] in ("graph", "doctor", "completion") else 2
    return [*words[:at], *more, *words[at:]]


def checked(case: Case, result: Result, graph: object) -> None:
    """The exit code, no traceback, and what the case demands."""
    shown = f"{case.line}\n{result.out}\n{result.err}"
    assert result.code == case.code, shown
    assert "Traceback" not in result.err, shown
    takes = len(inspect.signature(case.check).parameters)
    wanted = [p for p in inspect.signature(case.check).parameters.values() if p.default is p.empty]
    assert case.check(*([result, graph][: len(wanted)] if takes else [])), shown


@pytest.mark.parametrize("case", TABLE, ids=lambda case: case.line)
def test_command(case: Case, graph: SimpleNamespace) -> None:
    """It does what it says."""
    graph.a.params["/loaded"] = {"speed": 2}
    words = case.words(folder=graph.folder)
    checked(case, run("rosproto", with_master(words, graph.uri), case.stdin), graph)


@pytest.mark.parametrize(("case", "text"), PUB, ids=[case.line for case, _ in PUB])
def test_pub(case: Case, text: str, graph: SimpleNamespace, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is published is heard."""
    monkeypatch.setattr("rosproto.cli.publish.LINGER", 0.3)
    with graph.b.subscriber("/s", "std_msgs/String", queue_size=100) as messages:
        checked(
            case, run("rosproto", with_master(case.words(folder=graph.folder), graph.uri), case.stdin), graph
        )
        if text:
            while messages.next(timeout=5.0).data != text:
                pass


def test_no_command_and_no_option_is_left_out(tmp_path: Path) -> None:
    """Every command, and every pair of one and an option, choice or optional argument, is in this file."""
    used = {("rosproto master", name) for name in (*MASTER, *ROSOUT) if name.startswith("--")}
    paths = {"rosproto master"}
    for case in ALL:
        used |= covered("rosproto", case.words(folder=tmp_path))
        paths.add(path_of("rosproto", case.words(folder=tmp_path)))
    assert sorted(pair for pair in every_pair("rosproto") - used if not pair[0].startswith(ELSEWHERE)) == []
    assert [path for path in leaves("rosproto") if path not in paths and not path.startswith(ELSEWHERE)] == []


def test_json_is_tested_wherever_it_is_offered() -> None:
    """Each command with --json has a case that reads it."""
    tested = {path_of("rosproto", case.words(folder="x")) for case in ALL if "--json" in case.line}
    quiet = {
        "rosproto param set",
        "rosproto param delete",
        "rosproto param load",
        "rosproto dynparam dump",
    }  # they print nothing
    untested = offers_json("rosproto") - tested - quiet
    assert sorted(path for path in untested if not path.startswith(ELSEWHERE)) == []


FIRST = {path_of("rosproto", case.words(folder="x")): case for case in reversed(TABLE) if case.code == 0}
"""One case of each command."""


@pytest.mark.parametrize("path", FIRST)
def test_what_every_command_takes(path: str, graph: SimpleNamespace) -> None:
    """--debug, --verbose, and with a graph --msg-path and --no-learned change nothing of what it does."""
    case = FIRST[path]
    words = case.words(folder=graph.folder)
    more = ["--debug"] if path == "rosproto topic list" else ["--debug", "--verbose"]
    if words[0] not in WITHOUT_MASTER:
        more += ["--msg-path", str(graph.folder), "--no-learned"]
    graph.a.params["/loaded"] = {"speed": 2}
    checked(case, run("rosproto", with_master(words, graph.uri, *more), case.stdin), graph)


def test_kill_one_all_and_as_json() -> None:
    """Nodes obey; an unknown one is named."""
    with Master() as master:
        for words, expected in (
            (["/x"], "killing /x\nkilled"),
            (["--all"], "killing /x"),
            (["/x", "--json"], '"killed": ["/x"]'),
        ):
            with Node("/x", master_uri=master.uri, rosout=False) as node:
                node.publisher("/t", "std_msgs/String")
                result = run("rosproto", ["node", "kill", *words, "--master", master.uri])
                assert (result.code, expected in result.out) == (0, True), result
                assert node.wait(5.0)
        assert run("rosproto", ["node", "kill", "/x", "--master", master.uri]).code == 1


@pytest.mark.skipif(sys.platform == "win32", reason="sends a POSIX signal")
@pytest.mark.parametrize("rosout", ROSOUT)
def test_master_with_every_option(rosout: str, tmp_path: Path) -> None:
    """It says its URI, answers, and ends in order."""
    file = tmp_path / "rosout.log"
    process = subprocess.Popen(
        [sys.executable, "-m", "rosproto", "master", *MASTER, rosout, *([str(file)] if rosout == "--rosout-log" else [])],
        stdout=subprocess.PIPE, text=True, cwd=Path(__file__).resolve().parents[2],
    )  # fmt: skip
    assert process.stdout is not None
    uri = process.stdout.readline().strip()
    assert uri.startswith("http://localhost:")
    assert run("rosproto", ["topic", "list", "--master", uri]).code == 0
    process.send_signal(signal.SIGTERM)
    assert process.wait(10) == 0
    process.stdout.close()
    assert file.exists() == (rosout == "--rosout-log")
