"""`rosproto master` in a process of its own, and the command's frame."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from rosproto.cli import main
from rosproto.cli.entry import COMMANDS
from rosproto.node import Node
from rosproto.node.graph.master_client import MasterClient

ROOT = Path(__file__).resolve().parents[3]
TIMEOUT = 30.0


@contextmanager
def command(*arguments: str) -> Iterator[subprocess.Popen[str]]:
    process = subprocess.Popen(
        [sys.executable, "-m", "rosproto", *arguments],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )
    try:
        yield process
    finally:
        process.kill()
        process.communicate(timeout=TIMEOUT)


def first_line(process: subprocess.Popen[str]) -> str:
    assert process.stdout is not None
    return process.stdout.readline().strip()


def test_the_port_may_be_given_as_to_roscore() -> None:
    """`-p`, in one word too."""
    for words in (["-p", "0"], ["-p0"]):
        with command("master", *words) as process, MasterClient(first_line(process), "/test") as client:
            assert client.get_pid() == process.pid


@pytest.mark.skipif(sys.platform == "win32", reason="signals of Windows are sent another way")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_it_serves_until_a_signal_and_ends_with_zero(number: signal.Signals) -> None:
    """The URI is the one line of output; Ctrl-C and SIGTERM are its orderly end."""
    with command("master", "--port", "0") as process:
        uri = first_line(process)
        with MasterClient(uri, "/test") as client:
            assert client.get_pid() == process.pid
            assert client.get_param("/rosdistro") == "noetic\n"
        process.send_signal(number)
        out, err = process.communicate(timeout=TIMEOUT)
        assert (process.returncode, out, err) == (0, "", "")


def test_what_the_nodes_say_goes_into_a_file(tmp_path: Path) -> None:
    """--rosout-log, as roscore's rosout.log; a folder that is not there is one sentence."""
    file = tmp_path / "rosout.log"
    with command("master", "--port", "0", "--rosout-log", str(file)) as process:
        with Node("/speaker", master_uri=first_line(process)) as node:
            node.logger.warning("the floor is wet")
            end = time.monotonic() + TIMEOUT
            while " [topics: /rosout] the floor is wet\n" not in file.read_text("utf-8"):
                assert time.monotonic() < end, file.read_text("utf-8")
                node.logger.warning("the floor is wet")
                time.sleep(0.02)
        assert " WARN /speaker [test_master.py:" in file.read_text("utf-8")
    with command("master", "--port", "0", "--rosout-log", str(tmp_path / "no" / "folder")) as process:
        out, err = process.communicate(timeout=TIMEOUT)
        assert (process.returncode, out, err.count("\n")) == (1, "", 1)
        assert "No such file" in err


def test_a_shutdown_call_from_this_computer_ends_it() -> None:
    """As rosmaster's API has it; the caller gets its reply first."""
    with command("master", "--port", "0") as process:
        with MasterClient(first_line(process), "/test") as client:
            client.shutdown("enough")
        assert process.wait(TIMEOUT) == 0


def test_a_taken_port_is_one_sentence_and_exit_code_one() -> None:
    """The sentence names the address; no traceback."""
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with command("master", "--port", str(port)) as process:
            out, err = process.communicate(timeout=TIMEOUT)
    assert process.returncode == 1
    assert out == ""
    assert err.count("\n") == 1
    assert f"127.0.0.1:{port}" in err
    assert "taken" in err


@pytest.mark.parametrize("port", ["x", "65536", "1.5", ""])
def test_a_port_that_is_none_is_wrong_usage(port: str, capsys: pytest.CaptureFixture[str]) -> None:
    """argparse's exit code 2, and the text says what was expected."""
    with pytest.raises(SystemExit) as ended:
        main(["master", "--port", port])
    assert ended.value.code == 2
    assert "0 to 65535" in capsys.readouterr().err


def test_without_a_command_the_commands_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    """On stderr, with the exit code of wrong usage."""
    assert main([]) == 2
    shown = capsys.readouterr().err
    assert all(name in shown for name in COMMANDS)


@pytest.mark.parametrize("name", sorted(COMMANDS))
def test_every_command_has_help(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Each module in the table can be imported and describes itself."""
    with pytest.raises(SystemExit) as ended:
        main([name, "--help"])
    assert ended.value.code == 0
    assert COMMANDS[name].help[:20] in " ".join(capsys.readouterr().out.split())
