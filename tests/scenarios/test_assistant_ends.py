"""An assistant ends, or is cut off, while the robot drives: it stands long before the mark.

The times are measured by `python -m tests.support.assistant_ends`; docs/assistant.md has them.
"""

from __future__ import annotations

import os

import pytest

from tests.support.assistant_ends import SILENT, open_world
from tests.support.extras import needs
from tests.support.hosts import why_not

needs("mcp")
pytestmark = [pytest.mark.slow, pytest.mark.timeout(300)]

AT_ONCE, BY_LIMIT = 1.6, 2.6
"""m, of the 3.2 m to the mark, at 0.2 m/s: with seconds to spare on a busy computer."""
MAX_SECONDS = 6.0


@pytest.mark.skipif(os.name == "nt", reason="the trials need POSIX signals")
@pytest.mark.promise("the assistant's program is killed")
@pytest.mark.promise("of `woosh web`, `woosh drive`, `woosh mcp`")
@pytest.mark.promise("the assistant's program is stopped (SIGSTOP) or cut off")
@pytest.mark.parametrize(("way", "kinds"), [("stdio", ("kill", "stop", "server")), ("http", ("kill",))])
def test_the_robot_stands(way: str, kinds: tuple[str, ...]) -> None:
    """At once where the connection ends; by the time limit where nothing is closed."""
    with open_world(way, "kill", max_seconds=MAX_SECONDS) as world:
        for kind in kinds:
            metres = world.trial(kind, 0.2).metres
            if kind in SILENT:
                assert 0.5 < metres < BY_LIMIT, kind
            else:
                assert metres < AT_ONCE, kind


@pytest.mark.skipif(bool(why_not()), reason=why_not())
@pytest.mark.promise("the assistant's program is stopped (SIGSTOP) or cut off")
def test_a_cut_cable() -> None:
    """Nobody can notice it: the time limit ends the motion."""
    with open_world("http", "cut", max_seconds=MAX_SECONDS) as world:
        assert 0.5 < world.trial("cut", 0.2).metres < BY_LIMIT
