"""bondpy and topic_tools.LazyTransport beside Debian's: each end of ours and of theirs, in one graph."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import product
from pathlib import Path

import pytest

from rosproto.master import Master
from tests.support import ros
from tests.support.rospy_pair import Outcome, run_program

pytestmark = pytest.mark.slow
DEBIAN = Path("/usr/lib/python3/dist-packages")
PAIRS = [pair for pair in product((True, False), repeat=2) if pair != (True, True)]


def together(*programs: tuple[Sequence[str], bool], packages: Path) -> list[Outcome]:
    """Run programs, each by Debian's rospy or by ours, in a graph of their own."""
    with Master() as master, ThreadPoolExecutor(len(programs)) as pool:
        running = [
            pool.submit(
                run_program,
                *words,
                real=real,
                packages=[DEBIAN, packages] if real else (),
                master_uri=master.uri,
            )
            for words, real in programs
        ]
        return [each.result() for each in running]


def shown(outcomes: list[Outcome]) -> list[tuple[int, list[str]]]:
    return [(each.code, each.out) for each in outcomes]


@pytest.mark.parametrize("what", ["break", "shutdown", "die"])
def test_a_bond_of_ours_is_one_of_debian_s(what: str, genpy_packages: Path) -> None:
    """What one end does, the other one notices: ours beside ours, and each beside theirs."""
    ros.require((DEBIAN / "bondpy").is_dir(), "there is no python3-bondpy")

    silence = "3" if what == "die" else "20"  # seconds: a busy computer holds up a heartbeat for some

    def ends(one: bool, other: bool) -> list[tuple[int, list[str]]]:
        found = together(
            (["bond_end.py", "one", what, "20"], one),
            (["bond_end.py", "other", "stay", silence], other),
            packages=genpy_packages,
        )
        return shown(found)

    theirs = ends(True, True)
    assert "broken" in theirs[1][1][0]
    assert {pair: ends(*pair) for pair in PAIRS} == dict.fromkeys(PAIRS, theirs)


def test_a_bond_that_nobody_answers_breaks(genpy_packages: Path) -> None:
    ros.require((DEBIAN / "bondpy").is_dir(), "there is no python3-bondpy")
    theirs, ours = (
        shown(together((["bond_end.py", "one", "alone", "2"], real), packages=genpy_packages))
        for real in (True, False)
    )
    assert ours == theirs


def test_a_lazy_relay_subscribes_only_for_somebody(genpy_packages: Path) -> None:
    """The relay's and its user's words are the same, whoever of them is Debian's."""
    ros.require((DEBIAN / "topic_tools").is_dir(), "there is no python3-topic-tools")

    def both(relay: bool, user: bool) -> list[tuple[int, list[str]]]:
        return shown(together((["lazy_relay.py"], relay), (["lazy_user.py"], user), packages=genpy_packages))

    theirs = both(True, True)
    assert theirs[0][1] == [str(["to be overridden"] * 2 + ["subscribe", "unsubscribe"] * 2)]
    assert {pair: both(*pair) for pair in PAIRS} == dict.fromkeys(PAIRS, theirs)
