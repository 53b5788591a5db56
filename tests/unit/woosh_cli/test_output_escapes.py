"""What `woosh` prints: one line is one line, and of controls only our own colours get to the terminal."""

from __future__ import annotations

import io
import json

import pytest

from rosproto.cli import output
from rosproto.cli.console import escape_what_cannot_be_printed
from tests.support.hostile_peer import RAW, wrongs_of
from woosh_pure.cli.output import Output


class Terminal(io.StringIO):
    encoding = "utf-8"  # type: ignore[assignment]

    def isatty(self) -> bool:
        return True


def test_a_line_is_one_line() -> None:
    """Whatever a peer has written into it."""
    stream = io.StringIO()
    Output(stream=stream).line(f"refused by the chassis: {RAW}")
    assert stream.getvalue().count("\n") == 1
    assert wrongs_of(stream.getvalue()) == []


def test_only_our_own_colours_are_coloured(monkeypatch: pytest.MonkeyPatch) -> None:
    """A peer that writes the very sequences of our colours gets them escaped."""
    monkeypatch.setattr(output, "enable_escapes", lambda _: True)
    monkeypatch.delenv("NO_COLOR", raising=False)
    out = Output(stream=(stream := Terminal()))
    out.line(f"{out.colour('ready', 'green')} of \x1b[31mred\x1b[0m {RAW} {out.colour(RAW, 'red')}")
    text = stream.getvalue()
    assert text.startswith("\x1b[32mready\x1b[0m of \\x1b[31mred")
    assert wrongs_of(text.replace("\x1b[32m", "").replace("\x1b[0m", "").replace("\x1b[31m", "")) == []
    assert text.count("\x1b") == 4


@pytest.mark.parametrize("verb", ["result", "record"])
def test_json_stays_json(verb: str) -> None:
    """Escaped as JSON escapes: a program reads what the peer wrote, a terminal obeys nothing of it."""
    stream = io.StringIO()
    getattr(Output(as_json=True, stream=stream), verb)({"text": RAW + "\U000e0041仓库"})
    assert json.loads(stream.getvalue())["text"] == RAW + "\U000e0041仓库"
    assert wrongs_of(stream.getvalue()) == []
    assert "仓库" in stream.getvalue()


@pytest.mark.parametrize("encoding", ["ascii", "cp1252", "utf-8"])
def test_json_has_its_letters_in_every_encoding(encoding: str) -> None:
    """The stream's error handler would write "deg" for a degree sign that the encoding lacks."""
    escape_what_cannot_be_printed()
    stream = io.TextIOWrapper(written := io.BytesIO(), encoding, errors="rosproto.readable")
    Output(as_json=True, stream=stream).record({"text": "90° 仓库 😀", "none": float("nan")})
    assert json.loads(written.getvalue().decode(encoding)) == {"text": "90° 仓库 😀", "none": None}
