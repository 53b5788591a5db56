"""Keys from bytes and from a Windows console; the terminal is restored."""

from __future__ import annotations

import itertools
import sys

import pytest

from rosproto.cli.keys import KeyDecoder, WindowsKeys, open_keys


@pytest.mark.parametrize(
    ("data", "keys"),
    [
        (b"\x1b[A\x1b[B\x1b[C\x1b[D", ["up", "down", "right", "left"]),
        (b"\x1bOA", ["up"]),
        (b"wasdQ+ ", ["w", "a", "s", "d", "q", "+", " "]),
        (b"\x1b[1;5A", ["other"]),  # Ctrl and up is not up
        (b"\x1b[15~w", ["other", "w"]),
        (b"\x1bx", ["other"]),
        (b"\r\n\t\x1a\x7f", ["other"] * 5),
        ("é↑".encode(), ["é", "↑"]),
        (b"\xff\xfe", ["other"]),
        (b"\x1b[" + b"1" * 40, ["other"]),
    ],
)
def test_keys_however_their_bytes_are_cut(data, keys) -> None:
    for cut in range(len(data) + 1):
        decoder = KeyDecoder()
        found = decoder.feed(data[:cut]) + decoder.feed(data[cut:]) + decoder.flush()
        if data[:1] == b"\xff":
            assert set(found) == {"other"}
        elif len(data) < 30:
            assert found == keys
        else:
            assert found[0] == "other"
    decoder = KeyDecoder()
    byte_by_byte = list(itertools.chain.from_iterable(decoder.feed(bytes([b])) for b in data))
    assert (byte_by_byte + decoder.flush())[0] == keys[0]


def test_a_lone_escape_is_the_escape_key_once_nothing_follows() -> None:
    decoder = KeyDecoder()
    assert decoder.feed(b"\x1b") == []
    assert decoder.pending
    assert decoder.flush() == ["escape"]
    assert not decoder.pending
    assert decoder.feed(b"\x1b[") == []
    assert decoder.flush() == ["other"]


class Console:
    """What msvcrt offers."""

    def __init__(self, text: str) -> None:
        self.text = list(text)

    def kbhit(self) -> bool:
        return bool(self.text)

    def getwch(self) -> str:
        return self.text.pop(0)


def test_keys_of_a_windows_console() -> None:
    keys = WindowsKeys(Console("W\xe0H\xe0P\xe0K\x00M\x1b\xe0G\r"))
    expected = ["w", "up", "down", "left", "right", "escape", "other", "other"]
    assert keys.read(0.0) == expected
    assert keys.read(0.0) == []
    with pytest.raises(KeyboardInterrupt):
        WindowsKeys(Console("\x03")).read(0.0)


@pytest.mark.skipif(sys.platform == "win32", reason="a pseudo-terminal")
def test_the_terminal_is_restored_after_an_error(monkeypatch) -> None:
    import io
    import os
    import pty
    import termios

    master, slave = pty.openpty()
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.FileIO(slave, closefd=False)))
    before = termios.tcgetattr(slave)

    def fail() -> None:
        with open_keys() as keys:
            during = termios.tcgetattr(slave)
            assert during != before
            assert during[3] & termios.ISIG  # Ctrl-C interrupts
            assert not during[3] & (termios.ECHO | termios.ICANON)
            os.write(master, b"w\x1b[A\x1a")
            assert keys.read(2.0) == ["w", "up", "other"]
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    assert termios.tcgetattr(slave) == before
    os.close(master)
    os.close(slave)
