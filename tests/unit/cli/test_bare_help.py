"""`--help` alone comes from a text made beforehand, and is what the parser would have shown."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import rosproto.cli
import woosh_pure.cli
from rosproto.cli import bare_help

ROOT = Path(__file__).resolve().parents[3]
ENTRIES = {"rosproto": rosproto.cli, "woosh_pure": woosh_pure.cli}


def ran(module: str, *words: str, columns: int = 80, before: str = "") -> subprocess.CompletedProcess[str]:
    program = f"import sys; from {module}.cli import main; {before}\ncode = main()\n"
    program += "print('argparse' in sys.modules, file=sys.stderr); sys.exit(code)"
    return subprocess.run(
        [sys.executable, "-c", program, *words],
        capture_output=True,
        text=True,
        encoding="utf-8",
        cwd=ROOT,
        timeout=60,
        check=False,
        env={**os.environ, "COLUMNS": str(columns), "NO_COLOR": "1"},
    )


@pytest.mark.parametrize("module", ENTRIES)
@pytest.mark.parametrize("word", ["--help", "-h"])
def test_help_alone_loads_no_parser_and_shows_what_the_parser_shows(
    module, word, capsys, monkeypatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("NO_COLOR", "1")
    with pytest.raises(SystemExit) as ended:
        ENTRIES[module].main([word])  # words that a program hands over are the parser's
    assert ended.value.code == 0
    done = ran(module, word)
    assert (done.returncode, done.stdout, done.stderr) == (0, capsys.readouterr().out, "False\n")


@pytest.mark.parametrize("module", ENTRIES)
def test_without_a_word_the_help_goes_to_stderr_with_code_2(module, capsys, monkeypatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("NO_COLOR", "1")
    assert ENTRIES[module].main([]) == 2
    done = ran(module)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == capsys.readouterr().err + "False\n"


@pytest.mark.parametrize("module", ENTRIES)
def test_a_narrow_terminal_asks_the_parser_and_a_wide_one_does_not(module) -> None:
    narrow, usual, wide = (ran(module, "--help", columns=columns) for columns in (50, 80, 200))
    assert len(narrow.stdout.splitlines()) > len(usual.stdout.splitlines()) * 1.2
    assert wide.stdout == usual.stdout


def test_what_is_more_than_help_is_the_parsers(monkeypatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    for words in (["--json", "--help"], ["ready"], ["ready", "--help"], ["--version"], ["--help", "x"]):
        assert bare_help.show(rosproto.cli.__file__, words) is None


def test_where_the_text_is_missing_the_parser_is_asked(tmp_path, monkeypatch) -> None:
    """As in a program that was frozen without it."""
    monkeypatch.setenv("COLUMNS", "80")
    assert bare_help.show(str(tmp_path / "cli.py"), ["--help"]) is None


@pytest.mark.parametrize("module", ENTRIES)
def test_without_any_output_help_is_no_error(module) -> None:
    """A shell has closed it (`>&-`), or the reader has gone and nothing is buffered."""
    assert ran(module, "--help", before="sys.stdout = None").returncode == 0
    broken = "import io; sys.stdout = type('Gone', (io.StringIO,), {'write': lambda *_: (_ for _ in ()).throw(BrokenPipeError())})()"
    assert ran(module, "--help", before=broken).returncode == 0


@pytest.mark.parametrize("module", ENTRIES)
def test_the_text_needs_no_character_that_a_terminal_may_lack(module) -> None:
    assert Path(str(ENTRIES[module].__file__)).with_name(bare_help.FILE).read_bytes().isascii()


@pytest.mark.parametrize("set_to", ["", "0", "-1", "many"])
def test_a_width_that_is_none_is_the_usual_one(set_to, monkeypatch) -> None:
    """As shutil.get_terminal_size has it; this process has no terminal."""
    import shutil

    monkeypatch.setenv("COLUMNS", set_to)
    monkeypatch.setattr(sys, "__stdout__", None)
    assert bare_help._columns() == shutil.get_terminal_size().columns == 80
