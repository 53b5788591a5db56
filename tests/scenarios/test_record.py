"""`woosh record` on the simulated chassis, and its bag played back to a program that reads a chassis."""

from __future__ import annotations

import json
import os
import sys
import threading

import pytest

import rosproto
import rosproto.cli
from rosproto.bag import BagReader
from rosproto.recording import Player
from woosh_pure.cli import main
from woosh_pure.interface.recorded_topics import HEAVY, selection_of
from woosh_pure.interface.table import find, topics


@pytest.mark.slow
def test_the_chassis_in_one_file(sim, tmp_path, capsys):
    """What the table has, as it is published; no pictures; the summary names every topic."""
    # All links stand by then, on a busy computer and under Wine too, and the topic of one message a second has come.
    seconds = "12" if sys.platform == "win32" else "5"
    words = [
        "--master",
        sim.master_uri,
        "record",
        "--duration",
        seconds,
        "-o",
        str(tmp_path / "run"),
        "--json",
    ]
    assert main(words) == 0
    found = json.loads(capsys.readouterr().out)
    (name,) = os.listdir(tmp_path)
    assert name.startswith("run_20")
    assert found["files"][0]["path"] == str(tmp_path / name)
    assert found["dropped"] == 0
    assert found["silent"] == []
    with BagReader(tmp_path / name) as bag:
        assert bag.damage == []
        assert set(bag.compression()) == {"lz4"}
        assert {"/battery", "/movebase_pose2d", "/scan", "/tf", "/move_base/status"} <= set(bag.topics)
        kinds = {topic: known.types[0] for topic, known in bag.topics.items()}
        assert not HEAVY & set(kinds.values())
        for row in topics("read"):
            assert kinds.get(row.name, row.type) == row.type
        assert len(list(bag.read_messages())) == sum(found["topics"].values())


def test_pose_and_battery_cannot_be_left_out(sim, tmp_path, capsys):
    """Not even by excluding everything."""
    words = [
        "--master",
        sim.master_uri,
        "record",
        "-x",
        ".*",
        "-O",
        str(tmp_path / "run.bag"),
        "--duration",
        "4",
    ]
    assert main(words) == 0
    with BagReader(tmp_path / "run.bag") as bag:
        assert set(bag.topics) == {"/battery", "/movebase_pose2d"}
    assert "/battery" in capsys.readouterr().out


def test_a_graph_without_a_chassis_is_told(tmp_path, capsys):
    """No pose, no battery: exit code 1 and what to do; the bag is whole all the same."""
    with rosproto.Master() as master:
        words = ["--master", master.uri, "record", "--duration", "0.3", "-O", str(tmp_path / "run.bag")]
        assert main(words) == 1
    out = capsys.readouterr().out
    assert "/movebase_pose2d, /battery" in out
    assert "woosh doctor" in out
    with BagReader(tmp_path / "run.bag") as bag:
        assert bag.message_count == 0


def test_a_recording_that_cannot_be_read_whole_is_told(tmp_path, capsys, monkeypatch):
    """What the disk lost at the end is found when the summary is made."""
    path = tmp_path / "run.bag"
    follow = rosproto.cli.follow_recording

    def cut_off(recorder, **options):
        code = follow(recorder, **options)
        path.write_bytes(path.read_bytes()[:-1])
        return code

    monkeypatch.setattr(rosproto.cli, "follow_recording", cut_off)
    with rosproto.Master() as master:
        words = ["--master", master.uri, "record", "--duration", "0.3", "-O", str(path), "--json"]
        assert main(words) == 1
    assert json.loads(capsys.readouterr().out)["damage"]


def test_the_choice_of_topics():
    """Cameras only when asked for, commands and actions always, other nodes' topics only by name or --all."""
    chosen = selection_of(["mine"])
    camera = find("camera").name
    for topic in (
        "/mine",
        "/battery",
        "/base_cmd_vel",
        "/move_base/goal",
        "/woosh_auto_dock/feedback",
        "/tf",
    ):
        assert chosen.takes(topic), topic
    for topic in (camera, "/somebody/elses", "/batteryX"):
        assert not chosen.takes(topic), topic
    assert selection_of(camera=True).takes(camera)
    assert selection_of(all=True, exclude=["/x"]).takes("/somebody/elses")
    assert not selection_of(all=True, exclude=["/x"]).takes("/x")


def test_a_recorded_run_feeds_a_program_that_reads_a_chassis(sim, tmp_path):
    """Played to another master, the pose and battery feeds of `Chassis` give what was recorded."""
    from woosh_pure import Chassis

    path = tmp_path / "run.bag"
    assert main(["--master", sim.master_uri, "record", "--duration", "4", "-q", "-O", str(path)]) == 0
    with (
        rosproto.Master() as master,
        rosproto.Node("/player", master_uri=master.uri) as node,
        BagReader(path) as bag,
        Player(node, bag, loop=True) as player,
    ):
        recorded = {(m.x, m.y) for _, m, _ in bag.read_messages("/movebase_pose2d")}
        thread = threading.Thread(target=player.play, daemon=True)
        thread.start()
        with Chassis(master.uri) as chassis:
            battery = chassis.battery.wait(timeout=10.0)
            pose = chassis.pose.wait(timeout=10.0)
        player.stop()
        thread.join(5.0)
    assert (pose.x, pose.y) in recorded
    assert 0 < battery.percent <= 100
