"""Every command that reads a bag tells on stderr that it is damaged, and ends with 1: messages may be missing."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import rosproto
from rosproto.bag import BagReader, create_bag
from rosproto.cli import bag as commands
from rosproto.cli import main
from rosproto.codec import message_class

String = message_class("std_msgs/String")
TELLS = "messages may be missing"

Words = Callable[[str, Path], list[str]]
READING: dict[str, Words] = {
    "bag echo": lambda bag, to: [bag, "/said"],
    "bag filter": lambda bag, to: [bag, str(to / "new.bag"), "--topics", "/said"],
    "bag merge": lambda bag, to: [str(to / "new.bag"), bag, bag],
    "bag convert": lambda bag, to: [bag, str(to / "new.bag")],
    "bag compress": lambda bag, to: [bag, "--lz4", "-q"],
    "bag decompress": lambda bag, to: [bag, "--output-dir", str(to / "new")],
    "bag export": lambda bag, to: [bag, "csv", "-q", "-o", str(to / "new")],
    "bag play": lambda bag, to: [bag, "-i", "-q", "-d", "0"],
    "topic echo": lambda bag, to: ["/said", "-b", bag, "-n", "1"],
    "topic list": lambda bag, to: ["-b", bag],
    "msg show": lambda bag, to: ["std_msgs/String", "--bag", bag],
}
"""Commands that take the messages of a bag, and their words."""
OTHERS = {
    "info": "reports, damage too",
    "check": "reports, and its exit code is the answer",
    "record": "reads none",
    "reindex": "mends, and prints what was wrong",
    "fix": "saves what is left, and prints what was wrong",
}


CASES = [(verb, "bag") for verb in READING]
CASES += [(verb, "mcap") for verb in READING if not verb.endswith("compress")]  # which are for bags alone


def damaged(form: str, folder: Path) -> str:
    """A recording of 1000 messages, cut off in the middle."""
    if form == "mcap":
        pytest.importorskip("mcap", reason="mcap is not installed (extra mcap)")
    path = folder / f"run.{form}"
    with create_bag(path, "lz4", 500) as writer:
        for i in range(1000):
            writer.write("/said", String(data=f"number {i}"), 1000.0 + i / 10000)
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    return str(path)


@pytest.fixture
def master(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """For what publishes."""
    with rosproto.Master(port=0) as running:
        monkeypatch.setenv("ROS_MASTER_URI", running.uri)
        yield


def test_no_verb_is_forgotten() -> None:
    """A new verb of `rosproto bag` belongs to one list or the other."""
    ours = {name.partition(" ")[2] for name in READING if name.startswith("bag ")}
    assert ours | OTHERS.keys() == set(commands.VERBS)
    assert not ours & OTHERS.keys()


@pytest.mark.usefixtures("master")
@pytest.mark.parametrize(("verb", "form"), CASES)
def test_what_is_cut_off_is_told_and_the_exit_code_is_1(
    verb: str, form: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One sentence for each bag, and the command does what it can."""
    bag = damaged(form, tmp_path)
    words = [*verb.split(), *READING[verb](bag, tmp_path)]
    assert main(words) == 1
    told = [line for line in capsys.readouterr().err.splitlines() if TELLS in line]
    assert len(told) == words.count(bag)
    assert bag in told[0]
    assert "--allow-damaged" in told[0]


@pytest.mark.usefixtures("master")
@pytest.mark.parametrize(("verb", "form"), CASES)
def test_damage_that_is_allowed_is_told_and_the_exit_code_is_0(
    verb: str, form: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """With --allow-damaged."""
    bag = damaged(form, tmp_path)
    assert main([*verb.split(), *READING[verb](bag, tmp_path), "--allow-damaged"]) == 0
    assert TELLS in capsys.readouterr().err


@pytest.mark.parametrize("form", ["bag", "mcap"])
def test_the_messages_that_can_be_read_are_written(form: str, tmp_path: Path) -> None:
    """The new file holds them, and is sound."""
    assert main(["bag", "convert", damaged(form, tmp_path), str(tmp_path / "new.bag")]) == 1
    with BagReader(tmp_path / "new.bag") as bag:
        assert 0 < bag.message_count < 1000
        assert bag.damage == []


@pytest.mark.parametrize("form", ["bag", "mcap"])
def test_info_reports_and_succeeds(form: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What is wrong with a bag is a fact about it."""
    bag = damaged(form, tmp_path)
    assert main(["bag", "info", "--json", bag]) == 0
    found = capsys.readouterr()
    assert json.loads(found.out)["messages"] < 1000
    assert bag in found.err


def test_a_sound_bag_is_not_told_of(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """And the exit code stays 0."""
    path = tmp_path / "run.bag"
    with create_bag(path) as writer:
        writer.write("/said", String(data="here"), 1000.0)
    assert main(["bag", "convert", str(path), str(tmp_path / "new.bag")]) == 0
    assert TELLS not in capsys.readouterr().err
