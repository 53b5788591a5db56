"""The graph commands against our own nodes: forms, JSON, exit codes. Beside ROS's tools: tests/interop."""

from __future__ import annotations

import io
import json
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from xmlrpc.client import ServerProxy

import pytest

from rosproto import BagWriter, Master, Node, message_class
from rosproto.cli import echo, main
from rosproto.cli.exit_codes import CommandError
from rosproto.cli.yaml_values import load_text, value_of
from rosproto.time import Time


@pytest.fixture(scope="module")
def graph() -> Iterator[str]:
    """Master URI of a graph with a node, a latched topic, a service and parameters."""
    with Master() as master, Node("/a", master_uri=master.uri) as node:
        scans = node.publisher("/scan", "sensor_msgs/LaserScan", latch=True)
        scans.publish(ranges=[1.0, 2.0, float("inf")], angle_min=-1.0)
        node.service_server("/add", "std_srvs/SetBool", lambda r: {"success": r.data, "message": "as told"})
        node.params["/p"] = {"a": 1, "b": [True, "x"]}
        yield master.uri


@pytest.fixture
def rosproto(graph: str, capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, str, str]]:
    """`rosproto("topic list")` -> (exit code, stdout, stderr)."""

    def call(line: str, *more: str) -> tuple[int, str, str]:
        code = main([*line.split(), *more, "--master", graph])
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return call


Call = Callable[..., tuple[int, str, str]]


def test_json_of_facts(rosproto: Call) -> None:
    """Everything that prints facts prints them as JSON too."""
    _, out, _ = rosproto("topic list --json")
    assert {
        "name": "/scan",
        "type": "sensor_msgs/LaserScan",
        "publishers": ["/a"],
        "subscribers": [],
    } in json.loads(out)
    _, out, _ = rosproto("node info /a --json")
    facts = json.loads(out)
    assert facts["publications"]["/scan"] == "sensor_msgs/LaserScan"
    assert "/add" in facts["services"]
    _, out, _ = rosproto("param get /p --json")
    assert json.loads(out) == {"a": 1, "b": [True, "x"]}
    _, out, _ = rosproto("service info /add --json")
    assert json.loads(out)["args"] == ["data"]


def test_echo_forms(rosproto: Call) -> None:
    """Text, CSV, JSON with valid numbers only, fields, elements, and arrays told by size."""
    assert "ranges: [1.0, 2.0, inf]" in rosproto("topic echo -n 1 /scan")[1]
    assert rosproto("topic echo -n 1 /scan/ranges[1]")[1] == "2.0\n---\n"
    assert json.loads(rosproto("topic echo -n 1 --json /scan")[1])["ranges"] == [1.0, 2.0, None]
    assert '"<array type: float32, length: 3>"' in rosproto("topic echo -n 1 --noarr /scan")[1]
    header, row = rosproto("topic echo -n 1 -p /scan")[1].splitlines()
    assert header.startswith(
        "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.angle_min"
    )
    assert header.count(",") == row.count(",")


def test_filter_of_echo(rosproto: Call) -> None:
    """A filter that is false shows nothing; one that names no field is an error at once."""
    code, out, err = rosproto("topic echo -n 1 --timeout 0.3 /scan", "--filter", "m.angle_min > 0")
    assert (code, out) == (1, "")
    assert "no message within" in err
    code, _, err = rosproto("topic echo -n 1 /scan", "--filter", "m.angel_min < 0")
    assert code == 2
    assert "no field 'angel_min'" in err


def test_a_topic_that_does_not_exist_is_told_after_whole_seconds(
    rosproto: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    """How long it was looked for, and not by how much the computer was late."""
    told: list[str] = []

    def warn(text: str) -> None:
        told.append(text)
        if "no message" in text:
            raise KeyboardInterrupt

    monkeypatch.setattr(echo, "PATIENCE", 0.25)
    monkeypatch.setattr(echo, "warn", warn)
    assert rosproto("topic echo /nosuch")[0] == 130
    assert told[-1].startswith("/nosuch: no message within 0.25 s; nobody publishes it; still listening")


def test_pub_refuses_wrong_values_before_anything_is_sent(rosproto: Call) -> None:
    """A typing error names the field and what there is."""
    code, _, err = rosproto("topic pub -1 /cmd geometry_msgs/Twist", "{linaer: {x: 1}}")
    assert code == 2
    assert "linear, angular" in err
    code, _, err = rosproto("topic pub -1 /cmd geometry_msgs/Twits", "{}")
    assert code == 1
    assert "geometry_msgs/Twist" in err


def test_pub_at_a_rate_ends(rosproto: Call) -> None:
    """-r with -n publishes that many."""
    assert rosproto("topic pub -r 100 -n 3 /say std_msgs/String hello")[0] == 0


def test_call(rosproto: Call) -> None:
    """By position, by name, as JSON; a wrong field is refused."""
    assert "success: True" in rosproto("service call /add true")[1]
    assert json.loads(rosproto("service call --json /add", "{data: false}")[1]) == {
        "success": False,
        "message": "as told",
    }
    assert "has no field 'date'" in rosproto("service call /add", "{date: 1}")[2]


@pytest.mark.parametrize("stdin", [None, "", "---\n"])
def test_call_asks_for_the_fields_of_a_request(
    rosproto: Call, monkeypatch: pytest.MonkeyPatch, stdin: str | None
) -> None:
    """A service is not called with zeros because nobody said anything; the template can be pasted."""
    monkeypatch.setattr(sys, "stdin", None if stdin is None else io.StringIO(stdin))
    code, out, err = rosproto("service call /add")
    assert (code, out) == (2, "")
    assert "data (bool); nothing was called" in err
    assert 'rosproto service call /add "{data: false}"' in err
    assert "success: False" in rosproto("service call /add", "{data: false}")[1]


def test_parameters_to_a_file_and_back(rosproto: Call, tmp_path: Path) -> None:
    """What dump writes load reads."""
    file = tmp_path / "p.yaml"
    assert rosproto(f"param dump {file} /p")[0] == 0
    assert rosproto(f"param load {file} /copy")[0] == 0
    assert rosproto("param get /copy --json")[1] == rosproto("param get /p --json")[1]
    assert rosproto("param delete /copy")[0] == 0
    assert rosproto("param get /copy")[0] == 1
    assert rosproto("param set /n/x", "[1, {a: b, c/d: e}]")[0] == 0  # in a list it is not a namespace
    assert json.loads(rosproto("param get /n --json")[1]) == {"x": [1, {"a": "b", "c/d": "e"}]}


@pytest.fixture
def tree(rosproto: Call, tmp_path: Path) -> Iterator[Callable[[str, str], object]]:
    """`tree(file's text, rest of the line)`: load the text below /tree; what is there then."""
    assert rosproto("param set /tree", "{a: {b: 1, c: 2}, keep: 3}")[0] == 0

    def load(text: str, place: str = "/tree") -> object:
        (tmp_path / "f.yaml").write_text(text)
        code, _, err = rosproto(f"param load {tmp_path / 'f.yaml'} {place}")
        assert code == 0, err
        return json.loads(rosproto("param get /tree --json")[1])

    yield load
    rosproto("param delete /tree")


def test_load_and_set_merge_leaf_by_leaf(rosproto: Call, tree: Callable[..., object]) -> None:
    """What a file or a value does not name stays, as in rosparam."""
    assert tree("a: {b: 5}\nnew: [1]\n") == {"a": {"b": 5, "c": 2}, "keep": 3, "new": [1]}
    assert rosproto("param set /tree", "{a: {c: 7}}")[0] == 0
    assert tree("{}") == {"a": {"b": 5, "c": 7}, "keep": 3, "new": [1]}


def test_load_of_a_file_without_values_sets_nothing(rosproto: Call, tree: Callable[..., object]) -> None:
    """Only comments, or nothing at all: a warning, exit code 0, as rosparam; a launch script goes on."""
    for text in ("# later\n", "", "---\n"):
        assert tree(text) == {"a": {"b": 1, "c": 2}, "keep": 3}


def test_load_takes_namespaces_as_rosparam_does(
    rosproto: Call, tree: Callable[..., object], monkeypatch: pytest.MonkeyPatch
) -> None:
    """`_ns` and global names in a file, several documents, $ROS_NAMESPACE."""
    assert tree("_ns: in\nx: 1\n---\n_ns: /tree/a\nb: 2\n/tree/keep: 4\n---\n") == {
        "a": {"b": 2, "c": 2},
        "keep": 4,
        "in": {"x": 1},
    }
    monkeypatch.setenv("ROS_NAMESPACE", "tree")
    assert tree("keep: 5\n", "") == {"a": {"b": 2, "c": 2}, "keep": 5, "in": {"x": 1}}
    assert json.loads(rosproto("param dump --json")[1])["keep"] == 5


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("{keep: 9, 1: 2}", "1 is not a key; keys are strings"),
        ("{keep: 9, yes: 2}", "True is not a key"),
        ("{keep: 9, big: 3000000000}", "3000000000 does not fit in 32 bits"),
        ("{keep: 9, none: }", "cannot be"),
    ],
)
def test_what_cannot_be_a_parameter_is_refused_before_anything_is_set(
    rosproto: Call, tree: Callable[..., object], text: str, says: str
) -> None:
    """Exit code 2, a sentence with the name, and nothing has changed."""
    code, _, err = rosproto("param set /tree", text)
    assert code == 2
    assert says in err
    assert "bug" not in err
    assert tree("keep: 3") == {"a": {"b": 1, "c": 2}, "keep": 3}


def test_the_root_can_be_emptied(capsys: pytest.CaptureFixture[str]) -> None:
    """`param delete /` empties the parameter server, which keeps its root."""
    with Master() as master:
        assert main(["param", "set", "/a/b", "1", "--master", master.uri]) == 0
        assert main(["param", "delete", "/", "--master", master.uri]) == 0
        assert main(["param", "list", "--master", master.uri]) == 0
    assert capsys.readouterr().out == ""


def test_a_private_name_is_refused(rosproto: Call) -> None:
    """A command has no names of its own: /~x was made of it."""
    code, _, err = rosproto("param set ~x 1")
    assert code == 2
    assert "write /NODE/x" in err


def test_a_call_takes_now_and_auto(graph: str, rosproto: Call) -> None:
    """As `topic pub` and rosservice do; a whole number for a time is in nanoseconds."""
    plans: list[object] = []
    with Node("/planner", master_uri=graph) as node:
        node.service_server("/plan", "nav_msgs/GetPlan", lambda request: plans.append(request) or {})
        before = time.time()
        request = "{start: {header: auto}, goal: {header: {stamp: now}}}"
        assert rosproto("service call /plan", request)[0] == 0
        assert rosproto("service call /plan", "{start: {header: {stamp: 1500000001}}}")[0] == 0
    first, second = plans
    assert before <= first.start.header.stamp.to_sec() <= time.time()
    assert before <= first.goal.header.stamp.to_sec() <= time.time()
    assert second.start.header.stamp == Time(1, 500000001)


@pytest.mark.parametrize(
    ("command", "value", "says"),
    [
        ("topic pub -1 /n std_msgs/UInt8", "300", "300 is out of range for uint8; expected 0 to 255"),
        ("topic pub -1 /n std_msgs/Int64", "9223372036854775808", "out of range for int64"),
        ("topic pub -1 /n std_msgs/Time", "{data: {secs: -1}}", "-1 is out of range for a time"),
        ("topic pub -1 /n std_msgs/Time", "{data: {secs: 1.5}}", "1.5 is not a valid int64"),
        ("service call /add", "2.5", "2.5 is not a bool"),
        ("topic echo -b x.bag", "", "name a topic"),
    ],
)
def test_a_value_out_of_range_is_wrong_use(rosproto: Call, command: str, value: str, says: str) -> None:
    """Exit code 2, before anything is advertised or called."""
    code, _, err = rosproto(command, *([value] if value else []))
    assert code == 2
    assert says in err


def test_echo_of_a_whole_bag_needs_no_topic(rosproto: Call, tmp_path: Path) -> None:
    """`rostopic echo -b BAG -a`."""
    with BagWriter(tmp_path / "b.bag") as bag:
        bag.write("/one", message_class("std_msgs/String")("first"), 1.0)
        bag.write("/two", message_class("std_msgs/Int8")(2), 2.0)
    code, out, _ = rosproto(f"topic echo -b {tmp_path / 'b.bag'} -a")
    assert code == 0
    assert out == 'data: "first"\n---\ndata: 2\n---\n'


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    """Three messages of joints, the second without positions, recorded at 1, 2 and 3 s."""
    joints = message_class("sensor_msgs/JointState")
    with BagWriter(tmp_path / "joints.bag") as writer:
        for number, positions in enumerate(([0.5], [], [1.5]), 1):
            writer.write("/j", joints(name=["a b"], position=positions), float(number))
    return tmp_path / "joints.bag"


def test_echo_leaves_out_messages_whose_array_is_too_short(rosproto: Call, bag: Path) -> None:
    """It ended there; rostopic goes on, too."""
    code, out, err = rosproto(f"topic echo -b {bag} /j/position[0]")
    assert (code, out) == (0, "0.5\n---\n1.5\n---\n")
    assert err.count("index 0 is out of range") == 1


def test_echo_prints_rostopics_columns(rosproto: Call, bag: Path) -> None:
    """The time is that of the bag; what --noarr and --nostr leave out has no column."""
    line = f"topic echo -b {bag} /j -n 1"
    assert rosproto(f"{line} -p --noarr --nostr")[1] == (
        "%time,field.header.seq,field.header.stamp\n1000000000,0,0\n"
    )
    assert 'name: "<array type: string, length: 1>"' in rosproto(f"{line} --nostr")[1]


def test_echo_tells_refused_from_unreachable(
    rosproto: Call, graph: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A publisher that was reached, and refused, is not called unreachable."""
    with Node("/dumb", master_uri=graph) as node:
        node.master.register_publisher("/none", "std_msgs/String", node.uri)
        code, _, err = rosproto("topic echo /none --timeout 1")
    assert code == 1
    assert "its publisher is not connected" in err
    assert "cannot be reached" not in err


def test_cleanup_takes_out_the_dead(capsys: pytest.CaptureFixture[str]) -> None:
    """A node that does not answer is unregistered, a living one stays."""
    with Master() as master, Node("/alive", master_uri=master.uri) as alive:
        alive.publisher("/t", "std_msgs/String")
        from rosproto.node import MasterClient

        with MasterClient(master.uri, "/dead") as dead:
            dead.register_publisher("/t", "std_msgs/String", "http://127.0.0.1:9/")
        assert main(["node", "cleanup", "--master", master.uri]) == 0
        assert capsys.readouterr().out == "Unregistering /dead\n"
        assert alive.master.get_system_state().publishers["/t"] == ["/alive"]


def test_cleanup_leaves_what_it_cannot_know(capsys: pytest.CaptureFixture[str]) -> None:
    """A node whose host name does not resolve here may live: its silence is no answer."""
    with Master() as master, Node("/alive", master_uri=master.uri, rosout=False):
        from rosproto.node import MasterClient

        with MasterClient(master.uri, "/elsewhere") as elsewhere:
            elsewhere.register_publisher("/t", "std_msgs/String", "http://robot-xyz.invalid:9/")
            assert main(["node", "cleanup", "--master", master.uri]) == 0
            said = capsys.readouterr()
            assert said.out == ""
            assert "left alone: /elsewhere" in said.err
            assert elsewhere.get_system_state().publishers["/t"] == ["/elsewhere"]


def test_kill_asks_a_node_to_end(capsys: pytest.CaptureFixture[str]) -> None:
    """A plain node obeys a person."""
    with Master() as master, Node("/victim", master_uri=master.uri, rosout=False) as node:
        node.publisher("/t", "std_msgs/String")
        assert main(["node", "kill", "/victim", "--master", master.uri]) == 0
        assert "killed" in capsys.readouterr().out
        assert node.wait(20)


@pytest.mark.promise("never a shutdown request")
def test_kill_never_ends_a_node_that_is_only_guessed(capsys: pytest.CaptureFixture[str]) -> None:
    """A name nobody knows is taken for the master's host; another node may have that port there."""
    with Master() as master, Node("/innocent", master_uri=master.uri, rosout=False) as innocent:
        innocent.publisher("/u", "std_msgs/String")
        uri = innocent.uri.replace("127.0.0.1", "robot-7.invalid")
        assert uri != innocent.uri
        with ServerProxy(master.uri) as server:
            server.registerPublisher("/elsewhere", "/t", "std_msgs/String", uri)
        assert main(["node", "kill", "/elsewhere", "--master", master.uri]) != 0
        assert "robot-7.invalid" in capsys.readouterr().err
        assert main(["node", "ping", "/innocent", "-c", "1", "--master", master.uri]) == 0
        assert not innocent.closed


def test_no_master_is_one_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    """It names the address that was tried and what to check."""
    assert main(["topic", "list", "--master", "http://127.0.0.1:9"]) == 4
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert "127.0.0.1:9" in err


@pytest.mark.parametrize(
    ("typed", "value"),
    [
        ("5", 5),
        ("{a: [1, two]}", {"a": [1, "two"]}),
        ("a: 1", {"a": 1}),
        ("linear:\n  x: 0.5\nangular: {z: 1}", {"linear": {"x": 0.5}, "angular": {"z": 1}}),
        ("- 1\n- two", [1, "two"]),
        ("'a: 1'", "a: 1"),
        ("http://10.0.0.7:11311", "http://10.0.0.7:11311"),
        ("12:30 h", "12:30 h"),
        ("!degrees 180", pytest.approx(3.14159265)),
        ("[deg(90), rad(pi/2)]", [pytest.approx(1.57079633)] * 2),
    ],
)
def test_values_are_any_yaml_where_the_library_is(typed: str, value: object) -> None:
    """As rostopic, rosservice and rosparam read them; angles as rosparam does."""
    pytest.importorskip("yaml", reason="PyYAML is not installed (extra [cli])")
    assert value_of(typed) == value or typed.startswith("[deg")
    if typed.startswith("[deg"):  # a flow collection is read without the library: its words stay words
        assert load_text(typed, "x") == value


@pytest.mark.parametrize("typed", ["!degrees x", "- deg()", "!radians [1]", "- rad(1 / 0)", "- deg(2**9)"])
def test_what_is_no_angle_is_one_sentence(typed: str) -> None:
    """It names the place in the text."""
    pytest.importorskip("yaml", reason="PyYAML is not installed (extra [cli])")
    with pytest.raises(CommandError, match=r"x, line 1, column .*not YAML: "):
        load_text(typed, "x")


def test_without_the_library_one_line_values_work_and_others_name_the_extra(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Block YAML says what to install."""
    monkeypatch.setitem(sys.modules, "yaml", None)
    assert value_of("{a: [1, two]}") == {"a": [1, "two"]}
    assert value_of("a: 1") == "a: 1"
    with pytest.raises(CommandError, match=r"\.\[cli\]"):
        value_of("a:\n  b: 1")


def test_wrong_yaml_is_one_sentence(rosproto: Call) -> None:
    code, _, err = rosproto("param set /wrong", "a: [1")
    assert (code, err.count("\n")) == (1, 1)
    assert "line 1, column" in err


def test_both_commands_tell_their_version(capsys: pytest.CaptureFixture[str]) -> None:
    """The version that is installed, on stdout, exit code 0."""
    import rosproto
    import woosh_pure
    from woosh_pure.cli.entry import main as woosh

    for command, name in ((main, "rosproto"), (woosh, "woosh")):
        with pytest.raises(SystemExit) as end:
            command(["--version"])
        assert end.value.code == 0
        assert capsys.readouterr().out == f"{name} {rosproto.__version__}\n"
    assert woosh_pure.__version__ == rosproto.__version__


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("--master http://a:1 topic list", "topic list --master http://a:1"),
        ("--json --master=http://a:1 param get /p", "param get --json --master=http://a:1 /p"),
        ("--msg-path f topic pub /x std_msgs/Int8 -- -5", "topic pub --msg-path f /x std_msgs/Int8 -- -5"),
        ("--master http://a:1 doctor --json", "doctor --master http://a:1 --json"),
        ("--master http://a:1 run program.py", "run --master http://a:1 program.py"),
        ("--json topic", "topic --json"),
        ("topic list --json", "topic list --json"),
        ("--master", "--master"),
        ("", ""),
    ],
)
def test_options_of_the_graph_may_stand_first(typed: str, meant: str) -> None:
    """As with `woosh`, and as a shell's alias wants it."""
    from rosproto.cli.entry import behind_the_verb

    assert behind_the_verb(typed.split()) == meant.split()


def test_a_list_may_be_asked_for_with_the_master_first(
    graph: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["--master", graph, "--json", "topic", "type", "/scan"]) == 0
    assert "sensor_msgs/LaserScan" in capsys.readouterr().out


@pytest.mark.parametrize("line", ["topic list /scam", "service list /ad", "param list /q", "node list /b"])
def test_an_empty_list_says_so(rosproto: Call, line: str) -> None:
    """Silence may be a mistyped name; the exit code stays that of ROS's tools."""
    code, out, err = rosproto(line)
    assert (code, out) == (0, "")
    assert f"is called {line.split()[-1]} or lies below it" in err
    assert rosproto(" ".join(line.split()[:2]))[2] == ""
