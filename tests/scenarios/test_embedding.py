"""Inside other people's programs: web servers, event loops, windows, notebooks, processes, plug-ins.

Each example of examples/embedding runs in a host that checks that Ctrl-C, logging, threads and hooks are still its
own afterwards. Skipped with a reason where the third-party package is not installed; CI installs them.
"""

from __future__ import annotations

import importlib.metadata
import importlib.util
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import pytest

from tests.support.extras import needs
from tests.support.waiting import until
from woosh_pure import Chassis, SimulatedChassis

if TYPE_CHECKING:
    from tests.support.web import Served

# Each starts a program of its own; some load a framework of a hundred megabytes first.
pytestmark = [pytest.mark.slow, pytest.mark.example]

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples" / "embedding"
HOST = Path(__file__).with_name("embedding_host.py")


def absent(reason: str) -> NoReturn:
    """Skip; fail instead with REQUIRE_EMBEDDING=1."""
    if os.environ.get("REQUIRE_EMBEDDING") == "1":
        pytest.fail(f"REQUIRE_EMBEDDING=1, but: {reason}")
    pytest.skip(reason)


def need(*modules: str) -> None:
    """These third-party modules are there."""
    missing = [m for m in modules if importlib.util.find_spec(m) is None]
    if missing:
        absent(f"needs {', '.join(missing)}: pip install flask PySide6-Essentials!=6.12.0 nbclient ipykernel")


def need_qt() -> None:
    """Qt is there, and its signals do not end Python: from 3.12 on nobody counts the references to True."""
    need("PySide6")
    if sys.version_info < (3, 12) and importlib.metadata.version("PySide6_Essentials") == "6.12.0":
        absent(
            "each signal of PySide6 6.12.0 takes a reference to True away, and after some hundreds Python ends"
            " ('deallocating True or False'): pip install 'PySide6-Essentials!=6.12.0'"
        )


def run(name: str, *wrapper: str, **environment: str) -> str:
    """Run an example in the host; its output."""
    env = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONIOENCODING": "utf-8", **environment}
    env.pop("ROS_MASTER_URI", None)
    done = subprocess.run(
        [*wrapper, sys.executable, str(HOST), str(EXAMPLES / name)],
        capture_output=True, text=True, encoding="utf-8", timeout=100, check=False, env=env, stdin=subprocess.DEVNULL,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Traceback" not in done.stderr, done.stderr
    assert done.stdout.splitlines()[-1] == f"host unharmed {name}", done.stdout
    return done.stdout


def test_a_flask_route() -> None:
    """A bad number is answered with 422, a good one begins a drive; requests share one chassis."""
    need("flask")
    shown = run("flask_route.py")
    assert "422 UNPROCESSABLE ENTITY 202 ACCEPTED\n200 OK {'connected': True, 'percent': 87" in shown


def test_a_fastapi_lifespan() -> None:
    """The same by FastAPI; the chassis is opened in the server's loop and used in the threads of its routes."""
    pytest.importorskip("fastapi")
    pytest.importorskip("httpx", reason="FastAPI's test client needs it")
    assert "422 202\n200 {'percent': 87, 'connected': True" in run("fastapi_lifespan.py")


@contextmanager
def serving(name: str, address: str) -> Iterator[Served]:
    """The example as a server in a process of its own, until Ctrl-C."""
    from tests.support.web import Served

    env = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": "1"}
    command = [sys.executable, str(EXAMPLES / name), "--stay", "--port", "0", address]
    with subprocess.Popen(
        command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True, env=env
    ) as process:
        said = []
        late = threading.Timer(60.0, process.kill)
        late.start()
        try:
            assert process.stderr is not None
            for line in process.stderr:
                said.append(line)
                if found := re.search(r"unning on http://127\.0\.0\.1:(\d+)", line):
                    break
            else:
                pytest.fail("".join(said))
            rest = threading.Thread(target=lambda: said.extend(process.stderr or ()), daemon=True)
            rest.start()
            yield Served(int(found[1]))
            process.send_signal(signal.SIGINT)
            process.wait(20)
            rest.join(20)
        finally:
            late.cancel()
            process.kill()
    assert "Traceback" not in "".join(said), "".join(said)


@pytest.mark.skipif(sys.platform == "win32", reason="sends a POSIX signal")
@pytest.mark.parametrize(
    ("name", "module"), [("flask_route.py", "flask"), ("fastapi_lifespan.py", "uvicorn")]
)
def test_a_page_of_an_application(name: str, module: str) -> None:
    """422 for bad numbers, a drive that is followed to its end, STOP while another drive is under way, a lost
    connection; a page of another site may stop the robot, and not drive it. Ctrl-C ends the drive under way.
    """
    need(module)
    needs("web")  # of the client
    with SimulatedChassis(speed=2, full_graph=False) as sim, Chassis(sim.master_uri) as witness:
        with serving(name, sim.master_uri) as page:
            for number in ("far", "nan", "inf", "1e999", "20", "-11", "0,5", ""):
                assert page.ask("POST", f"/move?metres={number}").status == 422, number
            assert sim.pose.x == pytest.approx(0.0, abs=0.01)
            goal = page.ask("POST", "/move?metres=0.3")
            assert goal.status == 202
            until(lambda: page.ask("GET", f"/goals/{goal.json['number']}").json["done"], timeout=30)
            assert page.ask("GET", f"/goals/{goal.json['number']}").json["arrived"] is True
            assert sim.pose.x == pytest.approx(0.3, abs=0.05)
            assert page.ask("GET", "/goals/99").status == 404
            foreign = {"origin": "http://evil.example"}
            assert page.ask("POST", "/move?metres=1", headers=foreign).status == 403
            assert page.ask("POST", "/move?metres=2").status == 202
            witness.measured_velocity.wait_for(lambda velocity: velocity.vx > 0.1, timeout=20)
            assert page.ask("POST", "/move?metres=1").status == 409  # one motion at a time
            stopped = page.ask("POST", "/stop", headers=foreign)
            assert (stopped.status, stopped.json["stands_still"]) == (200, True)
            assert page.ask("GET", "/status").json["connected"] is True
            sim.fall_silent(5.0)
            until(lambda: not page.ask("GET", "/status").json["connected"], timeout=10)
            until(lambda: page.ask("GET", "/status").json["connected"], timeout=20)
            assert page.ask("POST", "/move?metres=2").status == 202
            witness.measured_velocity.wait_for(lambda velocity: velocity.vx > 0.1, timeout=20)
        witness.measured_velocity.wait_for(lambda velocity: abs(velocity.vx) < 0.01, timeout=10)
        assert sim.pose.x < 2.0


@pytest.mark.parametrize(
    ("module", "begin"),
    [
        ("uvloop", "import uvloop; uvloop.install()"),
        ("gevent", "from gevent import monkey; monkey.patch_all()"),
    ],
)
def test_another_event_loop(module: str, begin: str) -> None:
    """uvloop under `rosproto.aio`; gevent in the place of threads, sockets and locks, time limits included."""
    pytest.importorskip(module)
    example = str(EXAMPLES / "asyncio_service.py")
    late = (
        "from threading import Event\n"
        "with rosproto.Master() as master, rosproto.Node('/n', master_uri=master.uri) as node:\n"
        "    with node.service_server('/late', 'std_srvs/SetBool', lambda request: Event().wait(3)):\n"
        "        try:\n"
        "            node.service_client('/late', 'std_srvs/SetBool').call(data=True, timeout=0.2)\n"
        "        except rosproto.RosTimeout:\n"
        "            print('in time')\n"
    )
    program = f"{begin}\nimport rosproto, runpy\nrunpy.run_path({example!r}, run_name='__main__')\n{late}"
    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", program],
        capture_output=True, text=True, timeout=60, check=False, env=env,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "success: True" in done.stdout
    assert "battery 87 %" in done.stdout
    assert done.stdout.endswith("in time\n")


def test_an_asyncio_service() -> None:
    """Subscriptions and services awaited in the application's own loop."""
    shown = run("asyncio_service.py")
    assert "battery 87 %" in shown
    assert "success: True" in shown


def test_a_qt_window() -> None:
    """Callbacks in our threads, signals, a window that drives to a mark; offscreen."""
    need_qt()
    assert "m left" in run("qt_window.py", QT_QPA_PLATFORM="offscreen")


QT_PERSON = """
import sys, time
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication
from qt_window import Window
from woosh_pure import Chassis, SimulatedChassis

def until(condition):
    end = time.monotonic() + 30
    while not condition():
        assert time.monotonic() < end, (window.goal.text(), window.stopped.text(), window.lost.text())
        QTest.qWait(20)

def press(button):
    began = time.monotonic()
    QTest.mousePress(button, Qt.MouseButton.LeftButton)
    QTest.mouseRelease(button, Qt.MouseButton.LeftButton)
    return time.monotonic() - began

app = QApplication([])
with SimulatedChassis(speed=2, full_graph=False) as sim, Chassis(sim.master_uri) as chassis:
    window = Window(chassis)
    window.show()
    until(lambda: window.marks["B1"].isEnabled() and window.map.grid is not None)
    assert not window.lost.isVisible()
    press(window.marks["P1"])
    until(lambda: "arrived" in window.goal.text())
    press(window.marks["B1"])
    until(lambda: chassis.measured_velocity.latest is not None and chassis.measured_velocity.latest.vx > 0.1)
    press(window.stop)
    until(lambda: "the robot stands still" in window.stopped.text())
    until(lambda: "cancelled" in window.goal.text())
    print("stopped")
    press(window.marks["B1"])
    press(window.stop)  # before the drive has begun
    until(lambda: window.stopped.text() != "stopping ...")
    window.commands.submit(int).result(30)
    until(lambda: window.goal.text() != "B1: sent ...")
    assert "arrived" not in window.goal.text()
    print("not begun:", window.goal.text())
    sim.drop_link(6.0)
    until(window.lost.isVisible)
    assert window.stop.isEnabled() and not window.marks["B1"].isEnabled()
    assert press(window.stop) < 0.2, "the window waited for the network"
    until(lambda: window.stopped.text() != "stopping ...")
    print("without a link:", window.stopped.text())
    until(lambda: not window.lost.isVisible())  # it is heard again
    print("heard again")
    window.leave()
"""


def test_a_person_at_the_qt_window() -> None:
    """Drives, stops, stops a drive that has not begun, and sees a lost connection; the window never waits."""
    need_qt()
    env = {**os.environ, "PYTHONPATH": f"{ROOT}{os.pathsep}{EXAMPLES}", "QT_QPA_PLATFORM": "offscreen"}
    done = subprocess.run(
        [sys.executable, "-c", QT_PERSON], capture_output=True, text=True, timeout=100, check=False, env=env
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Traceback" not in done.stderr, done.stderr
    begin = [line.partition(":")[0] for line in done.stdout.splitlines()]
    assert begin == ["stopped", "not begun", "without a link", "heard again"], done.stdout


def test_a_tk_window() -> None:
    """Tk's thread looks at `latest`."""
    pytest.importorskip("_tkinter", reason="this Python was built without Tk, and pip has none")
    wrapper: list[str] = []
    if sys.platform == "linux" and not os.environ.get("DISPLAY"):
        xvfb = shutil.which("xvfb-run")
        if xvfb is None:
            absent(
                "Tk has no offscreen mode: needs a display, or xvfb-run (Debian: apt-get install xvfb xauth)"
            )
        wrapper = [xvfb, "-a"]
    assert "battery 87 %" in run("tk_window.py", *wrapper)


def test_processes_started_by_spawn() -> None:
    """Each opens its own connections; messages travel as pickles."""
    assert run("spawned_processes.py").count("battery 87 %, 1.0") == 2


def test_a_plugin_that_is_reloaded() -> None:
    """No thread, no registration stays behind."""
    shown = run("plugin_reload.py")
    assert "plug-in 1: battery 87 %\nplug-in 2: battery 87 %\nthreads left over: 0" in shown


def test_a_notebook() -> None:
    """Every cell runs in a real kernel, the awaiting one too."""
    need("nbclient", "ipykernel")
    program = (
        "import nbformat, nbclient, sys, json\n"
        "book = nbformat.read(sys.argv[1], 4)\n"
        "nbclient.NotebookClient(book, timeout=60).execute()\n"
        "print(json.dumps([o for c in book.cells for o in c.get('outputs', [])]))\n"
    )
    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-c", program, str(EXAMPLES / "notebook.ipynb")],
        capture_output=True, text=True, timeout=100, check=False, env=env,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    outputs = json.loads(done.stdout.splitlines()[-1])
    texts = [o.get("text") or o["data"]["text/plain"] for o in outputs if o.get("name") != "stderr"]
    assert texts == ["87", "moved\n", "heard 87\n"], outputs


@pytest.mark.skipif(sys.platform == "win32", reason="sends a POSIX signal")
def test_ctrl_c_ends_an_application_at_once() -> None:
    """KeyboardInterrupt comes up in the application's main thread, the `with` blocks close, nothing hangs."""
    program = (
        "from woosh_pure import Chassis, SimulatedChassis\n"
        "with SimulatedChassis(full_graph=False) as sim, Chassis(sim.master_uri) as chassis:\n"
        "    chassis.battery.wait(timeout=20)\n"
        "    try:\n"
        "        print('up', flush=True)\n"
        "        chassis.battery.wait_for(lambda b: b.percent < 0, timeout=60)\n"
        "    except KeyboardInterrupt:\n"
        "        print('mine', flush=True)\n"
    )
    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    with subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=env
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "up\n"
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=20)
    assert (out, process.returncode) == ("mine\n", 0), err


IMPORT_ALL = """
import importlib, pkgutil, sys
import numpy, lz4.frame, pytest  # what others load has effects of its own: numpy sets a variable, pytest a hook
import uvicorn.protocols.websockets.websockets_sansio_impl  # one for the exit; loaded when a web server is made
from tests.support import process_state
opened = []
watched = ("socket.", "subprocess.", "signal.", "os.putenv", "os.fork", "os.remove", "os.rename", "os.mkdir")

def note(event, arguments):
    writes = event == "open" and isinstance(arguments[1], str) and set(arguments[1]) & set("wax+")
    if event.startswith(watched) or writes:
        opened.append((event, arguments))

before = process_state.state()
sys.addaudithook(note)
import rosproto, woosh_pure, msgdefs
modules = 0
for package in (rosproto, woosh_pure, msgdefs):
    for found in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
        own_process = found.name.startswith(("rosproto.rospy", "rosproto._pyinstaller"))
        if not own_process and not found.name.endswith("__main__"):
            importlib.import_module(found.name)
            modules += 1
from rosproto import *
from woosh_pure import *
from msgdefs.sensor_msgs.msg import LaserScan; LaserScan()
changed = process_state.changes(before, process_state.state())
assert not changed, changed
# The class of a socket is made ready by `socket` itself; nothing is connected.
opened = [(event, arguments) for event, arguments in opened if event != "socket.__new__"]
assert not opened, opened
print(modules, "modules")
"""


@pytest.mark.promise("A library leaves the time-outs, signals and streams")
def test_importing_changes_nothing() -> None:
    """Every module, imported: threads, files, signals, environment, logging, hooks and what else a program has."""
    needs("web")
    env = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(
        [sys.executable, "-c", IMPORT_ALL], capture_output=True, text=True, timeout=60, check=False, env=env
    )
    assert done.returncode == 0, done.stderr
    assert int(done.stdout.split()[0]) > 250


def test_the_watch_over_a_process_sees_each_change() -> None:
    """A check that cannot fail checks nothing."""
    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-m", "tests.support.process_state"],
        capture_output=True, text=True, timeout=60, check=False, env=env,
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (0, "all seen\n"), done.stderr


SESSION = """
import sys, threading
from msgdefs.std_msgs.msg import String
import rosproto
from woosh_pure import Chassis, SimulatedChassis

def trace(*_):
    return trace

if "trace" in sys.argv:  # a debugger, coverage: seen by every thread of ours
    threading.settrace(trace); threading.setprofile(lambda *_: None)
with SimulatedChassis(speed=8, full_graph=False) as sim, Chassis(sim.master_uri) as chassis:
    assert chassis.battery.wait(timeout=20).percent == 87
    chassis.move(0.1).wait(timeout=30)
    assert chassis.stop().standing
    with rosproto.Node("/other", master_uri=sim.master_uri) as node:
        node.params["/p"] = 1
        with node.publisher("/words", String, latch=True) as words, node.subscriber("/words") as heard:
            words.publish(data="x")
            assert heard.next(10).data == "x"
print("done")
"""


@pytest.mark.parametrize(
    "options",
    [
        # Every warning an error, every unclosed socket or file a warning.
        ["-X", "dev", "-W", "error"],
        ["-OO", "-bb", "-I", "-X", "utf8=0"],  # no docstrings, no assertions, nothing of the environment
        ["trace"],
    ],
    ids=" ".join,
)
def test_a_session_under_options_of_the_interpreter(options: list[str]) -> None:
    """Silent on stderr, and a clean end."""
    flags = [o for o in options if o != "trace"]
    begin = f"import sys; sys.path.insert(0, {str(ROOT)!r})\n"
    done = subprocess.run(
        [sys.executable, *flags, "-c", begin + SESSION, *(["trace"] if not flags else [])],
        capture_output=True, text=True, timeout=90, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stdout, done.stderr) == (0, "done\n", "")
