"""Definitions of the user's own, and learned ones, in the commands."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosproto import Master, Node
from rosproto.cli import main
from rosproto.codec import define, service_class
from rosproto.msg import bundled


def package(folder: Path, service: str) -> Path:
    """A folder with my_msgs/Ask."""
    place = folder / "my_msgs" / "srv"
    place.mkdir(parents=True)
    (place / "Ask.srv").write_text(service)
    return folder


@pytest.mark.promise("`--no-learned` and `Chassis(learned=False)` do not use what was learned")
@pytest.mark.parametrize("how", ["given", "learned", "left out"])
def test_a_service_of_another_revision_is_called(
    how: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """--msg-path, and what was learned, give the definition; --no-learned does without."""
    home = {"given": "elsewhere", "learned": "home", "left out": "home"}[how]
    for variable in ("XDG_DATA_HOME", "LOCALAPPDATA", "HOME"):
        monkeypatch.setenv(variable, str(tmp_path / home))
    from rosproto.msg.user_folder import revisions_folder

    mine = package(tmp_path / "mine", "int32 a\n---\nint32 b\n")
    kept = revisions_folder() / "robot-1" if how != "given" else tmp_path / "robots"
    theirs = service_class("my_msgs/Ask", bundled().fork([package(kept, "int64 a\n---\nint64 b\n")]))
    options = {"given": ["--msg-path", str(kept)], "learned": [], "left out": ["--no-learned"]}[how]
    with (
        Master() as master,
        Node("/robot", master_uri=master.uri, rosout=False) as robot,
        robot.service_server("/ask", theirs, lambda request: {"b": request.a + 1}),
    ):
        words = [
            "service",
            "call",
            "/ask",
            "{a: 1}",
            "--master",
            master.uri,
            "--msg-path",
            str(mine),
            *options,
        ]
        code = main(words)
    said = capsys.readouterr()
    if how == "left out":
        assert code != 0
        assert "woosh learn" in said.err
    else:
        assert (code, said.out.strip()) == (0, "b: 2")


def note(folder: Path, type_name: str, text: str) -> None:
    """A folder with one message."""
    package_name, _, base = type_name.partition("/")
    place = folder / package_name / "msg"
    place.mkdir(parents=True, exist_ok=True)
    (place / f"{base}.msg").write_text(text)


@pytest.mark.promise("Your own folders and the bundled definitions take precedence")
@pytest.mark.slow
@pytest.mark.parametrize("type_name", ["my_msgs/Note", "std_msgs/String"])
@pytest.mark.parametrize("how", ["environment", "given"])
def test_the_users_own_come_first_everywhere(
    type_name: str,
    how: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """What a robot has sent replaces neither the user's own type nor a bundled one; show and pub agree."""
    for variable in ("XDG_DATA_HOME", "LOCALAPPDATA", "HOME"):
        monkeypatch.setenv(variable, str(tmp_path / "home"))
    from rosproto.msg.user_folder import revisions_folder

    note(tmp_path / "mine", type_name, "string mine\n")
    note(revisions_folder() / "a-robot", type_name, "string theirs\n")
    note(revisions_folder() / "a-robot", "robot_msgs/Only", "string learned\n")
    options = ["--msg-path", str(tmp_path / "mine")] if how == "given" else []
    if how == "environment":
        monkeypatch.setenv("ROSPROTO_MSG_PATH", str(tmp_path / "mine"))

    def said(*words: str) -> str:
        assert main([*words]) == 0
        return capsys.readouterr().out

    def published(master: Master, name: str, values: str, *options: str) -> str:
        """The definition under which `topic pub` publishes."""
        with (
            Node("/ear", master_uri=master.uri, rosout=False) as node,
            node.subscriber("/t", raw=True) as ear,
        ):
            pub = ["topic", "pub", "-1", "/t", name, values, "--master", master.uri, *options]
            assert main(pub) == 0
            capsys.readouterr()
            return str(ear.next(20)._connection_header["message_definition"]).strip()

    with Master() as master:
        assert published(master, type_name, "{mine: x}", *options) == "string mine"
    assert said("msg", "show", type_name, *options).strip() == "string mine"
    assert said("msg", "show", "robot_msgs/Only", *options).strip() == "string learned"
    ours = define(type_name, "string mine\n")._md5sum
    assert said("msg", "md5", type_name, *options).strip() == ours
    monkeypatch.delenv("ROSPROTO_MSG_PATH", raising=False)
    shown = said("msg", "show", type_name).strip()
    assert shown == ("string data" if type_name == "std_msgs/String" else "string theirs")


def test_every_command_reads_by_the_users_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """`topic pub`, `topic echo`, `topic type`, `service call`, `service args`, `msg show` and the bag verbs agree
    with `Node(msg_path=)`, for a message and a service that are bundled under the same names.
    """
    monkeypatch.setenv("ROSPROTO_MSG_PATH", str(tmp_path / "mine"))
    note(tmp_path / "mine", "std_msgs/String", "Inner mine\n")
    note(tmp_path / "mine", "std_msgs/Inner", "string deep\n")
    (tmp_path / "mine" / "std_srvs" / "srv").mkdir(parents=True)
    (tmp_path / "mine" / "std_srvs" / "srv" / "SetBool.srv").write_text("int8 mine\n---\nint8 answer\n")

    def said(*words: str) -> str:
        assert main([*words]) == 0, capsys.readouterr()
        return capsys.readouterr().out.strip()

    with (
        Master() as master,
        Node("/n", master_uri=master.uri, rosout=False, msg_path=[tmp_path / "mine"]) as node,
        node.publisher("/t", "std_msgs/String", latch=True) as publisher,
        node.service_server("/s", "std_srvs/SetBool", lambda r: {"answer": r.mine + 1}),
        node.subscriber("/u", "std_msgs/String") as heard,
    ):
        message = publisher.message_class()
        message.mine.deep = "x"
        publisher.publish(message)
        graph = ("--master", master.uri)
        assert said("topic", "echo", "-n", "1", "/t", *graph).startswith('mine: \n  deep: "x"')
        assert said("topic", "type", "/t/mine/deep", *graph) == "std_msgs/String mine/deep string"
        assert said("service", "args", "/s", *graph) == "mine"
        assert "mine" in said("service", "info", "/s", *graph)
        assert said("service", "call", "/s", "{mine: 1}", *graph) == "answer: 2"
        said("topic", "pub", "-1", "/u", "std_msgs/String", "{mine: {deep: y}}", *graph)
        assert heard.next(timeout=10).mine.deep == "y"
        bag = str(tmp_path / "own.bag")
        said("bag", "record", "-O", bag, "--limit", "1", "/t", *graph)
    assert "deep" in said("bag", "echo", bag, "/t")
    assert "mine" in said("msg", "show", "std_msgs/String")
    said("bag", "check", bag)
