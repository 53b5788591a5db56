"""How the commands end: by Ctrl-C and signals at any stage, readers that leave, full disks, closed streams."""

from __future__ import annotations

import contextlib
import http.server
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest

from rosproto import Master, Node
from tests.support.load import crowd
from woosh_pure import SimulatedChassis

pytestmark = pytest.mark.whole

if sys.platform == "win32":
    pytest.skip("sends POSIX signals and uses sh", allow_module_level=True)

ROOT = Path(__file__).resolve().parents[2]
ENVIRONMENT = {
    **{k: v for k, v in os.environ.items() if not k.startswith(("ROS_", "LC_", "PYTHONIOENCODING"))},
    "PYTHONPATH": str(ROOT),
}


@pytest.fixture(scope="module")
def graph() -> Iterator[SimpleNamespace]:
    """A master with a node that says something ten times a second."""
    with Master() as master, Node("/talker", master_uri=master.uri) as node:
        words = node.publisher("/words", "std_msgs/String")
        over = threading.Event()

        def talk() -> None:
            while not over.wait(0.1):
                words.publish(data="90° → 急停")

        thread = threading.Thread(target=talk, daemon=True)
        thread.start()
        yield SimpleNamespace(uri=master.uri, node=node)
        over.set()
        thread.join(5.0)


@pytest.fixture
def silent() -> Iterator[SimpleNamespace]:
    """Something that takes connections and never answers: its URI, and the socket."""
    with socket.create_server(("127.0.0.1", 0), backlog=20) as listener:
        listener.settimeout(20.0)
        yield SimpleNamespace(uri=f"http://127.0.0.1:{listener.getsockname()[1]}", socket=listener)


def start(*words: str, patient: bool = False, **environment: str) -> subprocess.Popen[str]:
    """`rosproto ...` or `woosh ...` in a process of its own."""
    module = {"woosh": "woosh_pure", "rosproto": "rosproto"}[words[0]]
    return subprocess.Popen(
        [sys.executable, "-u", *(("-c", PATIENT) if patient else ("-m",)), module, *words[1:]],
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, encoding="utf-8",
        errors="replace", env={**ENVIRONMENT, "PYTHONIOENCODING": "utf-8", **environment},
    )  # fmt: skip


PATIENT = """
import runpy, sys
from rosproto.transport.deadline import Deadline
begin = Deadline.__init__
Deadline.__init__ = lambda self, timeout, *more: begin(self, timeout and 20 * timeout, *more)
del sys.argv[0]
runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)
"""
"""Runs a module with time limits that are twenty times as long: what ends in time does not end by them."""


def shell(line: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """A line of bash; `woosh` and `rosproto` stand for the commands."""
    line = re.sub(r"\bwoosh ", f"{sys.executable} -m woosh_pure ", line)
    line = re.sub(r"\brosproto ", f"{sys.executable} -m rosproto ", line)
    return subprocess.run(
        ["bash", "-c", line], capture_output=True, text=True, encoding="utf-8", errors="backslashreplace",
        timeout=60, check=False, stdin=subprocess.DEVNULL, env={**ENVIRONMENT, **environment},
    )  # fmt: skip


def ended(process: subprocess.Popen[str], number: int) -> tuple[int, str]:
    """Send the signal; exit code and stderr."""
    process.send_signal(number)
    _, err = process.communicate(timeout=20)
    return process.returncode, err


@pytest.mark.parametrize(
    "line",
    ["rosproto topic list", "rosproto topic echo /x", "rosproto node ping /x", "rosproto service call /x", "rosproto tf tree",
     "rosproto topic pub /x std_msgs/String a", "woosh status", "woosh doctor", "woosh connect", "woosh learn", "woosh stop"],
)  # fmt: skip
def test_ctrl_c_while_it_connects(line: str, silent: SimpleNamespace) -> None:
    """No master answers yet: it ends at once, with code 130 and without a traceback."""
    address = [silent.uri] if line == "woosh connect" else ["--master", silent.uri]
    with start(*line.split(), *address, patient=True) as process:
        asked, _ = silent.socket.accept()
        code, err = ended(process, signal.SIGINT)
        assert (code, "Traceback" in err) == (130, False), err
        asked.close()


def test_a_master_that_keeps_silent_cannot_be_reached(
    silent: SimpleNamespace, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    """The same exit code as one that is not there."""
    from rosproto.cli import main

    monkeypatch.setattr("rosproto.cli.graph_clients.TIMEOUT", 0.3)
    assert main(["topic", "list", "--master", silent.uri]) == 4
    assert "no answer within" in capsys.readouterr().err


def test_a_web_server_is_no_master(capsys: pytest.CaptureFixture[str]) -> None:
    """It answers, even with 200: the sentence says where, and what it should have been. Code 4."""
    from rosproto.cli import main
    from woosh_pure.cli.entry import main as woosh

    class Page(http.server.BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            self.send_response(200)
            self.end_headers()
            self.wfile.write(b"<html>It works!</html>")

        def log_message(self, *_: object) -> None:
            pass

    with http.server.HTTPServer(("127.0.0.1", 0), Page) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        uri = f"http://127.0.0.1:{server.server_port}/"
        try:
            for run, words in ((main, ["topic", "list"]), (woosh, ["battery"])):
                assert run([*words, "--master", uri]) == 4
                said = capsys.readouterr().err
                assert f": {uri}: XML-RPC: <html> inside <document>; is this a ROS master or node?" in said
        finally:
            server.shutdown()


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGINT])
def test_a_signal_unregisters_the_node_of_a_command(graph: SimpleNamespace, number: int) -> None:
    """Nothing is left behind at the master."""
    with start("rosproto", "topic", "pub", "/left", "std_msgs/String", "a", "--master", graph.uri) as process:
        assert process.stdout is not None
        process.stdout.readline()
        assert "/left" in graph.node.master.get_system_state().publishers
        code, err = ended(process, number)
        assert (code, err) == (130 if number == signal.SIGINT else 143, "")
        assert "/left" not in graph.node.master.get_system_state().publishers


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_that_comes_twice_at_once_is_one(graph: SimpleNamespace, number: int) -> None:
    """`timeout` sends its signal to the command and to its group: the second must not cut the end short."""
    for _ in range(4):  # without care it is cut short every other time
        with start("rosproto", "topic", "hz", "/twice", "--master", graph.uri) as process:
            assert process.stdout is not None
            process.stdout.readline()
            process.send_signal(number)
            time.sleep(0.001)  # or the system makes one of them
            code, err = ended(process, number)
        assert "Traceback" not in err
        assert code in (130 if number == signal.SIGINT else 143, -number)  # the same to a shell
        assert "/twice" not in graph.node.master.get_system_state().subscribers


def test_nohup_is_respected(graph: SimpleNamespace) -> None:
    """A hang-up that is ignored stays ignored."""
    line = f"trap '' HUP; rosproto topic echo /words -n 12 --master {graph.uri} & sleep 0.9; kill -HUP $!; wait $!; echo code $?"
    assert "code 0" in shell(line).stdout


@pytest.mark.parametrize(
    ("line", "begun", "code"),
    [
        ("topic echo /words -n 400 --filter 'm.data != 1'", "-s out", 130),
        ("topic hz /words", "-s out", 130),
        ("bag record -O b.bag --duration 40 /words", "-s out", 0),
    ],
)
def test_an_interrupt_ends_what_a_script_has_in_the_background(
    line: str, begun: str, code: int, graph: SimpleNamespace, tmp_path: Path
) -> None:
    """A shell has SIGINT ignored in what it starts with `&`; rostopic obeys it all the same, and so does this."""
    run = f"cd {tmp_path}; rosproto {line} --master {graph.uri} > out 2>&1 &"
    wait = f"for i in {{1..300}}; do [ {begun} ] && break; sleep 0.05; done"
    assert shell(f"{run} {wait}; kill -INT $!; wait $!; echo code $?").stdout == f"code {code}\n"


@pytest.mark.promise("SIGQUIT (Ctrl-\\\\) or SIGHUP to a `woosh` command")
@pytest.mark.parametrize(("name", "code"), [("INT", 130), ("QUIT", 143), ("TERM", 143)])
def test_a_signal_stops_the_robot_of_a_background_job(
    name: str, code: int, sim: SimulatedChassis, real_time: Callable[[], None], until: Callable[..., None]
) -> None:
    """A shell has SIGINT and SIGQUIT ignored in what it starts with `&`."""

    def standing() -> bool:
        with sim.lock:
            return sim.world.body.velocity.is_standing()

    woosh = f"{sys.executable} -m woosh_pure move 9 --master {sim.master_uri}"
    line = f"{woosh} >&2 & echo $!; wait $!; echo code $?"
    with subprocess.Popen(["bash", "-c", line], stdout=subprocess.PIPE, text=True, env=ENVIRONMENT) as script:
        assert script.stdout is not None
        command = int(script.stdout.readline())
        try:
            until(lambda: not standing(), 30.0, "the motion")
            os.kill(command, getattr(signal, f"SIG{name}"))
            until(standing, 5.0 * crowd(), "the stop")
            assert script.stdout.readline() == f"code {code}\n"
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.kill(command, signal.SIGKILL)


@pytest.mark.parametrize(
    "line",
    ["rosproto msg list", "rosproto topic echo /words --master {uri}", "woosh led --list", "woosh faults --find e",
     "rosproto graph --all --master {uri}", "rosproto --help", "woosh --help"],
)  # fmt: skip
def test_a_reader_that_has_enough_is_no_error(line: str, graph: SimpleNamespace) -> None:
    done = shell(f"{line.format(uri=graph.uri)} | head -1; echo ${{PIPESTATUS[0]}}")
    assert done.stdout.splitlines()[-1] == "0", done
    assert done.stderr == ""


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="has no /dev/full")
@pytest.mark.parametrize(
    "line",
    [
        "rosproto msg list",
        "woosh led --list",
        "woosh led --list --json",
        "rosproto topic list --json --master {uri}",
    ],
)
def test_a_full_disk_is_one_sentence(line: str, graph: SimpleNamespace) -> None:
    # Buffered, as in a person's shell: what is left in the buffer must not fail once more at exit.
    done = shell(f"unset PYTHONUNBUFFERED; {line.format(uri=graph.uri)} > /dev/full; echo $?")
    assert done.stdout == "1\n"
    assert done.stderr.count("\n") == 1
    assert "cannot write the output: No space left" in done.stderr


@pytest.mark.parametrize(
    "line",
    [
        "rosproto topic echo /words -n 1 --master {uri}",
        "rosproto graph --master {uri}",
        "woosh led --list",
        "woosh led --list --json",
    ],
)
def test_a_closed_output_is_no_error(line: str, graph: SimpleNamespace) -> None:
    """`>&-`, as daemons and cron jobs have it."""
    done = shell(f"{line.format(uri=graph.uri)} >&-; echo $? >&2")
    assert done.stderr == "0\n"


@pytest.mark.parametrize("encoding", ["ascii", "cp1252", "cp936", "utf-8"])
def test_every_encoding_can_be_written(encoding: str, graph: SimpleNamespace) -> None:
    """What it lacks is put in other characters; nothing fails."""
    for line in (
        f"rosproto topic echo /words/data -n 1 --json --master {graph.uri}", "woosh faults --code 110201000013 --chinese",
        f"rosproto topic echo /words -n 1 -p --master {graph.uri}", "woosh rotate 9999", "woosh --help",
    ):  # fmt: skip
        done = shell(f"{line} 2>&1", PYTHONIOENCODING=encoding, PYTHONUTF8="0")
        assert "Error" not in done.stdout, done.stdout
        if encoding == "ascii":
            assert done.stdout.isascii()


@pytest.mark.skipif(shutil.which("dot") is None, reason="Graphviz is not installed")
@pytest.mark.parametrize("more", ["", "--all", "--node /talker"])
def test_graphviz_accepts_the_graph(more: str, graph: SimpleNamespace, tmp_path: Path) -> None:
    done = shell(f"rosproto graph {more} --format dot --master {graph.uri} | dot -Tsvg -o {tmp_path}/g.svg")
    assert done.stderr == ""
    assert "/words" in (tmp_path / "g.svg").read_text()


def test_errors_with_json_leave_stdout_to_json(graph: SimpleNamespace) -> None:
    """rosproto prints nothing there, woosh a document; the sentence is on stderr."""
    import json

    done = shell(f"rosproto topic info /nope --json --master {graph.uri}")
    assert (done.returncode, done.stdout) == (1, "")
    assert "see: rosproto topic list" in done.stderr
    done = shell("woosh battery --json --master http://127.0.0.1:1")
    assert json.loads(done.stdout)["exit_code"] == done.returncode == 4
    with contextlib.suppress(json.JSONDecodeError):
        pytest.fail(f"stderr is not a document: {json.loads(done.stderr)}")
