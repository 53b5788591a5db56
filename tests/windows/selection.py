"""Select the tests of a process under Wine; a plugin of pytest, `-p tests.windows.selection`.

`--passed FILE` leaves out what earlier processes noted there, and notes what passes or skips: after a crash of
Wine's server the next process goes on where that one ended.

`--few` runs three cases of each test of pure logic, and ten examples of each property. What touches no socket, file,
clock, thread, process, console or array of numpy (whose default integer has 32 bits on Windows) is the same there;
Linux runs every case.
"""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path
from types import ModuleType

import pytest
from hypothesis import settings

from tests.support.passed import Passed, leave_out

PURE = tuple(
    f"tests/unit/{name}" for name in ("msg/", "codec/", "protocol/", "tf/", "woosh/", "woosh_cli/", "test_")
)
SYSTEM = frozenset(
    "asyncio concurrent ctypes datetime io locale mmap multiprocessing numpy os queue select selectors shutil signal socket"
    " subprocess sys tempfile threading time".split()
)
SYSTEM_FIXTURES = frozenset({"tmp_path", "tmp_path_factory", "capfd", "capfdbinary"})
KEPT = 3


def pytest_addoption(parser: pytest.Parser) -> None:
    """Both are off by default."""
    group = parser.getgroup("windows", "CPython for Windows under Wine")
    group.addoption("--passed", type=Path, help="leave out the tests named in this file, add those that pass")
    group.addoption("--few", action="store_true", help="three cases of each test of pure logic")


def pytest_configure(config: pytest.Config) -> None:
    """After tests/conftest.py, which has loaded its profile; before any test is imported."""
    if config.getoption("--few"):
        settings.register_profile("few", deadline=None, max_examples=10)
        settings.load_profile("few")
    file = config.getoption("--passed")
    if file is not None:
        config.pluginmanager.register(Passed(file, skipped_too=True), "windows-passed")


@pytest.hookimpl(tryfirst=True)  # before other plugins shuffle them
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Deselect cases that other cases of the same test represent."""
    if not config.getoption("--few"):
        return
    cases: dict[str, list[pytest.Item]] = defaultdict(list)
    for item in items:
        if isinstance(item, pytest.Function) and is_pure(item):
            cases[item.nodeid.partition("[")[0]].append(item)
    spared = {item for same in cases.values() for item in same if item not in representatives(same)}
    leave_out(config, items, spared)


def is_pure(item: pytest.Function) -> bool:
    """Whether a test can only compute: by where it is, what its module imports, and what it asks for."""
    if not item.nodeid.startswith(PURE) or SYSTEM_FIXTURES & set(item.fixturenames):
        return False
    modules = (value for value in vars(item.module).values() if isinstance(value, ModuleType))
    return not SYSTEM & {module.__name__.partition(".")[0] for module in modules}


def representatives(same: list[pytest.Item]) -> list[pytest.Item]:
    """The first case by name, the one in the middle, and the last: the same ones in every run."""
    same = sorted(same, key=lambda item: item.nodeid)
    return same if len(same) <= KEPT else [same[0], same[len(same) // 2], same[-1]]
