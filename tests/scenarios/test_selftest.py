"""`woosh selftest` as its user sees it: a line for each check, a verdict, the exit code."""

from __future__ import annotations

import json
import re

import pytest

import rosproto.selftest
from woosh_pure import selftest
from woosh_pure.cli import main


@pytest.mark.slow
def test_it_says_that_this_machine_is_fine(capsys: pytest.CaptureFixture[str]) -> None:
    """All checks, in a minute at most; a line each with its time."""
    assert main(["selftest"]) == 0
    lines = capsys.readouterr().out.splitlines()
    names = [line.split()[2 if line.startswith("not here") else 1] for line in lines[:-1]]
    assert names == ["definitions", "codec", "master", "nodes", "bag", "chassis", "drive", "ros"]
    assert all(re.search(r" \d+\.\d\d s  \S", line) for line in lines[:-1])
    assert lines[-1].startswith("this machine is fine")
    assert float(re.search(r"\(([\d.]+) s\)", lines[-1])[1]) < 60.0  # type: ignore[index]


def test_what_is_wrong_is_named_and_makes_the_exit_code(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def wrong() -> str:
        raise rosproto.selftest.CheckFailed("measured 1, expected 2")

    def absent() -> str:
        raise rosproto.selftest.NotApplicable("no such thing here")

    checks = (
        rosproto.selftest.Check("good", lambda: "shown"),
        rosproto.selftest.Check("bad", wrong),
        rosproto.selftest.Check("ros", absent),
    )
    monkeypatch.setattr(selftest, "CHECKS", checks)
    assert main(["selftest"]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == ["fine", "FAILED", "not", "this"]
    assert "bad failed" in lines[-1]
    assert main(["selftest", "--json", "--no-ros"]) == 1
    document = json.loads(capsys.readouterr().out)
    assert document["ok"] is False
    assert [check["state"] for check in document["checks"]] == ["fine", "failed"]
    assert document["checks"][1]["text"] == "measured 1, expected 2"


def test_what_is_absent_fails_nothing(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def absent() -> str:
        raise rosproto.selftest.NotApplicable("no such thing here")

    monkeypatch.setattr(selftest, "CHECKS", (rosproto.selftest.Check("ros", absent),))
    assert main(["selftest"]) == 0
    assert "not here" in capsys.readouterr().out


def test_it_is_about_this_machine(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["selftest", "--chassis", "127.0.0.1:1"]) == 2
    assert "woosh doctor" in capsys.readouterr().err
