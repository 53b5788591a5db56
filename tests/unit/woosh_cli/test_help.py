"""`--help` of every command and verb: one line of usage, short lines, examples that can be copied."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Iterator

import pytest

from rosproto.cli import entry as rosproto_entry
from rosproto.cli.completion import complete
from rosproto.cli.entry import COMMANDS as ROSPROTO
from rosproto.cli.entry import EXAMPLES as ROSPROTO_EXAMPLES
from rosproto.cli.parser import leaves, sub_parsers
from rosproto.text import width
from tools.templates import english_left
from woosh_pure.cli import entry as woosh_entry
from woosh_pure.cli.commands import COMMANDS as WOOSH
from woosh_pure.cli.entry import EXAMPLES as WOOSH_EXAMPLES


def parser_for(words: list[str]) -> argparse.ArgumentParser:
    """The whole parser of `woosh ...` or `rosproto ...`."""
    program, *rest = words
    return woosh_entry.parser_for(rest) if program == "woosh" else rosproto_entry.parser_for(rest)


def helped() -> Iterator[argparse.ArgumentParser]:
    """The parser of each command and verb."""
    for program, names in (("woosh", WOOSH), ("rosproto", ROSPROTO)):
        for name in names:
            found = dict(sub_parsers(parser_for([program, name])))[name]
            yield from {id(p): p for p in (found, *leaves(found))}.values()


HELPED = list(helped())


@pytest.mark.parametrize(
    ("program", "key", "line"),
    [
        (program, key, line)
        for program, examples in (("woosh", WOOSH_EXAMPLES), ("rosproto", ROSPROTO_EXAMPLES))
        for key, lines in examples.items()
        for line in lines
    ],
)
def test_an_example_is_accepted_and_stands_in_the_help_of_its_command(
    program: str, key: str, line: str
) -> None:
    """Whoever copies it gets what it says, not a lesson in options."""
    command = line.removeprefix('eval "$(').removesuffix(')"')
    words = shlex.split(command)
    assert words[0] == program
    parser = parser_for(words)
    parsed = parser.parse_args(words[1:])
    if getattr(parsed, "expression", None) or getattr(parsed, "filter", None):
        from rosproto.cli.expression import Expression

        Expression(getattr(parsed, "expression", None) or parsed.filter, ("m", "t", "topic"))
    shown = [one for one in HELPED if one.prog == f"{program} {key}"]
    assert len(shown) == 1
    assert f"  {line}\n" in shown[0].format_help().partition("\nexamples:\n")[2]


@pytest.mark.parametrize("parser", HELPED, ids=lambda parser: parser.prog)
def test_help_is_short(parser: argparse.ArgumentParser, monkeypatch: pytest.MonkeyPatch) -> None:
    """Usage is one line; it fits a screen of 60 lines, and its text the width of 80 columns."""
    monkeypatch.setenv("COLUMNS", "80")
    text = parser.format_help()
    usage, blank, *_ = text.splitlines()
    assert usage.startswith(f"usage: {parser.prog}")
    assert blank == ""
    assert "SUPPRESS" not in text
    assert len(text.splitlines()) <= 60
    body = text.partition("\nexamples:\n")[0]
    assert [line for line in body.splitlines()[1:] if len(line) > 80] == []


@pytest.mark.parametrize("name", ["", *WOOSH])
def test_help_is_chinese_where_the_user_is(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every heading and text of a command and its verbs, in lines of at most 80 columns (a character takes two)."""
    monkeypatch.setenv("COLUMNS", "80")
    whole = woosh_entry.parser_for([name] if name else [], "zh")
    found = dict(sub_parsers(whole))[name] if name else whole
    for parser in [found, *leaves(found)] if name else [whole]:
        text = parser.format_help()
        assert text.startswith("用法: ")
        body = text.partition("\n示例:\n")[0].splitlines()[1:]
        assert [line for line in body if width(line) > 80] == []
        assert [line for line in body if english_left(line)] == []


def test_woosh_alone_prints_the_chinese_help(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        woosh_entry.main(["--lang", "zh", "goto", "--help"])
    assert capsys.readouterr().out.startswith("用法: woosh goto")
    assert woosh_entry.main(["--lang", "zh"]) == 2
    assert "控制 Woosh 底盘" in capsys.readouterr().err


def test_what_every_command_takes_is_listed_once() -> None:
    """By `woosh --help`: the help of a command and of its verbs has one line about it, and its own options."""
    everywhere = ("--no-learned", "--lang {en,zh}", "--msg-path FOLDER")
    whole = parser_for(["woosh"]).format_help()
    assert [whole.count(option) for option in everywhere] == [1, 1, 1]
    for parser in HELPED:
        if parser.prog.startswith("woosh "):
            text = " ".join(parser.format_help().split())
            assert [option for option in everywhere if option in text] == [], parser.prog
            assert text.count("options of every command: woosh --help") == 1, parser.prog


def test_the_options_of_every_command_are_still_taken_and_completed() -> None:
    words = ["marks", "add", "A1", "--no-pose", "--lang", "zh", "--sim"]
    assert woosh_entry.parser_for(words).parse_args(words).sim
    assert complete(woosh_entry.parser_for(words[:2]), ["marks", "add", "--si"]) == ["--sim", "--sim-speed"]
