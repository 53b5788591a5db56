"""One victim and one innocent peer per test process: every attack meets what the attacks before it left."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

import pytest

from tests.support.victim import Bystander, Victim, eventually

MIB = 1 << 20
HERE = Path(__file__).resolve().parent


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Storms: what attackers make a busy computer do takes its time."""
    for item in items:
        if HERE in item.path.parents:
            item.add_marker(pytest.mark.whole)
            item.add_marker(pytest.mark.timeout(300))


@pytest.fixture(scope="session")
def victim() -> Iterator[Victim]:
    """A master and a node in a process of their own."""
    with Victim() as victim:
        yield victim


@pytest.fixture(scope="session")
def bystander(victim: Victim) -> Iterator[Bystander]:
    """A subscriber and service client of the victim's node."""
    with Bystander(victim) as bystander:
        yield bystander


@pytest.fixture
def unharmed(victim: Victim, bystander: Bystander) -> Callable[..., AbstractContextManager[None]]:
    """`with unharmed(memory=..., threads=...):` an attack, during which innocent peers are served as ever.

    Memory may rise by so many MiB and threads by so many meanwhile; afterwards threads, connections and open files
    are as before.
    """

    @contextmanager
    def watch(*, memory: int = 64, threads: int = 300) -> Iterator[None]:
        before, files = victim.ask(), victim.files
        peak = victim.peak_since()
        with bystander.goes_on():
            yield
            now = victim.threads
            assert now <= before["threads"] + threads, f"{now} threads, {before['threads']} before"
        assert victim.alive
        assert peak() <= memory * MIB, f"memory rose by {peak() / MIB:.1f} MiB"
        eventually(lambda: victim.threads <= before["threads"] + 4, what="the end of the attack's threads")
        eventually(lambda: victim.files <= files + 6, what="the end of the attack's connections")
        assert not victim.ask()["closed"]

    return watch
