"""The same random inputs through Debian's tools and through ours; longer: `python -m tests.interop.compare`."""

from __future__ import annotations

import os
import random
from pathlib import Path
from typing import Any

import pytest

from tests.interop.compare import everything
from tests.interop.compare.comparison import Answer, Case, Difference, Kind, Peer, compare, debian

ROUNDS = 30
SEED = int(os.environ.get("COMPARE_SEED", "41"))
"""The same one in every check, so that it fails for a reason; by hand each run has another."""


@pytest.mark.slow
@pytest.mark.long
def test_debians_tools_and_ours_answer_alike(genpy_packages: Path) -> None:
    """The first numbers of a seed, the same in each check; what differs has a reason in compare/differences.py."""
    report = everything.run(seed=SEED, seconds=1000.0, rounds=ROUNDS, packages=genpy_packages)
    print(f"seed {SEED}\n{report}")
    assert not report.found, str(report)
    assert report.rounds == ROUNDS, str(report)
    assert len(report.inputs) == len(everything.NAMES)


class Wrong(Kind):
    """A kind whose answers differ for odd numbers."""

    def draw(self, chance: random.Random) -> Case:
        return chance.randrange(100)

    def ours(self, case: Case) -> Answer:
        return {"error": "ours"} if case % 2 else {"out": case}

    def theirs(self, case: Case, peer: Peer) -> Answer:
        return {"error": "theirs"} if case % 2 and case < 50 else {"out": case}


def test_a_difference_is_found_unless_it_has_a_reason() -> None:
    """Texts of errors are not compared; a seed gives the same cases again."""
    nobody: Any = None
    report = compare([Wrong()], [], nobody, seed=5, seconds=60.0, enough=3)
    assert len(report.found) == 3
    assert "seed 5, number" in report.found[0]
    assert compare([Wrong()], [], nobody, seed=5, seconds=60.0, enough=3).found == report.found
    reason = Difference("Wrong", "odd numbers", lambda case, theirs, ours: case % 2 == 1)
    report = compare([Wrong()], [reason], nobody, seed=5, seconds=0.2)
    assert not report.found
    assert report.documented["odd numbers"] > 3


def test_a_peer_that_ends_is_started_again(genpy_packages: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A case that takes too long is an error, and the next one is answered."""
    monkeypatch.setattr("tests.interop.compare.comparison.ANSWER_SECONDS", 1.0)
    case = {"types": {"p/T": "int8 a"}, "main": "p/T", "kind": "msg"}
    with debian("http://127.0.0.1:1", genpy_packages) as peer:
        slow = {"class": "String", "value": "'x' * sum(1 for _ in iter(int, 1))"}
        assert peer.ask("publish", slow)["error"] == "ended"
        monkeypatch.setattr("tests.interop.compare.comparison.ANSWER_SECONDS", 60.0)
        assert peer.ask("definition", case)["fields"] == [[["int8", "a"]]]
