"""Ctrl-C while a command is being imported: it ends at once, with code 130 and without a traceback."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

if sys.platform == "win32":
    pytest.skip("sends POSIX signals", allow_module_level=True)

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize(
    ("line", "imported"),
    [
        ("rosproto topic list", "rosproto.cli.console"),
        ("rosproto bag record -a", "rosproto.cli.output"),
        ("rosproto graph", "rosproto.cli.parser"),
        ("woosh_pure record", "rosproto.cli.console"),
        ("woosh_pure --sim record", "woosh_pure.cli.commands"),
        ("woosh_pure status", "woosh_pure.language"),
    ],
)
def test_ctrl_c_while_it_imports(line: str, imported: str) -> None:
    """At a module of each stage, from the first that follows the handler to those of the command."""
    with subprocess.Popen(
        [sys.executable, "-X", "importtime", "-m", *line.split()],
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT,
    ) as process:  # fmt: skip
        assert process.stderr is not None
        started = False
        for text in process.stderr:
            name = text.rpartition("|")[2].strip()
            if started and name == imported:
                break
            started = started or name == "rosproto.startup"
        else:
            pytest.fail(f"{imported} was not imported")
        process.send_signal(signal.SIGINT)
        rest = [text for text in process.stderr if not text.startswith("import time:")]
        assert (process.wait(20.0), rest) == (130, [])


PROGRAM = """
import signal
assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
print("as in Python")
"""


@pytest.mark.parametrize("words", [["rosproto", "run"], ["woosh_pure", "run"]])
def test_a_program_of_the_user_gets_the_signal_as_in_python(tmp_path: Path, words: list[str]) -> None:
    """`run` gives Ctrl-C back before the program begins."""
    program = tmp_path / "program.py"
    program.write_text(PROGRAM)
    done = subprocess.run(
        [sys.executable, "-m", *words, str(program)],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        cwd=ROOT,
    )
    assert (done.returncode, done.stdout) == (0, "as in Python\n"), done.stderr
