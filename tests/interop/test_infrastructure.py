"""The helpers for real ROS work themselves: generators, compiler, processes."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from rosproto.codec import message_class
from tests.support import ros, ros_process


def test_generated_python_packages_import_beside_debians(genpy_packages: Path, real_roscore: str) -> None:
    """woosh_msgs comes from our definitions; packages Debian has are Debian's, with their code."""
    code = (
        "import woosh_msgs.msg, woosh_msgs.srv, std_srvs.srv, nav_msgs.msg, sensor_msgs.msg, actionlib, std_msgs\n"
        "print(std_msgs.__file__, len([n for n in dir(woosh_msgs.msg) if n[0] != '_']), actionlib.SimpleActionClient)"
    )
    done = ros.run_rospy(code, real_roscore, packages=genpy_packages)
    assert done.stdout.startswith("/usr/lib/python3/dist-packages/std_msgs")


def test_generated_cpp_headers_compile(roscpp_peer: Path, shared_directory: Path) -> None:
    """A C++ node with one of our own types builds and runs, and is built once."""
    with ros.start_program(roscpp_peer, "http://127.0.0.1:1", "md5sum") as running:
        running.wait_for(f"^{message_class('woosh_msgs/RobotStatus')._md5sum}$")
    source = Path(__file__).with_name("roscpp_peer.cpp").read_text("utf-8")
    assert ros.build_cpp_node("roscpp_peer", source, shared_directory, ros.MSGDEFS / "none") == roscpp_peer


def test_a_hanging_program_is_ended_with_its_children(real_roscore: str) -> None:
    """Time limits hold, and waiting for output tells what came instead."""
    code = "import subprocess, sys; print('up', flush=True); subprocess.run(['sleep', '100'])"
    with pytest.raises(AssertionError, match="did not end within"):
        ros.run_rospy(code, real_roscore, timeout=1.0)
    with ros.start_rospy(code, real_roscore) as running:
        running.wait_for("up")
        with pytest.raises(AssertionError, match="without writing 'never'"):
            running.wait_for("never", timeout=0.05)


AS_USUAL = [
    "import os, sys, rospy; print(sys.argv, __name__, os.getcwd(), os.getpgid(0) == os.getpid(), sys.stdin.read())",
    "import os, sys; print(sorted(os.environ.items()), [p for p in sys.path if 'ros_warm' in p or not p], sys.flags)",
    "import atexit, sys; atexit.register(print, 'at the end'); print('to stderr', file=sys.stderr); sys.exit('a word')",
    "def f(): raise ValueError('no')\nf()",
    "import os, signal; os.kill(os.getpid(), signal.SIGINT)",
    "import os; os._exit(7)",
    "import threading, time; threading.Thread(target=lambda: (time.sleep(0.1), print('it waits for threads'))).start()",
]


@pytest.mark.parametrize("code", AS_USUAL, ids=range(len(AS_USUAL)))
def test_a_warm_python_is_as_one_that_is_started(ros_installed: None, code: str, tmp_path: Path) -> None:
    """Exit code and both streams; `start_rospy` and the tools run in such processes."""
    env = ros.environment("http://127.0.0.1:1", packages=tmp_path)
    script = tmp_path / "program.py"
    script.write_text(code)
    for arguments in (["-c", code, "one", "two"], [str(script), "one"]):
        warm = ros_process.run([ros.PYTHON, *arguments], env, 60.0, check=False)
        cold = subprocess.run(
            [ros.PYTHON, *arguments], env=env, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60,
            start_new_session=True,
        )  # fmt: skip
        assert (warm.returncode, warm.stdout) == (cold.returncode, cold.stdout)
        assert warm.stderr.splitlines()[-1:] == cold.stderr.splitlines()[-1:]


def test_absence_is_a_skip_or_a_failure(monkeypatch: pytest.MonkeyPatch) -> None:
    """REQUIRE_INTEROP=1 turns the one into the other."""
    monkeypatch.delenv("REQUIRE_INTEROP", raising=False)
    with pytest.raises(pytest.skip.Exception, match="no peer"):
        ros.require(False, "no peer")
    monkeypatch.setenv("REQUIRE_INTEROP", "1")
    with pytest.raises(pytest.fail.Exception, match="no peer"):
        ros.require(False, "no peer")
    ros.require(True, "no peer")
