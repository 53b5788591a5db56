"""The numbers of all commands are plain ASCII decimals: one place reads them, and every option goes through it."""

from __future__ import annotations

import argparse

import pytest

from rosproto.cli.options import finite, to_float, to_int
from tests.support.options import arguments_of, places

ODD = [
    "1_0",
    "１０",
    "٣",
    "1_000.5",
    "",
    " 1",
    "1 ",
    "1\n",
    "+-1",
    "0x10",
    "1e",
    "1e1",
    "2E-3",
    "1" + 400 * "0" + "x",
    "1.2.3",
    "--1",
    "1,5",
    "１.5",
    "²",
    "infinity",
]


@pytest.mark.parametrize("text", ODD)
def test_what_only_python_reads_is_no_number(text: str) -> None:
    """Underscores, digits of other scripts, blanks, other notations."""
    with pytest.raises(ValueError):
        to_float(text)
    with pytest.raises(ValueError):
        to_int(text)


@pytest.mark.parametrize(
    ("text", "value"), [("1", 1), ("-1.5", -1.5), ("+.5", 0.5), ("2.", 2.0), ("0.001", 0.001), ("007", 7)]
)
def test_decimals_are(text: str, value: float) -> None:
    """Signs and points."""
    assert to_float(text) == value
    if text.isdigit():
        assert to_int(text) == value


def numbers() -> list[tuple[str, argparse.Action]]:
    """Every option and argument of every command that turns its word into a number."""
    found = []
    for prog in ("rosproto", "woosh"):
        for path, parser in places(prog):
            for action in arguments_of(parser):
                if isinstance(action.type, type) and issubclass(action.type, (int, float)):
                    found.append((path, action))
                elif callable(action.type):
                    try:
                        value = action.type("1")
                    except (argparse.ArgumentTypeError, ValueError, TypeError, OSError):
                        continue
                    if isinstance(value, (int, float)):
                        found.append((path, action))
    return found


NUMBERS = numbers()


def test_there_are_many() -> None:
    """The list below is not empty by mistake."""
    assert len(NUMBERS) > 80


def refusal(action: argparse.Action, text: str) -> str | None:
    """In which words an option refuses it; None when it takes it."""
    assert callable(action.type)
    try:
        action.type(text)
    except (argparse.ArgumentTypeError, ValueError) as error:
        return str(error)
    return None


def test_every_number_of_every_command_is_read_so() -> None:
    """A new option with type=int or type=float is found here."""
    odd = ("1_0", "１", "٣", "1_0.5", "1e1")
    taken = [
        (path, one.option_strings or one.dest, text)
        for path, one in NUMBERS
        for text in odd
        if refusal(one, text) is None
    ]
    assert taken == []


def test_a_number_of_400_digits_is_refused_in_one_short_sentence() -> None:
    for path, one in NUMBERS:
        told = refusal(one, "1" + 400 * "0")
        assert told is not None, (path, one)
        assert len(told) < 120, (path, one)


def test_move_does_not_drive_ten_metres(capsys: pytest.CaptureFixture[str]) -> None:
    """`woosh move 1_0` and `1e1` are wrong use, before anything is asked."""
    from woosh_pure.cli import main

    for word in ("1_0", "１0", "1e1"):
        with pytest.raises(SystemExit) as left:
            main(["--master", "http://127.0.0.1:9", "move", word])
        assert left.value.code == 2
        told = f"{word!r} is not a plain decimal number such as 0.5 or -12"
        assert told in capsys.readouterr().err
    assert finite("10") == 10.0


@pytest.mark.parametrize(
    "words",
    [
        "woosh battery --chassis {}",
        "woosh battery --master http://{}:11311",
        "woosh battery --sim --host {}",
        "woosh web --sim --no-browser --bind {}",
        "woosh sim --bind {}",
        "rosproto topic list --master http://{}:11311",
        "rosproto master --port 0 --host {}",
        "rosproto bridge --port 0 --bind {}",
        "rosproto foxglove --port 0 --bind {}",
    ],
)
@pytest.mark.parametrize("host", ["１２７.0.0.1", "127。0。0。1", "127．0.0.1"])
def test_an_address_in_digits_or_dots_of_another_script_is_refused(
    words: str, host: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """The system would read them as ASCII, and connect or listen there."""
    from rosproto.cli import main as rosproto
    from woosh_pure.cli import main as woosh

    prog, *line = words.format(host).split()
    try:
        code = {"woosh": woosh, "rosproto": rosproto}[prog](line)
    except SystemExit as left:
        code = left.code  # type: ignore[assignment]
    assert code == 2
    assert "digits or dots that are not ASCII" in capsys.readouterr().err
