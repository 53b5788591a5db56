"""The self-test: each check detects a fault, and one that hangs is ended."""

from __future__ import annotations

import subprocess
import sys
import threading
from pathlib import Path

import pytest

from rosproto.bag import BagWriter
from rosproto.codec import reference
from rosproto.errors import RosTimeout
from rosproto.master import registry
from rosproto.node.services.client import ServiceClient
from rosproto.selftest import CHECKS, Check, CheckFailed, NotApplicable, State, computing, nodes, run
from woosh_pure.selftest import CHECKS as ALL
from woosh_pure.sim.site import Site, built_in_site


def outcome_of(name: str) -> tuple[State, str]:
    (check,) = [check for check in ALL if check.name == name]
    (outcome,) = run([check])
    assert outcome.name == name
    assert outcome.seconds >= 0
    return outcome.state, outcome.text


@pytest.mark.parametrize("name", [check.name for check in CHECKS if check.name != "ros"])
def test_each_check_passes_here(name: str) -> None:
    state, text = outcome_of(name)
    assert state is State.FINE, text


def test_the_chassis_has_its_table() -> None:
    assert outcome_of("chassis")[0] is State.FINE


def test_a_changed_definition_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """A wrong md5sum, a type that is not there, one that is not known."""
    right = list(computing.known_md5sums())
    for table, words in (
        ([("0" * 8, *right[0][1:]), *right[1:]], "has md5sum"),
        ([*right, ("0" * 8, "msg", "nobody/Knows")], "nobody/Knows"),
        (right[1:], "is not known"),
    ):
        monkeypatch.setattr(computing, "known_md5sums", lambda table=table: iter(table))
        state, text = outcome_of("definitions")
        assert state is State.FAILED
        assert "1 of" in text
        assert words in text


def test_a_codec_that_writes_other_bytes_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    usual = reference.encode_layout
    monkeypatch.setattr(
        reference,
        "encode_layout",
        lambda layout, value: usual(layout, value)[:-1] + b"\xee" * bool(layout.fields),
    )
    assert outcome_of("codec")[0] is State.FAILED


def test_a_master_that_forgets_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry.Registry, "topic_types", lambda self: registry.Answer(1, "", []))
    state, text = outcome_of("master")
    assert state is State.FAILED
    assert text.startswith("the topics: received {}")


def test_nodes_that_do_not_answer_are_found(monkeypatch: pytest.MonkeyPatch) -> None:
    def silent(*_: object, **__: object) -> None:
        raise RosTimeout("nothing came")

    monkeypatch.setattr(ServiceClient, "call", silent)
    assert outcome_of("nodes") == (State.FAILED, "RosTimeout: nothing came")


def test_a_bag_that_loses_messages_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    usual = BagWriter.write

    def forgetful(self: BagWriter, topic: str, message: object, t: float) -> None:
        if t != 1007.0:
            usual(self, topic, message, t)

    monkeypatch.setattr(BagWriter, "write", forgetful)
    state, text = outcome_of("bag")
    assert state is State.FAILED
    assert text.startswith("none: texts")


def test_a_robot_that_does_not_arrive_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without its mark the task is refused."""
    from woosh_pure.sim import world

    hall = built_in_site()
    monkeypatch.setattr(world, "built_in_site", lambda: Site(hall.grid, {}, hall.start))
    state, text = outcome_of("drive")
    assert state is State.FAILED
    assert "A1" in text


def test_without_ros_there_is_nothing_to_check(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(nodes, "find_ros", lambda: None)
    state, text = outcome_of("ros")
    assert state is State.NOT_HERE
    assert "no rospy" in text


@pytest.mark.skipif(sys.flags.ignore_environment, reason="CPython for embedding takes no PYTHONPATH")
def test_a_broken_ros_is_told_with_its_words(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "rospy.py").write_text("raise RuntimeError('this ROS is broken')\n")
    monkeypatch.setattr(nodes, "find_ros", lambda: (sys.executable, {"PYTHONPATH": str(tmp_path)}))
    monkeypatch.setattr(nodes, "_PATIENCE", 2.0)
    state, text = outcome_of("ros")
    assert state is State.FAILED
    assert "this ROS is broken" in text


def test_what_hangs_is_ended_and_what_is_wrong_becomes_a_sentence() -> None:
    hold = threading.Event()

    def hang() -> str:
        hold.wait(20.0)
        return ""

    def fail(error: Exception) -> str:
        raise error

    checks = [
        Check("hangs", hang),
        Check("fails", lambda: fail(CheckFailed("seen: a, expected b"))),
        Check("breaks", lambda: fail(KeyError("x"))),
        Check("absent", lambda: fail(NotApplicable("nothing there"))),
        Check("works", lambda: "shown"),
    ]
    found = [(o.state, o.text) for o in run(checks, limit=0.5)]
    hold.set()
    assert found == [
        (State.FAILED, "it did not end within 0.5 s"),
        (State.FAILED, "seen: a, expected b"),
        (State.FAILED, "KeyError: 'x'"),
        (State.NOT_HERE, "nothing there"),
        (State.FINE, "shown"),
    ]


@pytest.mark.whole
@pytest.mark.timeout(330)  # twenty times what it takes: it computes, and promises no time
def test_no_test_tool_is_needed() -> None:
    """pytest and hypothesis are not imported; an installation has none."""
    code = (
        "import sys\nfor name in ('pytest', 'hypothesis', 'tests'): sys.modules[name] = None\n"
        "from rosproto.selftest import CHECKS, State, run\n"
        "assert [o.state for o in run(c for c in CHECKS if c.name != 'ros')] == [State.FINE] * 5"
    )
    root = Path(__file__).resolve().parents[3]
    done = subprocess.run([sys.executable, "-c", code], cwd=root, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
