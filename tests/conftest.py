"""No test is slow without saying so: over five seconds it needs `@pytest.mark.slow`.

Watched where SLOW_TESTS_FAIL=1 is set, as CI does. What counts is what the test would take with the machine to
itself: its time without that in which it stood ready and others had the processor, where the system tells it
(Linux); or, for a test that waits for other processes, its time divided by the processes that each processor had.
CI runs what failed once more, alone, and believes that.

`pytest` alone leaves out what takes long (slow), compares or storms whole programs (whole), needs others (interop), or
reads the sources (structure); named files, folders or `-m` bring all of it. With PASSED_TESTS=FILE in the environment the names of tests that passed are
added to the file, and those that are in it already do not run again: so CI runs the rest, and counts.

Interop tests start other programs and are excused. Hypothesis has no deadline of its own here: it would count the
load of the machine.

No test touches the user's folders or another machine: tests/support/watched/ gives it folders of its own and watches.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from tests.support.passed import Passed
from tests.support.watched.plugin import begin, pytest_runtest_teardown, pytest_sessionfinish

__all__ = ["pytest_runtest_teardown", "pytest_sessionfinish"]

AT_ONCE = "not (slow or whole or interop or structure)"
begin()
settings.register_profile("no deadline", settings(), deadline=None)
settings.load_profile("no deadline")

SLOW_SECONDS = 5.0
SCHEDULER = Path("/proc/thread-self/schedstat")  # ns on the processor, ns ready without one, slices
_waited = pytest.StashKey[float]()


def pytest_configure(config: pytest.Config) -> None:
    """What runs when nothing in particular is asked for; and what is noted."""
    if config.args_source is config.ArgsSource.TESTPATHS and not config.option.markexpr:
        config.option.markexpr = AT_ONCE
    if os.environ.get("PASSED_TESTS"):
        passed = Passed(Path(os.environ["PASSED_TESTS"]), notes=not hasattr(config, "workerinput"))
        config.pluginmanager.register(passed, "passed-tests")


@pytest.fixture(autouse=True)
def root_level() -> Iterator[None]:
    """`rosproto log set` reaches the loggers of the process that runs the node, and that is this one."""
    level = logging.root.level
    yield
    logging.root.setLevel(level)


def waited_for_the_processor() -> float:
    """Seconds in which this thread was ready to run and did not, since it began; 0.0 where nobody counts them."""
    try:
        return int(SCHEDULER.read_text().split()[1]) / 1e9
    except (OSError, IndexError):
        return 0.0


def crowd() -> float:
    """How many processes each processor has to serve, in the last minute; at least 1."""
    try:
        return max(1.0, os.getloadavg()[0] / (os.cpu_count() or 1))
    except (AttributeError, OSError):  # Windows has no such figure
        return 1.0


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    """Note how long others kept it waiting."""
    before = waited_for_the_processor()
    try:
        return (yield)
    finally:
        item.stash[_waited] = waited_for_the_processor() - before


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> Iterator[None]:
    """Fail a passing test that took longer than it may."""
    outcome = yield
    report = outcome.get_result()  # type: ignore[attr-defined]
    if os.environ.get("SLOW_TESTS_FAIL") != "1" or call.when != "call" or not report.passed:
        return
    if any(item.get_closest_marker(name) for name in ("slow", "interop")):
        return
    seconds = min(call.duration - item.stash.get(_waited, 0.0), call.duration / crowd())
    if seconds > SLOW_SECONDS:
        report.outcome = "failed"
        report.longrepr = (
            f"{item.nodeid} took {seconds:.1f} s ({call.duration:.1f} s on this busy machine) without a mark; tests"
            f" without one end in {SLOW_SECONDS:g} s: make it faster, or mark it @pytest.mark.slow"
        )
