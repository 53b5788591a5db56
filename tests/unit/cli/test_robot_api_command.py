"""`woosh robot-api`: the options and words of the other servers, closed until something is opened."""

from __future__ import annotations

import json
import re

import pytest

from tests.support.extras import needs
from woosh_pure import SimulatedChassis
from woosh_pure.cli import main as woosh

needs("api")
pytestmark = pytest.mark.slow  # each starts a simulated chassis


def said(capsys: pytest.CaptureFixture[str], *options: str) -> str:
    with SimulatedChassis(full_graph=False) as sim:
        assert woosh(["--master", sim.master_uri, *options, "--port", "0", "--for", "0.2"]) == 0
    return capsys.readouterr().out


def test_it_says_where_it_serves_and_what_is_open(capsys: pytest.CaptureFixture[str]) -> None:
    closed = (
        r"^Serving the Robot API at ws://127\.0\.0\.1:\d+ \(read only: --allow-write PATTERN opens more\)$"
    )
    assert re.search(closed, said(capsys, "robot-api"), re.M)
    opened = said(capsys, "--json", "robot-api", "--allow-write", "api:Twist", "--share")
    assert json.loads(opened)["write"] == ["api:Twist"]


def test_other_computers_need_a_token(capsys: pytest.CaptureFixture[str]) -> None:
    """One is made where none was given."""
    out = said(capsys, "robot-api", "--bind", "0.0.0.0")
    assert re.search(r"ws://127\.0\.0\.1:\d+/\?token=\S{20,} ", out)


def test_a_pattern_of_no_kind_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert woosh(["--sim", "robot-api", "--allow-write", "robot:Twist"]) == 2
    assert "one of topic, service, action, param, node, api" in capsys.readouterr().err
