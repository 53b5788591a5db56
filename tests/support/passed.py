"""Notes passed tests, and leaves them out of later runs.

Set PASSED_TESTS to a file, as .ci/run does: README's command in a bare environment, then the rest with everything
installed. A skipped test did not pass, so it is part of the rest.
"""

from __future__ import annotations

from pathlib import Path

import pytest

__all__ = ["Passed", "leave_out"]


def leave_out(config: pytest.Config, items: list[pytest.Item], spared: set[pytest.Item]) -> None:
    """Take these from the list, and let pytest count them."""
    if spared:
        config.hook.pytest_deselected(items=[item for item in items if item in spared])
        items[:] = [item for item in items if item not in spared]


class Passed:
    """The names of passed tests, one per line.

    Args:
        file: Where they are; it need not exist.
        skipped_too: A test that is skipped counts as one that passed.
        notes: Whether this process notes anything: not in a worker, whose reports another process gets.
    """

    def __init__(self, file: Path, *, skipped_too: bool = False, notes: bool = True) -> None:
        self.file = file
        self.skipped_too = skipped_too
        self.notes = notes
        self.before = set(file.read_text("utf-8").splitlines()) if file.exists() else set()
        self._doubtful: set[str] = set()

    def pytest_collection_modifyitems(self, config: pytest.Config, items: list[pytest.Item]) -> None:
        """Leave out what passed before."""
        leave_out(config, items, {item for item in items if repr(item.nodeid) in self.before})

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note it when its teardown is over too, so that it is a test that passed.

        A name may hold anything, so it is written as Python writes it.
        """
        if not self.notes:
            return
        if report.failed or (report.skipped and not self.skipped_too):
            self._doubtful.add(report.nodeid)
        elif report.when == "teardown" and report.nodeid not in self._doubtful:
            with self.file.open("a", encoding="utf-8") as noted:
                noted.write(f"{report.nodeid!r}\n")
