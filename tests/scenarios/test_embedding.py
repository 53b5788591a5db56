"""Inside other people's programs: web servers, event loops, windows, notebooks, processes, plug-ins.

Each example of examples/embedding runs in a host that checks that Ctrl-C, logging, threads and hooks are still its
own afterwards. Skipped with a reason where the third-party package is not installed; CI installs them.
"""

from __future__ import annotations

import importlib.util
import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import NoReturn

import pytest

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
        absent(f"needs {', '.join(missing)}: pip install flask PySide6-Essentials nbclient ipykernel")


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
    """Requests in several threads share one chassis."""
    need("flask")
    shown = run("flask_route.py")
    assert "{'percent': 87} {'arrived': True} 200 OK" in shown


def test_an_asyncio_service() -> None:
    """Subscriptions and services awaited in the application's own loop."""
    shown = run("asyncio_service.py")
    assert "battery 87 %" in shown
    assert "success: True" in shown


def test_a_qt_window() -> None:
    """A callback in our thread, a signal, a label in Qt's thread; offscreen."""
    need("PySide6")
    assert "battery 87 %" in run("qt_window.py", QT_QPA_PLATFORM="offscreen")


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


def test_importing_changes_nothing() -> None:
    """Threads, sockets, signals, environment, handlers, loaded event loops: the same before and after."""
    program = (
        "import logging, os, signal, socket, sys, threading\n"
        "import numpy  # sets a variable of its own\n"
        "def state():\n"
        "    return (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM), threading.active_count(),\n"
        "        dict(os.environ), list(logging.root.handlers), logging.root.level, socket.getdefaulttimeout(),\n"
        "        sys.excepthook, threading.excepthook, os.getcwd(), list(sys.path), list(sys.meta_path),\n"
        "        sorted(os.listdir('/proc/self/fd')) if os.path.isdir('/proc/self/fd') else 0)\n"
        "opened = []\n"
        "sys.addaudithook(lambda event, args: opened.append((event, args)) if event.startswith(('socket.', 'subprocess.',\n"
        "    'signal.', 'os.putenv', 'os.fork')) or event == 'open' and isinstance(args[1], str) and set(args[1]) & set('wax+')\n"
        "    else None)\n"
        "before = state()\n"
        "import rosproto, woosh_pure, msgdefs\n"
        "from rosproto import *\n"
        "from woosh_pure import Chassis, SimulatedChassis\n"
        "from msgdefs.std_msgs.msg import String\n"
        "from msgdefs.sensor_msgs.msg import LaserScan; LaserScan()\n"
        "import rosproto.aio, rosproto.cli, woosh_pure.cli\n"
        "assert state() == before, (before, state())\n"
        "opened = [o for o in opened if o[0] != 'socket.__new__' and not (o[0] == 'open' and str(o[1][0]).endswith('.pyc'))\n"
        "    and '__pycache__' not in str(o[1][0])]\n"
        "assert not opened, opened\n"
    )
    env = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False, env=env
    )
    assert done.returncode == 0, done.stderr
