"""Ctrl-C is the normal end of the commands that serve, from their first line on."""

from __future__ import annotations

import contextlib
import io

import pytest

from rosproto.cli import main as rosproto
from rosproto.master import Master
from woosh_pure.cli import main as woosh

pytest.importorskip("websockets", reason="websockets is not installed")


class InterruptedStream(io.StringIO):
    """Stands for a person who presses Ctrl-C on seeing the address."""

    def write(self, text: str) -> int:
        written = super().write(text)
        if "Serving" in text:
            raise KeyboardInterrupt
        return written


@pytest.mark.parametrize(
    "words",
    [
        ["rosproto", "bridge"],
        ["rosproto", "foxglove"],
        ["woosh", "--sim", "foxglove"],
        ["woosh", "--sim", "robot-api"],
    ],
    ids=" ".join,
)
def test_ctrl_c_with_the_first_line_is_the_normal_end(words: list[str]) -> None:
    with Master() as master, contextlib.redirect_stdout(InterruptedStream()) as out:
        common = ["--port", "0"] if words[0] == "woosh" else ["--port", "0", "--master", master.uri]
        code = (woosh if words[0] == "woosh" else rosproto)([*words[1:], *common])
    assert "Serving" in out.getvalue()
    assert code == 0
