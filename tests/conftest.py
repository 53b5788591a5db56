"""What runs, and what is noted of it.

`pytest` alone leaves out what takes long (slow), compares or storms whole programs (whole), needs others (interop), or
reads the sources (structure); named files, folders or `-m` bring all of it. Two variables of the environment name files:

- PASSED_TESTS: tests that passed are added to it, and those that are in it already do not run again. So CI runs the rest, and counts.
- SLOW_TESTS: tests that took over five seconds without `@pytest.mark.slow` are added to it. CI lists them at its end; none fails
  for it, since the time depends on the machine. Interop tests start other programs and are excused.

Hypothesis has no deadline of its own here: it would count the load of the machine.

No test touches the user's folders or another machine: tests/support/watched/ gives it folders of its own and watches.
"""

from __future__ import annotations

import gc
import logging
import os
from collections.abc import Generator, Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from tests.support.passed import Passed
from tests.support.watched.plugin import begin, pytest_runtest_teardown, pytest_sessionfinish

__all__ = ["pytest_runtest_teardown", "pytest_sessionfinish"]

AT_ONCE = "not (slow or whole or interop or structure)"
ALL_INTEROP = [Path(__file__).parent / name for name in ("interop", "windows")]
begin()
settings.register_profile("no deadline", settings(), deadline=None)
settings.load_profile("no deadline")

SLOW_SECONDS = 5.0
THROUGH_ROBOT_API = "--through-robot-api"


def pytest_addoption(parser: pytest.Parser) -> None:
    """See tests/support/through_robot_api.py."""
    parser.addoption(
        THROUGH_ROBOT_API, action="store_true", help="reach simulated robots by the Robot API alone"
    )


@pytest.hookimpl(trylast=True)  # after the order by chance
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Begin with what takes minutes, or all would wait for it at the end; leave out what the Robot API cannot express."""
    items.sort(key=lambda item: item.get_closest_marker("long") is None)
    if config.getoption(THROUGH_ROBOT_API):
        from tests.support.through_robot_api import skip_what_it_cannot

        skip_what_it_cannot(items)


def pytest_configure(config: pytest.Config) -> None:
    """What runs when nothing in particular is asked for; and what is noted."""
    if config.getoption(THROUGH_ROBOT_API):
        from tests.support.through_robot_api import begin as begin_through_robot_api

        begin_through_robot_api()
    if config.args_source is config.ArgsSource.TESTPATHS and not config.option.markexpr:
        config.option.markexpr = AT_ONCE
    if os.environ.get("PASSED_TESTS"):
        passed = Passed(Path(os.environ["PASSED_TESTS"]), notes=not hasattr(config, "workerinput"))
        config.pluginmanager.register(passed, "passed-tests")


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Import nothing of a folder of which nothing will run."""
    return True if config.option.markexpr == AT_ONCE and collection_path in ALL_INTEROP else None


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Keep the collector of garbage from what is collected, which stays: it would take half of the time."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.collect()
        gc.freeze()
        gc.enable()


@pytest.fixture(autouse=True)
def root_level() -> Iterator[None]:
    """`rosproto log set` reaches the loggers of the process that runs the node, and that is this one."""
    level = logging.root.level
    yield
    logging.root.setLevel(level)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Note a test that takes long and does not say so."""
    report = yield
    noted = os.environ.get("SLOW_TESTS")
    excused = any(item.get_closest_marker(name) for name in ("slow", "interop"))
    if noted and call.when == "call" and call.duration > SLOW_SECONDS and not excused:
        with open(noted, "a", encoding="utf-8") as file:
            file.write(f"{call.duration:.1f} s: {item.nodeid!r}\n")
    return report
