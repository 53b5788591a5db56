"""Makes a test run hermetic: separate folders in the environment, a watch, and a failure for each violation.

tests/conftest.py imports these hooks. Each test process (each xdist worker) has its own home. The commands' files in
it are removed after each test.
"""

from __future__ import annotations

import atexit
import json
import os
import shutil
import signal
import site
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from tests.support.watched import hermetic

__all__ = ["begin", "expected", "pytest_runtest_teardown", "pytest_sessionfinish", "real_home"]

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[2]
FOLDERS = {
    "HOME": "", "USERPROFILE": "", "APPDATA": "AppData/Roaming", "LOCALAPPDATA": "AppData/Local",
    "XDG_CONFIG_HOME": ".config", "XDG_DATA_HOME": ".local/share", "XDG_STATE_HOME": ".local/state",
    "XDG_CACHE_HOME": ".cache", "ROS_HOME": ".ros", "ROS_LOG_DIR": ".ros/log",
}  # fmt: skip
"""Variable for a folder of the user -> its place in the home of the tests."""
UNSET = (
    "WOOSH_CONFIG_DIR", "ROSPROTO_MSG_PATH", "ROS_MASTER_URI", "ROS_IP", "ROS_HOSTNAME", "ROS_NAMESPACE",
    "ROS_PACKAGE_PATH", "HOMEDRIVE", "HOMEPATH", "LANGUAGE",
)  # fmt: skip
"""Variables that would redirect the commands or change their output."""
KEPT = (".config/woosh", ".local/share/rosproto", "AppData", "Library")
"""The folders that our commands write in a home."""
CACHE = "TESTS_CACHE_HOME"
"""The user's original cache folder, with installed peers (rosnodejs)."""
DEBIAN = "/usr/bin/python3"  # real ROS: runs without our PYTHONPATH, with its own home

_home: Path | None = None
_report: Path | None = None


def begin() -> None:
    """Set temporary folders in the environment and start the watch; once, before our packages are imported."""
    global _home, _report
    if _home is not None:
        return
    before = json.loads(os.environ.get(hermetic.VARIABLE) or "{}")
    guarded = before.get("guarded") or _folders_of_the_user()
    _own_folders_stay_importable()
    _be_interruptible()
    os.environ.setdefault(CACHE, os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"))
    os.environ.setdefault("WOOSH_WINDOWS", os.environ[CACHE] + "/woosh-pure-windows")
    base = Path(tempfile.mkdtemp(prefix="woosh-tests-"))
    atexit.register(_remove, base, os.getpid())
    _home, _report = base / "home", base / "report"
    for name, below in FOLDERS.items():
        folder = _home / below
        folder.mkdir(parents=True, exist_ok=True)
        os.environ[name] = str(folder)
    for name in UNSET:
        os.environ.pop(name, None)
    for name in ("LC_ALL", "LC_MESSAGES", "LANG"):  # the tests expect English
        if os.environ.get(name, "").lower().startswith("zh"):
            os.environ[name] = "C.UTF-8"
    os.environ.setdefault("LANG", "C.UTF-8")  # else the locale of Windows decides
    state = {"guarded": guarded, "free": [*_free(), *before.get("free", [])], "report": str(_report)}
    os.environ[hermetic.VARIABLE] = json.dumps(state)
    os.environ["PYTHONPATH"] = _with_watch(os.environ.get("PYTHONPATH", ""))
    hermetic.install(state)
    _watch_what_is_started()


def real_home() -> str:
    """The user's home, which no test may touch."""
    return str(json.loads(os.environ[hermetic.VARIABLE])["guarded"][0])


def _folders_of_the_user() -> list[str]:
    found = [os.path.expanduser("~")]
    if sys.platform != "win32":
        import pwd

        try:
            found.append(pwd.getpwuid(os.getuid()).pw_dir)  # the home without $HOME
        except KeyError:
            pass  # a container with an arbitrary user id
    found += [os.environ[name] for name in (*FOLDERS, "WOOSH_CONFIG_DIR") if os.environ.get(name)]
    paths = dict.fromkeys(os.path.realpath(path) for path in found)
    # In some containers the home is the root directory; a home among temporary folders belongs to a test run.
    return [path for path in paths if path != os.path.realpath(os.sep)] or [os.path.join(os.sep, "nobody's")]


def _free() -> list[str]:
    """Folders of the project, its Python and temporary files."""
    places = [str(ROOT), tempfile.gettempdir(), sys.prefix, sys.base_prefix, sys.exec_prefix, *sys.path]
    places += [os.path.dirname(sys.executable), os.path.dirname(os.path.realpath(sys.executable))]
    places += [sys.pycache_prefix or "", site.getuserbase() or "", os.environ[CACHE] + "/rosproto-tests"]
    places.append(os.environ["WOOSH_WINDOWS"])
    return [*places, *map(os.path.realpath, filter(None, places))]


def _own_folders_stay_importable() -> None:
    """Keep packages of `pip install --user` in the real home importable."""
    if site.ENABLE_USER_SITE:
        os.environ.setdefault("PYTHONUSERBASE", site.getuserbase())


def _be_interruptible() -> None:
    """Restore signals: a shell without job control starts background jobs (`pytest &`) with SIGINT ignored,
    nohup with SIGHUP.

    Started programs inherit ignored signals, and tests of these signals would fail. A handler is not inherited; for
    SIGHUP it does nothing, so `nohup pytest` still works.
    """
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if os.name != "nt" and signal.getsignal(signal.SIGHUP) is signal.SIG_IGN:
        signal.signal(signal.SIGHUP, lambda *_: None)


def _remove(folder: Path, owner: int) -> None:
    if os.getpid() == owner:  # not in a forked child
        shutil.rmtree(folder, ignore_errors=True)


def _with_watch(paths: str) -> str:
    others = [path for path in paths.split(os.pathsep) if path and path != str(HERE)]
    return os.pathsep.join([str(HERE), *others])


def _watch_what_is_started() -> None:
    """Add the watch to the environment of started programs; many tests replace the environment."""
    usual = subprocess.Popen.__init__

    def init(self: Any, args: Any, *rest: Any, **options: Any) -> None:
        program = args if isinstance(args, (str, bytes, os.PathLike)) else next(iter(args), "")
        name = os.fsdecode(program)
        given = options.get("env")
        if name in ("unshare", "nsenter"):
            given = {**(os.environ if given is None else given), hermetic.NETWORK: "own"}
        if given is not None and name != DEBIAN and "PYTHONHOME" not in given:
            given = {**given, hermetic.VARIABLE: os.environ[hermetic.VARIABLE]}
            given["PYTHONPATH"] = _with_watch(given.get("PYTHONPATH", ""))
        if given is not None:
            options["env"] = given
        usual(self, args, *rest, **options)

    subprocess.Popen.__init__ = init  # type: ignore[method-assign]


# -- violations --------------------------------------------------------------------------------------------


def _seen() -> list[str]:
    """Read the lines of the report and remove it."""
    assert _report is not None
    try:
        lines = _report.read_text("utf-8").splitlines()
    except FileNotFoundError:
        return []
    _report.unlink(missing_ok=True)
    return lines


@contextmanager
def expected() -> Iterator[list[str]]:
    """For tests of the watch: yield the violations of the block, which then fail no test."""
    lines: list[str] = []
    try:
        yield lines
    finally:
        lines += _seen()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(item: pytest.Item) -> Iterator[None]:
    """Fail the test if it or its programs violated the rules."""
    try:
        yield
    finally:
        lines = _seen()
        assert _home is not None
        for name in KEPT:
            shutil.rmtree(_home / name, ignore_errors=True)
    if lines:
        pytest.fail("\n".join(map(hermetic.explain, lines)), pytrace=False)


def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    """Report violations of programs that still ran after the last test."""
    lines = _seen()
    if lines:
        print("\n".join(map(hermetic.explain, lines)), file=sys.stderr)
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
