"""The checks of tests/support/watched detect what they should, in this process and in child processes."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from rosproto import profile as config
from rosproto.msg.user_folder import revisions_folder
from tests.support.watched.plugin import FOLDERS, expected, real_home
from woosh_pure.cli import main

ROOT = Path(__file__).resolve().parents[2]
GRANDCHILD = "import subprocess, sys; sys.exit(subprocess.call([sys.executable, '-c', {!r}]))"
PROFILE = str(Path(real_home(), ".config", "woosh", "profile.json"))
ELSEWHERE = "10.255.254.253"  # an address that may be anybody's


def test_every_folder_of_the_user_is_a_temporary_one() -> None:
    home = os.environ["HOME"]
    assert not home.startswith(real_home() + os.sep) or "woosh-tests-" in home
    for name in FOLDERS:
        assert os.environ[name].startswith(home)
    for folder in (config.directory(), revisions_folder(), Path.home()):
        assert str(folder).startswith(home)


def test_a_saved_chassis_of_the_user_is_not_found(capsys: pytest.CaptureFixture[str]) -> None:
    """Whatever `woosh connect` has saved on this machine, in each test anew."""
    assert main(["connect", "--show"]) == 1
    assert main(["connect", "127.0.0.1:1", "--unchecked"]) == 0
    assert config.profile_file().exists()


@pytest.mark.parametrize("again", [1, 2])
def test_no_test_finds_what_another_one_saved(again: int) -> None:
    assert not config.profile_file().exists()
    config.save(config.Profile("127.0.0.1", None))


def test_the_real_home_cannot_be_read_or_written() -> None:
    for act in (
        lambda: Path(PROFILE).read_text(),
        lambda: Path(PROFILE).write_text("{}"),
        lambda: Path(PROFILE).unlink(),
        lambda: Path(PROFILE).parent.mkdir(),
        lambda: list(Path(PROFILE).parent.iterdir()),
        lambda: Path(__file__).rename(PROFILE),
    ):
        with expected() as seen, pytest.raises(PermissionError, match="user's folders"):
            act()
        assert len(seen) == 1
        assert "woosh" in seen[0]


def test_no_other_machine_is_reached() -> None:
    def by_datagram() -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
            sock.sendto(b"?", (ELSEWHERE, 53))

    for act in (
        lambda: socket.create_connection((ELSEWHERE, 11311), 1.0),
        lambda: socket.create_connection(("::ffff:" + ELSEWHERE, 11311), 1.0),
        lambda: socket.getaddrinfo("robot.somewhere.net", 11311),
        lambda: socket.gethostbyname("robot"),
        by_datagram,
    ):
        with expected() as seen, pytest.raises(PermissionError, match="another machine"):
            act()
        assert len(seen) == 1


def test_this_machine_is_reached_and_what_asks_nobody_may_be_done() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        socket.create_connection(server.getsockname()[:2], 5.0).close()
        socket.create_connection(("localhost", server.getsockname()[1]), 5.0).close()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as route, expected() as seen:
        route.connect(("192.0.2.1", 9))
    assert seen == []


@pytest.mark.parametrize(
    "code",
    [
        f"open({PROFILE!r})",
        f"import socket; socket.create_connection(({ELSEWHERE!r}, 11311), 1)",
        GRANDCHILD.format(f"open({PROFILE!r})"),
    ],
    ids=["file", "connection", "grandchild"],
)
@pytest.mark.parametrize("environment", ["same", "own"])
def test_started_pythons_are_watched(code: str, environment: str) -> None:
    """Also one that is given an environment of its own, and one that swallows the error."""
    env = None if environment == "same" else {"PATH": os.environ["PATH"], "PYTHONPATH": str(ROOT)}
    if env is not None and sys.platform == "win32":
        env["SYSTEMROOT"] = os.environ["SYSTEMROOT"]
    for program in (code, f"try: exec({code!r})\nexcept OSError: raise SystemExit(1)"):
        with expected() as seen:
            done = subprocess.run(
                [sys.executable, "-c", program], env=env, capture_output=True, timeout=60, check=False
            )
        assert done.returncode == 1
        assert len(seen) == 1


@pytest.mark.skipif(sys.platform == "win32", reason="has no home without %USERPROFILE%")
def test_a_command_without_home_is_noticed_too() -> None:
    """Then the system is asked, which knows the user's real home."""
    command = [sys.executable, "-m", "woosh_pure", "connect", "--show"]
    with expected() as seen:
        subprocess.run(command, env={"PYTHONPATH": str(ROOT)}, capture_output=True, timeout=60, check=False)
    assert [line for line in seen if "profile.json" in line]


@pytest.mark.whole
def test_what_is_seen_fails_the_test(tmp_path: Path) -> None:
    """A run of pytest with a test that swallows the error, and one that does nothing."""
    (tmp_path / "conftest.py").write_text(
        "from tests.support.watched.plugin import begin, pytest_runtest_teardown\nbegin()\n"
    )
    (tmp_path / "test_it.py").write_text(
        f"def test_bad():\n    try: open({PROFILE!r})\n    except OSError: pass\ndef test_good(): pass\n"
    )
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-p", "no:randomly", "-p", "no:cacheprovider", "-q", str(tmp_path)],
        env={**os.environ, "PYTHONPATH": str(ROOT)}, cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    assert done.returncode == 1, done.stdout + done.stderr
    assert "2 passed, 1 error" in done.stdout
    assert "profile.json" in done.stdout


@pytest.mark.skipif(os.name == "nt", reason="Windows has no signals that are ignored from the start")
def test_tests_in_the_background_and_what_they_start_get_their_signals() -> None:
    """A shell without job control has its background programs ignore SIGINT, nohup SIGHUP; and it is inherited."""
    told = "import signal as s; print(s.SIG_IGN in (s.getsignal(s.SIGINT), s.getsignal(s.SIGHUP)))"
    told = f"import subprocess, sys; subprocess.call([sys.executable, '-S', '-c', {told!r}])"
    ours = f"from tests.support.watched import plugin; plugin.begin(); {told}"
    for code, ignored in ((told, "True"), (ours, "False")):
        begun = (
            "import signal as s, subprocess, sys; [s.signal(one, s.SIG_IGN) for one in (s.SIGINT, s.SIGHUP)]"
        )
        started = f"{begun}; sys.exit(subprocess.call([sys.executable, '-c', {code!r}]))"
        done = subprocess.run(
            [sys.executable, "-c", started], cwd=ROOT, capture_output=True, text=True, timeout=60
        )
        assert done.stdout.strip() == ignored, done
