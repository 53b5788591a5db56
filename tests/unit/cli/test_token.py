"""The token of a server: on the command line, in a file, or in the environment."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

import pytest

from rosproto.cli import add_token, token_of

VARIABLE = "TOKEN_OF_A_TEST"


def given(*words: str) -> str | None:
    parser = argparse.ArgumentParser(exit_on_error=False)
    add_token(parser, VARIABLE, "what everybody has to know")
    return token_of(parser.parse_args(words), VARIABLE)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "token"
    path.write_text("in-a-file\n")
    path.chmod(0o600)
    return path


def test_it_comes_from_where_it_was_put(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    assert given() is None
    assert given("--token", "typed") == "typed"
    assert given("--token-file", str(file)) == "in-a-file"
    monkeypatch.setenv(VARIABLE, "of-the-environment")
    assert given() == "of-the-environment"
    assert given("--token-file", str(file)) == "in-a-file", "what is said on the command line goes first"
    assert given("--token", "") == "", "an empty one is refused by the server, and is not another one"


def test_two_of_them_contradict_each_other(file: Path) -> None:
    with pytest.raises(argparse.ArgumentError, match="not allowed with"):
        given("--token", "typed", "--token-file", str(file))


@pytest.mark.skipif(os.name != "posix", reason="rights of POSIX")
def test_a_file_that_others_may_read_is_refused(file: Path) -> None:
    file.chmod(0o640)
    with pytest.raises(ValueError, match="chmod 600"):
        given("--token-file", str(file))


def test_a_file_without_a_token_is_refused(file: Path, tmp_path: Path) -> None:
    file.write_text(" \n")
    with pytest.raises(ValueError, match="no token in it"):
        given("--token-file", str(file))
    with pytest.raises(ValueError, match="is a folder"):
        given("--token-file", str(tmp_path))
    with pytest.raises(OSError):
        given("--token-file", str(tmp_path / "none"))
