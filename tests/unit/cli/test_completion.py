"""Completion: what may stand at the end of a line, and the scripts that ask for it."""

from __future__ import annotations

import os
import re
import select
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

import rosproto
from rosproto.cli import main as rosproto_main
from rosproto.cli.completion import FILES, SHELLS, script
from woosh_pure.cli import main as woosh_main

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(autouse=True)
def alone(monkeypatch, tmp_path):
    """No master, and nobody's own marks."""
    monkeypatch.setenv("ROS_MASTER_URI", "http://127.0.0.1:1")
    monkeypatch.setenv("WOOSH_CONFIG_DIR", str(tmp_path))


@pytest.fixture
def offers(capsys):
    def ask(prog: str, *words: str) -> list[str]:
        run = {"rosproto": rosproto_main, "woosh": woosh_main}[prog]
        assert run(["completion", "_words", *(f"={word}" for word in words)]) in (0, FILES)
        return capsys.readouterr().out.split()

    return ask


def test_commands(offers) -> None:
    assert offers("rosproto", "to") == ["topic"]
    assert {"watch", "drive", "map"} <= set(offers("woosh", ""))
    assert offers("woosh", "--sim", "wat") == ["watch"]
    assert offers("woosh", "--chassis", "goto", "wat") == ["watch"]
    assert offers("woosh", "nonsense", "x") == []


def test_verbs_of_a_command(offers) -> None:
    assert offers("rosproto", "topic", "ec") == ["echo"]
    assert offers("woosh", "map", "") == ["save", "set", "show"]
    assert offers("woosh", "task", "c") == ["cancel", "carry", "charge"]


def test_options_where_they_belong(offers) -> None:
    assert offers("woosh", "battery", "--be") == ["--below"]
    assert "--depth" in offers("woosh", "camera", "--")
    assert "--load" in offers("woosh", "task", "carry", "A1", "-")
    assert offers("woosh", "--chas") == ["--chassis"]
    assert "--rate" in offers("rosproto", "topic", "pub", "--ra")


def test_values_of_options_and_arguments(offers) -> None:
    assert offers("woosh", "led", "--strip", "") == ["base", "both", "shelf"]
    assert offers("woosh", "led", "--strip", "both", "--mod") == ["--module"]
    assert offers("woosh", "mode", "w") == ["wait-then-avoid"]
    assert offers("woosh", "costmap", "o") == ["off", "on"]
    assert offers("woosh", "completion", "") == sorted(SHELLS)
    assert offers("woosh", "goto", "--pose", "1", "2", "3", "--time") == ["--timeout"]
    assert offers("woosh", "battery", "--wait", "") == []


def test_marks_come_from_the_users_file(offers) -> None:
    assert offers("woosh", "goto", "") == []
    for name in ("A1", "A2", "B1"):
        assert woosh_main(["marks", "add", name, "--no-pose"]) == 0
    assert offers("woosh", "goto", "A")[-2:] == ["A1", "A2"]
    assert offers("woosh", "charge", "B") == ["B1"]
    assert offers("woosh", "task", "pick", "A1", "") == []


def test_topics_nodes_services_come_from_the_master(offers) -> None:
    with rosproto.Master() as master, rosproto.Node("/talker", master_uri=master.uri) as node:
        node.publisher("/odd/topic", "std_msgs/String")
        at = ("--master", master.uri)
        assert offers("rosproto", "topic", "echo", *at, "/odd") == ["/odd/topic"]
        assert offers("rosproto", "node", "ping", *at, "/") == ["/talker"]
        assert "/talker/get_loggers" in offers("rosproto", "service", "info", *at, "/talker/")
    assert offers("rosproto", "topic", "echo", *at, "/odd") == []


def test_a_light_strip_is_offered_states_and_colours_and_no_files(offers) -> None:
    assert "idle" in offers("woosh", "led", "")
    assert {"red", "green", "orange"} <= set(offers("woosh", "led", "--color", ""))
    for words in (["led", "idle", ""], ["battery", "--below", ""], ["say", ""], ["nonsense", ""]):
        assert woosh_main(["completion", "_words", *(f"={word}" for word in words)]) == 0
    for words in (["scan", "--png", ""], ["map", "set", ""], ["map", "save", ""]):
        assert woosh_main(["completion", "_words", *(f"={word}" for word in words)]) == FILES
    for words in (["bag", "info", ""], ["run", ""], ["graph", "-o", ""], ["topic", "pub", "-f", ""]):
        assert rosproto_main(["completion", "_words", *(f"={word}" for word in words)]) == FILES, words


def test_a_message_is_offered_as_a_template(capsys, offers) -> None:
    """As rostopic does it: the type of the topic, then all fields; what is offered can be published."""

    def line(*words: str) -> str:
        assert rosproto_main(["completion", "_words", *(f"={word}" for word in words)]) in (0, FILES)
        return capsys.readouterr().out.strip()

    with rosproto.Master() as master, rosproto.Node("/listener", master_uri=master.uri) as node:
        at = ("--master", master.uri)
        node.subscriber("/way", "geometry_msgs/Twist")
        node.service_server("/lamp", "std_srvs/SetBool", lambda request: (True, ""))
        node.service_server("/reset", "std_srvs/Empty", lambda request: None)
        assert line("topic", "pub", *at, "/way", "") == "geometry_msgs/Twist"
        assert line("topic", "pub", *at, "way", "geo") == "geometry_msgs/Twist"
        twist = line("topic", "pub", *at, "/way", "geometry_msgs/Twist", "")
        assert twist == "{linear: {x: 0.0, y: 0.0, z: 0.0}, angular: {x: 0.0, y: 0.0, z: 0.0}}"
        assert line("topic", "pub", *at, "/way", "geometry_msgs/Twist", "'{lin") == twist
        assert line("topic", "pub", *at, "/way", "geometry_msgs/Twist", twist, "") == ""
        assert line("service", "call", *at, "/lamp", "") == "{data: false}"
        assert line("service", "call", *at, "/reset", "") == ""
    stamped = line("topic", "pub", "/p", "geometry_msgs/PoseStamped", "")
    assert stamped.startswith('{header: {seq: 0, stamp: now, frame_id: ""}, pose: {position: {x: 0.0')
    assert line("topic", "pub", "/p", "no_msgs/Such", "") == ""
    assert "std_msgs/String" in offers("rosproto", "topic", "pub", "/new", "std_msgs/")


@pytest.mark.parametrize(
    "kind", ["nav_msgs/Odometry", "sensor_msgs/Image", "tf2_msgs/TFMessage", "std_msgs/Time"]
)
def test_what_is_offered_can_be_published(kind: str) -> None:
    from rosproto.cli.completion import template
    from rosproto.cli.yaml_values import value_of
    from rosproto.codec.dicts import from_dict

    cls = rosproto.message_class(kind)
    text = template(cls)
    assert "'" not in text, "it stands in such quotes"
    message = from_dict(cls, value_of(text), now=rosproto.Time(7, 0))
    if kind == "std_msgs/Time":
        assert message == cls()
    elif hasattr(message, "header"):
        assert message.header.stamp.secs == 7


def test_types_come_from_the_definitions(offers) -> None:
    assert offers("rosproto", "msg", "show", "std_msgs/Stri") == ["std_msgs/String"]
    assert "std_srvs/SetBool" in offers("rosproto", "srv", "show", "std_srvs/")


@pytest.mark.parametrize("shell", SHELLS)
def test_each_script_names_its_command_and_how_to_install_it(shell, capsys) -> None:
    for prog, run in (("rosproto", rosproto_main), ("woosh", woosh_main)):
        assert run(["completion", shell]) == 0
        text = capsys.readouterr().out
        assert text == script(prog, shell)
        assert f"{prog} completion {shell}" in "\n".join(text.splitlines()[:2])
        assert f"{prog} completion _words" in text


@pytest.mark.skipif(sys.platform == "win32" or shutil.which("bash") is None, reason="needs bash")
def test_bash_quotes_a_template_and_offers_no_files(tmp_path) -> None:
    """What has blanks comes in quotes; where no file can stand, bash's own names of files stay away."""
    command = tmp_path / "rosproto"
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m rosproto "$@"\n')
    command.chmod(0o755)
    line = 'COMP_LINE="{}"; COMP_POINT=${{#COMP_LINE}}; _rosproto_complete; '
    ask = (
        'eval "$(rosproto completion bash)"; compopt() { echo "no files"; }; '
        + line.format("rosproto topic pub /x std_msgs/Bool ")
        + 'printf "%s\\n" "${COMPREPLY[@]}"; '
        + line.format("rosproto bag info ")
    )
    done = subprocess.run(
        ["bash", "-c", ask],
        env={**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}", "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.stdout.splitlines() == ["no files", "'{data: false}'"], done.stderr


@pytest.mark.skipif(sys.platform == "win32" or shutil.which("bash") is None, reason="needs bash")
def test_bash_completes(tmp_path) -> None:
    """Really in bash: with the command in the path, as after an installation."""
    command = tmp_path / "woosh"
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m woosh_pure "$@"\n')
    command.chmod(0o755)
    ask = (
        'eval "$(woosh completion bash)"; '
        'COMP_LINE="woosh --master http://10.0.0.7:11311 led --strip b"; COMP_POINT=${#COMP_LINE}; '
        '_woosh_complete; printf "%s\\n" "${COMPREPLY[@]}"; '
        'COMP_LINE="woosh map "; COMP_POINT=${#COMP_LINE}; _woosh_complete; printf "%s\\n" "${COMPREPLY[@]}"'
    )
    done = subprocess.run(
        ["bash", "-c", ask],
        env={**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}", "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.stderr == ""
    assert done.stdout.split() == ["base", "both", "save", "set", "show"]


@pytest.fixture
def installed(tmp_path) -> dict[str, str]:
    """An environment with `woosh` and `rosproto` in the path, as after an installation, and an empty home."""
    for name, module in (("woosh", "woosh_pure"), ("rosproto", "rosproto")):
        command = tmp_path / name
        command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m {module} "$@"\n')
        command.chmod(0o755)
    path = f"{tmp_path}:{os.environ['PATH']}"
    return {**os.environ, "PATH": path, "PYTHONPATH": str(ROOT), "HOME": str(tmp_path), "TERM": "xterm"}


@pytest.mark.skipif(shutil.which("fish") is None, reason="fish is not installed")
def test_fish_completes(installed, tmp_path) -> None:
    """By fish's own engine, from the file that the first line of the script names."""
    folder = tmp_path / ".config" / "fish" / "completions"
    folder.mkdir(parents=True)
    for prog in ("woosh", "rosproto"):
        (folder / f"{prog}.fish").write_text(script(prog, "fish"))
    environment = {**installed, "XDG_CONFIG_HOME": str(tmp_path / ".config")}
    for typed, expected in (
        ("woosh map ", ["save", "set", "show"]),
        ("woosh --master http://10.0.0.7:11311 led --strip b", ["base", "both"]),
        ("rosproto topic ec", ["echo"]),
        ("woosh battery --be", ["--below"]),
    ):
        done = subprocess.run(
            ["fish", "-c", f"complete -C '{typed}'"],
            env=environment, capture_output=True, text=True, timeout=60, check=False,
        )  # fmt: skip
        assert [line.split("\t")[0] for line in done.stdout.split()] == expected, (typed, done)


@pytest.mark.skipif(shutil.which("zsh") is None, reason="zsh is not installed")
def test_zsh_completes_when_tab_is_pressed(installed, tmp_path) -> None:
    """In an interactive zsh on a pseudo-terminal: what one press of Tab makes of the line is what is run."""
    with open(tmp_path / ".zshrc", "w") as rc:
        rc.write('autoload -Uz compinit; compinit -u -d "$HOME/.zcompdump"; PS1="ready> "\n')
        rc.write('eval "$(woosh completion zsh)"; eval "$(rosproto completion zsh)"\n')
    with _Zsh({**installed, "ZDOTDIR": str(tmp_path)}) as zsh:
        zsh.wait_for("ready> ")
        zsh.send("woosh map sa\t")
        zsh.wait_for("woosh map save ")
        zsh.send("\x15rosproto topic ech\t")
        zsh.wait_for("rosproto topic echo ")
        zsh.send("\x15woosh --master http://10.0.0.7:11311 led --strip sh\t")
        zsh.wait_for("led --strip shelf")


class _Zsh:
    """An interactive zsh on a pseudo-terminal."""

    def __init__(self, environment: dict[str, str]) -> None:
        import pty

        self._master, slave = pty.openpty()
        self._process = subprocess.Popen(
            ["zsh", "-i"], stdin=slave, stdout=slave, stderr=slave, env=environment, start_new_session=True
        )
        os.close(slave)
        self._seen = ""

    def __enter__(self) -> _Zsh:
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.wait(10)
        os.close(self._master)

    def send(self, keys: str) -> None:
        """Press keys; what was seen before is forgotten."""
        self._seen = ""
        os.write(self._master, keys.encode())

    def wait_for(self, text: str, timeout: float = 30.0) -> None:
        """Wait until it has been printed; escape sequences do not count."""
        end = time.monotonic() + timeout
        while text not in re.sub(r"\x1b\[[\d;?]*[A-Za-z]|\x1b[=>]|.\x08", "", self._seen):
            assert time.monotonic() < end, f"{text!r} did not come: {self._seen!r}"
            if select.select([self._master], [], [], 0.1)[0]:
                self._seen += os.read(self._master, 4096).decode("utf-8", "replace")


@pytest.mark.skipif(shutil.which("pwsh") is None, reason="PowerShell is not installed")
@pytest.mark.parametrize(
    ("line", "cursor", "found"),
    [
        ("woosh map s", 11, ["save", "set", "show"]),
        ("woosh map ", 10, ["save", "set", "show"]),
        ("woosh map s --json", 11, ["save", "set", "show"]),  # in the middle of the line
        ("woosh 'map' s", 13, ["save", "set", "show"]),
        ("cd .; woosh map s", 17, ["save", "set", "show"]),
        ("woosh map set --jso", 19, ["--json"]),
    ],
)
def test_powershell_completes(installed, line: str, cursor: int, found: list[str]) -> None:
    """By PowerShell's own engine."""
    typed = line.replace("'", "''")
    code = (
        "woosh completion powershell | Out-String | Invoke-Expression; "
        f"(TabExpansion2 '{typed}' {cursor}).CompletionMatches.CompletionText"
    )
    done = subprocess.run(
        ["pwsh", "-NoProfile", "-Command", code],
        env=installed,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.stdout.split() == found
