"""A robot whose nodes announce a host name that this computer does not know: the master's address does."""

from __future__ import annotations

import json
import logging

import pytest

from rosproto.cli import main as rosproto
from rosproto.codec import service_class
from rosproto.node import Node
from tests.support import ros
from woosh_pure.cli import main as woosh

NAME = "robot-xyz.invalid"
ROBOT = f"""
import os
os.environ["ROS_HOSTNAME"] = "{NAME}"
os.environ.pop("ROS_IP", None)
import rospy
from std_msgs.msg import String
from std_srvs.srv import SetBool, SetBoolResponse
rospy.init_node("ros_interface", disable_signals=True)
rospy.Service("/set", SetBool, lambda request: SetBoolResponse(True, "done"))
for topic in ("/robot_status", "/words", "/battery"):
    rospy.Publisher(topic, String, latch=True, queue_size=1).publish("hello")
print("ready", flush=True)
rospy.spin()
"""


@pytest.fixture
def robot(any_master, genpy_packages):
    with ros.start_rospy(ROBOT, any_master, packages=genpy_packages) as process:
        process.wait_for("ready")
        yield any_master


def test_its_topics_and_services_work_and_the_log_says_why(robot, caplog):
    with caplog.at_level(logging.WARNING, "rosproto"), Node("/laptop", master_uri=robot) as node:
        assert NAME in node.master.lookup_node("/ros_interface")
        assert node.subscriber("/words", "std_msgs/String").next(timeout=20.0).data == "hello"
        assert (
            node.service_client("/set", service_class("std_srvs/SetBool")).call(data=True, timeout=20).message
            == "done"
        )
    assert len([r for r in caplog.records if NAME in r.getMessage()]) == 1


def test_a_name_given_by_hand_needs_no_guess(robot, caplog):
    with (
        caplog.at_level(logging.WARNING, "rosproto"),
        Node("/laptop", master_uri=robot, resolve={NAME: "127.0.0.1"}) as node,
    ):
        assert node.subscriber("/words", "std_msgs/String").next(timeout=20.0).data == "hello"
        assert node.hosts.unknown == []
    assert not [r for r in caplog.records if NAME in r.getMessage()]


def test_the_wrong_address_is_the_true_reason(robot, capsys, monkeypatch):
    """Nobody listens at ::1, as on a robot whose nodes run on a second computer."""
    resolve = ["--resolve", f"{NAME}=::1"]
    assert rosproto(["topic", "echo", "/words", "--timeout", "1", "--master", robot, *resolve]) == 1
    said = capsys.readouterr().err
    assert "nobody publishes" not in said
    assert "[::1]" in said
    assert woosh(["--master", robot, *resolve, "status", "--wait", "0.5"]) == 1
    said = capsys.readouterr().out
    assert "no chassis runs there" not in said
    assert "/robot_status is published at" in said
    assert "[::1]" in said
    monkeypatch.setenv("ROSPROTO_RESOLVE", f"{NAME}=127.0.0.1")
    assert rosproto(["topic", "echo", "/words", "-n", "1", "--timeout", "20", "--master", robot]) == 0
    assert "hello" in capsys.readouterr().out


def test_both_doctors_name_it_once_with_the_line_for_the_hosts_file(robot, capsys):
    assert rosproto(["doctor", "--master", robot, "--json"]) == 0
    found = [f for f in json.loads(capsys.readouterr().out) if NAME in f["text"]]
    assert len(found) == 1
    assert "answers for all of them, and is used" in found[0]["text"]
    assert f"127.0.0.1 {NAME}" in found[0]["advice"]
    assert woosh(["--master", robot, "--json", "doctor", "--listen", "0.5"]) == 1  # it is not a chassis
    findings = json.loads(capsys.readouterr().out)["findings"]
    assert [f["check"] for f in findings if f["level"] == "problem"] == ["interface"]
    assert [f["level"] for f in findings if f["check"] == "node" and NAME in f["text"]] == ["warning"]
