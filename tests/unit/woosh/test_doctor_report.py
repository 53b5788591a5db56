"""The report of the doctor for others: nothing in it tells who and where, and what help needs stays."""

from __future__ import annotations

import json

import pytest

from rosproto.node import SystemState
from woosh_pure.doctor.checks import Finding, Level
from woosh_pure.doctor.report import Redaction, report


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("the master is at 169.254.128.2:11311", "the master is at address-1:11311"),
        ("from 10.0.0.7 to 10.0.0.8, not 10.0.0.7", "from address-1 to address-2, not address-1"),
        ("http://robot-7.lab.example:11311/ and robot-7.lab.example", "http://host-2:11311/ and host-2"),
        ("node /bridge_anna_laptop_12 on ANNA-LAPTOP", "node /bridge_anna_laptop_12 on host-1"),
        ("node /anna-laptop_12", "node /host-1_12"),
        ("/home/anna/marks.json", "~/marks.json"),
        ("http://[fe80::1c2d:3e4f]:11311/", "http://[address-1]:11311/"),
        ("127.0.0.1 and http://localhost:1/", "127.0.0.1 and http://localhost:1/"),
        ("at 12:30:05, version 1.16.0", "at 12:30:05, version 1.16.0"),
        ("woosh_msgs::StepControl", "woosh_msgs::StepControl"),
    ],
)
def test_what_tells_who_and_where_is_taken_out(text: str, expected: str) -> None:
    assert Redaction(["anna-laptop"], "/home/anna")(text) == expected


def test_the_same_thing_has_the_same_number_everywhere() -> None:
    """In keys, lists and other texts, whatever the order."""
    redact = Redaction()
    first = redact({"http://10.1.2.3/": ["10.1.2.4", {"again": "10.1.2.3"}]})
    assert first == {"http://address-1/": ["address-2", {"again": "address-1"}]}
    assert redact("10.1.2.4") == "address-2"


def test_a_report_has_findings_versions_and_the_graph() -> None:
    finding = Finding("reach", Level.PROBLEM, "10.1.2.3 refuses", "ask anna-laptop")
    state = SystemState({"/odom": ["/base"]}, {}, {})
    document = report(
        [finding], state, {"/odom": "nav_msgs/Odometry"}, {"python": "3.11"}, Redaction(["anna-laptop"])
    )
    assert json.loads(json.dumps(document)) == {
        "woosh_report": 1,
        "system": {"python": "3.11"},
        "findings": [
            {"check": "reach", "level": "problem", "text": "address-1 refuses", "advice": "ask host-1"}
        ],
        "graph": {
            "topics": {"/odom": "nav_msgs/Odometry"},
            "publishers": {"/odom": ["/base"]},
            "subscribers": {},
            "services": {},
        },
    }
    assert report([], None, {}, {}, Redaction())["graph"] is None
