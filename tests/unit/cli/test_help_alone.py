"""`--help` of both commands, and what they say without any word."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
MODULES = ("rosproto", "woosh_pure")


def ran(module: str, *words: str, before: str = "") -> subprocess.CompletedProcess[str]:
    program = f"import sys; from {module}.cli import main; {before}\nsys.exit(main())"
    return subprocess.run(
        [sys.executable, "-c", program, *words],
        capture_output=True,
        text=True,
        encoding="utf-8",
        cwd=ROOT,
        timeout=60,
        check=False,
        env={**os.environ, "COLUMNS": "80", "NO_COLOR": "1"},
    )


@pytest.mark.parametrize("module", MODULES)
def test_without_a_word_the_help_goes_to_stderr_with_code_2(module) -> None:
    """With `--help` or `-h` it is an answer, so the same text goes to stdout."""
    asked = ran(module, "--help")
    assert (asked.returncode, asked.stderr) == (0, "")
    assert asked.stdout.startswith("usage: ")
    short, silent = ran(module, "-h"), ran(module)
    assert (short.returncode, short.stdout, short.stderr) == (0, asked.stdout, "")
    assert (silent.returncode, silent.stdout, silent.stderr) == (2, "", asked.stdout)


@pytest.mark.parametrize("module", MODULES)
def test_without_any_output_help_is_no_error(module) -> None:
    """A shell has closed it (`>&-`), or the reader has gone and nothing is buffered."""
    assert ran(module, "--help", before="sys.stdout = None").returncode == 0
    gone = "import io; sys.{} = type('Gone', (io.StringIO,), {{'write': lambda *_: (_ for _ in ()).throw(BrokenPipeError())}})()"
    assert ran(module, "--help", before=gone.format("stdout")).returncode == 0
    assert ran(module, "--version", before=gone.format("stdout")).returncode == 0
    assert ran(module, before=gone.format("stderr")).returncode == 2
    assert ran(module, "--unknown", before=gone.format("stderr")).returncode == 2


@pytest.mark.parametrize("module", MODULES)
def test_the_help_needs_no_character_that_a_terminal_may_lack(module) -> None:
    assert ran(module, "--help").stdout.isascii()
