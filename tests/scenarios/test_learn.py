"""`woosh learn`: what a robot speaks that nobody here knew, kept, and used from then on."""

from __future__ import annotations

import json
from argparse import ArgumentParser
from io import StringIO
from pathlib import Path
from typing import Any

import pytest

from rosproto import Master, Node
from rosproto.codec import define, message_class, service_class
from rosproto.errors import DefinitionError
from rosproto.msg import bundled, library_from_full_text, parse_service
from rosproto.msg.user_folder import learned_paths
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.cli.commands import add_arguments, run
from woosh_pure.cli.output import Output
from woosh_pure.firmware.learn import KnownDefinitions, compare, make_sets, write_set
from woosh_pure.firmware.survey import SurveyAnswer, survey

FUTURE_BATTERY = "uint16 cells\n" + bundled().message("woosh_msgs/Battery").text.replace(
    "uint8 batteryPercentage", "uint32 batteryPercentage"
)


def learn(uri: str, folder: Path, *more: str) -> dict[str, Any]:
    """Run the command; its document."""
    parser, stream = ArgumentParser(), StringIO()
    add_arguments("learn", parser)
    common = {
        "chassis": None,
        "sim": False,
        "sim_speed": None,
        "host": None,
        "msg_path": None,
        "no_learned": False,
        "api_address": None,
    }
    parser.set_defaults(master=uri, **common)
    args = parser.parse_args(["--folder", str(folder), *more])
    assert run("learn", args, Output(as_json=True, stream=stream)) == 0
    document: dict[str, Any] = json.loads(stream.getvalue())
    return document


def of(document: dict[str, Any], name: str) -> dict[str, Any]:
    """The finding about one topic or service."""
    found: dict[str, Any] = next(f for f in document["findings"] if f["name"] == name)
    return found


def future(name: str, text: str) -> Any:
    """A class of a definition that nobody bundled."""
    used = bundled().fork()
    from rosproto.msg import parse_message

    used.add(parse_message(text, name))
    return define(name, used.full_text(name))


@pytest.mark.parametrize("firmware", ["1.1.4", "1.0.8", "page"])
def test_a_robot_of_a_known_firmware_teaches_nothing(firmware: str, tmp_path: Path) -> None:
    """Every topic and service answers, goal topics too; each is a bundled definition or a known revision."""
    with SimulatedChassis(firmware=firmware) as sim:
        document = learn(sim.master_uri, tmp_path / "kept")
        topics = {
            topic for topic, _ in sim.graph.nodes["/ros_interface"].master.get_published_topics().items()
        }
    assert document["written"] == []
    assert not (tmp_path / "kept").exists()
    assert {f["verdict"] for f in document["findings"]} <= {"bundled", "revision"}
    assert {f["name"] for f in document["findings"] if f["kind"] == "topic"} >= topics - {"/rosout"}
    goal, task = of(document, "/navigation_mode/goal"), of(document, "/exec_task")
    if firmware == "1.1.4":
        assert (goal["verdict"], goal["differences"]) == ("bundled", [])
    if firmware == "1.0.8":
        assert (goal["verdict"], goal["source"]) == ("revision", "1.0.8")
        assert goal["differences"] == [
            "woosh_msgs/NavigationModeGoal: capacity (uint32): not on the robot",
            "woosh_msgs/NavigationModeGoal: nav_dir (uint32): not on the robot",
        ]
        assert task["verdict"] == "bundled"
    if firmware == "page":
        assert (task["verdict"], task["source"]) == ("revision", "page")
        assert task["differences"] == [
            "woosh_msgs/ExecTaskRequest: task_exect is spelled task_exec on the robot",
            "woosh_msgs/ExecTaskResponse: statusCode is spelled statuscode on the robot",
        ]
        assert any("another order" in line for line in of(document, "/battery")["differences"])


@pytest.mark.promise("one new folder for each set; no existing file is replaced")
def test_what_is_new_is_kept_once_and_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A field of a future firmware: learned from its publisher, then known to a client that never met it."""
    future_battery = future("woosh_msgs/Battery", FUTURE_BATTERY)
    with (
        Master() as master,
        Node("/robot", master_uri=master.uri, rosout=False, intraprocess=False) as robot,
        robot.publisher("/battery", future_battery, latch=True) as publisher,
    ):
        publisher.publish(batteryPercentage=77, cells=8)
        monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
        monkeypatch.setenv("LOCALAPPDATA", str(tmp_path))
        monkeypatch.setenv("HOME", str(tmp_path))
        from rosproto.msg.user_folder import revisions_folder

        folder = revisions_folder()
        dry = learn(master.uri, folder, "--dry-run")
        assert (of(dry, "/battery")["verdict"], dry["written"]) == ("new", [])
        assert not folder.exists()
        first = learn(master.uri, folder)
        assert of(first, "/battery")["differences"] == [
            "woosh_msgs/Battery: batteryPercentage: uint8 here, uint32 on the robot",
            "woosh_msgs/Battery: cells (uint16): only on the robot",
        ]
        assert learned_paths() == [Path(path) for path in first["written"]]
        assert [p.name for p in folder.iterdir()] == [Path(first["written"][0]).name]
        again = learn(master.uri, folder)
        assert (of(again, "/battery")["verdict"], again["written"]) == ("folder", [])
        for learned in (True, False):
            with Chassis(master.uri, learned=learned) as chassis:
                found = chassis.node.definitions.message(
                    message_class("woosh_msgs/Battery"), future_battery._md5sum
                )
                assert (found is not None) is learned
                assert chassis.battery.wait(5.0).percent == 77


@pytest.mark.promise("one new folder for each set; no existing file is replaced")
def test_contradicting_definitions_go_into_different_sets(tmp_path: Path) -> None:
    """Two nodes of one robot with different revisions: each set is consistent in itself, and both are found."""
    texts = ["uint8 a\n", "uint16 a\n", "uint8 A\n"]
    libraries = [library_from_full_text("my_msgs/Note", text) for text in texts]
    sets = make_sets([*(("my_msgs/Note", library) for library in libraries), ("my_msgs/Note", libraries[0])])
    assert len(sets) == 3
    paths = [write_set(learned, tmp_path, "169.254.128.2") for learned in sets]
    assert paths == [write_set(learned, tmp_path, "169.254.128.2") for learned in sets]
    assert sorted(paths) == learned_paths(tmp_path)
    knowledge = KnownDefinitions(paths)
    for library, path in zip(libraries, paths, strict=True):
        found = knowledge.find("msg", "my_msgs/Note", library.md5sum("my_msgs/Note"))
        assert found is not None
        assert found[:2] == ("folder", str(path))


def test_names_that_differ_in_case_only_are_kept_apart() -> None:
    """They would be one file on Windows and macOS."""
    pairs = [(name, library_from_full_text(name, "uint8 a\n")) for name in ("my_msgs/Note", "my_msgs/note")]
    assert [list(learned.texts) for learned in make_sets(pairs)] == [["my_msgs/Note"], ["my_msgs/note"]]


@pytest.mark.promise("a type whose name is not a valid file name is left out")
def test_a_type_no_file_can_be_named_after_is_left_out_and_told(tmp_path: Path) -> None:
    """Reserved on Windows, or longer than any file name; the others are kept all the same."""
    long = "m/" + "L" * 253
    names = ["aux/Foo", "my_msgs/Con", long, "my_msgs/Fine"]
    with Master() as master, Node("/robot", master_uri=master.uri, rosout=False) as robot:
        for number, name in enumerate(names):
            robot.publisher(f"/topic{number}", define(name, "uint8 a\n"))
        used = "my_msgs/User"
        robot.publisher("/user", define(used, "aux/Foo foo\n" + "=" * 80 + "\nMSG: aux/Foo\nuint8 a\n"))
        document = learn(master.uri, tmp_path / "kept")
    assert sorted(document["skipped"]) == sorted(["aux/Foo", "my_msgs/Con", long, used])
    (path,) = document["written"]
    assert [found.name for found in Path(path).rglob("*.msg")] == ["Fine.msg"]


@pytest.mark.promise("have the announced md5sum, before and after it is written")
def test_a_set_that_cannot_be_written_leaves_nothing(tmp_path: Path) -> None:
    """A name Windows reserves is refused everywhere, and no half-written folder stays."""
    (learned,) = make_sets([("my_msgs/Aux", library_from_full_text("my_msgs/Aux", "uint8 a\n"))])
    with pytest.raises(DefinitionError, match="every system"):
        write_set(learned, tmp_path, "robot")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.promise("have the announced md5sum, before and after it is written")
@pytest.mark.parametrize(
    ("definition", "md5sum", "words"),
    [
        ("uint8 a", "0" * 32, "but the definition it sent has"),
        ("this is not a definition", "0" * 32, "cannot be used"),
        ("", "0" * 32, "but the definition it sent has"),
        ("../../evil a", "0" * 32, "cannot be used"),
    ],
)
def test_a_lie_is_not_learned(definition: str, md5sum: str, words: str) -> None:
    """A text counts only when it can be parsed and has the md5sum that was announced."""
    finding = compare(SurveyAnswer("topic", "/t", "my_msgs/T", md5sum, definition), KnownDefinitions())
    assert finding.verdict == "unusable"
    assert words in finding.note


@pytest.mark.promise("so none leads out of that folder")
@pytest.mark.parametrize(
    "name", ["../../evil/T", "../T", "a/../T", "/etc/T", "a\\b/T", "a/T\x00", "C:/T", "~/T", "a/b/c"]
)
def test_no_name_leads_out_of_the_folder(name: str) -> None:
    """What is not a ROS name of a type is not learned, however well its text and md5sum agree."""
    md5sum = define("my_msgs/T", "uint8 a")._md5sum
    assert (
        compare(SurveyAnswer("topic", "/t", "my_msgs/T", md5sum, "uint8 a"), KnownDefinitions()).verdict
        == "new"
    )
    assert (
        compare(SurveyAnswer("topic", "/t", name, md5sum, "uint8 a"), KnownDefinitions()).verdict
        == "unusable"
    )


@pytest.mark.promise("`--dry-run` writes nothing")
def test_a_dry_run_writes_nothing(tmp_path: Path) -> None:
    """And says what would be kept."""
    with Master() as master, Node("/robot", master_uri=master.uri, rosout=False) as robot:
        robot.publisher("/my_state", define("my_msgs/State", "uint8 mood"))
        document = learn(master.uri, tmp_path / "kept", "--dry-run")
    assert of(document, "/my_state")["verdict"] == "new"
    assert not (tmp_path / "kept").exists()


def test_services_tell_no_text_so_the_vendors_is_asked_for(tmp_path: Path) -> None:
    """An unknown md5sum of a known type, and a type nobody knows."""
    library = bundled().fork()
    library.add(parse_service("uint8 task_exect\nuint8 speed\n---\nbool success\n", "woosh_msgs/ExecTask"))
    library.add(parse_service("---\n", "my_msgs/Ask"))
    with (
        Master() as master,
        Node("/robot", master_uri=master.uri, rosout=False) as robot,
        robot.service_server("/exec_task", service_class("woosh_msgs/ExecTask", library), lambda r: None),
        robot.service_server("/ask", service_class("my_msgs/Ask", library), lambda r: None),
    ):
        document = learn(master.uri, tmp_path)
    assert of(document, "/exec_task")["verdict"] == "unknown"
    assert "woosh_msgs/srv/ExecTask.srv is needed" in of(document, "/exec_task")["note"]
    assert "my_msgs/srv/Ask.srv is needed" in of(document, "/ask")["note"]


def test_a_silent_peer_costs_its_time_only() -> None:
    """A registered node that nobody runs any more is told, and the others are asked all the same."""
    with (
        Master() as master,
        Node("/robot", master_uri=master.uri, rosout=False) as robot,
        Node("/asker", master_uri=master.uri, rosout=False) as asker,
    ):
        robot.publisher("/here", "std_msgs/String")
        from rosproto.node import MasterClient

        with MasterClient(master.uri, "/gone") as gone:
            for topic in ("/lost", "/here"):
                gone.register_publisher(topic, "std_msgs/String", "http://127.0.0.1:9/")
        answers = {answer.name: answer for answer in survey(asker, timeout=10.0)}
    assert answers["/here"].type == "std_msgs/String"
    assert "127.0.0.1:9" in answers["/lost"].error


def test_the_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As typed: a table of what differs, and in words what would be kept."""
    from woosh_pure.cli import main

    for variable in ("XDG_DATA_HOME", "LOCALAPPDATA", "HOME"):
        monkeypatch.setenv(variable, str(tmp_path))
    with SimulatedChassis(firmware="page", full_graph=False) as sim:
        extra = sim.graph.nodes["/ros_interface"].publisher(
            "/my_state", define("my_msgs/State", "uint8 mood")
        )
        assert main(["--master", sim.master_uri, "learn"]) == 0
        extra.close()
    said = capsys.readouterr().out
    assert "/battery" in said
    assert "known revision page" in said
    assert "woosh_msgs/Parameter: pulsePerCircle: uint32 here, float32 on the robot" in said
    assert "my_msgs/State: not bundled" in said
    assert "kept my_msgs/State in " in said
    assert [path.name for path in learned_paths()] == ["127.0.0.1-" + learned_paths()[0].name[-8:]]
    assert "/odometer" not in said
