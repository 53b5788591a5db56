"""Make the manual of both commands from the parsers that make `--help`.

It is docs/commands.md (what all commands share), a page for each group of commands in docs/commands/, and the
table in docs/all-commands.md.

python -m tools.manual            writes them in this source tree
python -m tools.manual --check    exit code 1 when one of them is not current
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from rosproto.cli.parser import Parser, synopsis, value_names

__all__ = ["GROUPS", "Group", "main", "manual", "with_table"]

DOCS = Path(__file__).resolve().parents[1] / "docs"
ALL_COMMANDS = {"all-commands.md": "en", "all-commands.zh-CN.md": "zh"}
"""The pages with one line for each command, and their languages."""


class Group(NamedTuple):
    """The commands of one page."""

    prog: str
    page: str
    title: str
    commands: tuple[str, ...]


GROUPS = (
    Group("woosh", "woosh-start", "start, connect, diagnose",
          ("demo", "sim", "connect", "doctor", "selftest", "learn", "run", "shell", "completion")),
    Group("woosh", "woosh-state", "state, sensors, lights and voice",
          ("status", "ready", "watch", "battery", "faults", "imu", "scan", "camera", "cloud", "led", "say")),
    Group("woosh", "woosh-drive", "driving and stopping",
          ("goto", "task", "charge", "move", "rotate", "drive", "mission", "stop")),
    Group("woosh", "woosh-maps", "maps, marks and navigation",
          ("localization", "map", "plan", "costmap", "footprint", "mode", "marks", "api")),
    Group("woosh", "woosh-servers", "recording and servers",
          ("record", "web", "mcp", "foxglove", "robot-api", "vda5050")),
    Group("rosproto", "rosproto-graph", "topics, nodes, services, parameters",
          ("topic", "node", "service", "param", "graph")),
    Group("rosproto", "rosproto-definitions", "message definitions", ("msg", "srv", "action")),
    Group("rosproto", "rosproto-bags", "bags", ("bag",)),
    Group("rosproto", "rosproto-diagnosis", "transforms, logs, settings, diagnosis",
          ("tf", "log", "dynparam", "doctor")),
    Group("rosproto", "rosproto-servers", "programs and servers",
          ("run", "bridge", "foxglove", "master", "completion")),
)  # fmt: skip
"""The pages in docs/commands/. A new command needs a place here."""

_BEGIN = "<!-- commands: made by `python -m tools.manual` from what `--help` says -->"
_END = "<!-- end of commands -->"

_HEAD = """# The commands `woosh` and `rosproto`

This page and the pages it links are made by `python -m tools.manual` from what `--help` says; edit that.

Both commands are installed by `pip install`; `python -m woosh_pure` and `python -m rosproto` are the same.
Everything works with numpy, lz4 and the standard library. Shell completion:
`woosh completion bash` and `rosproto completion bash` (or zsh, fish, powershell) print a script. Its first
line says where to put it. [All commands at a glance](all-commands.md) has one line for each.
"""
_WOOSH = """## woosh

A chassis is chosen by `--chassis HOST`, `--master URI`, `$ROS_MASTER_URI`, or the one saved by
`woosh connect HOST`, in this order; `--sim` starts a simulated one for the command. With `--json` facts and
errors are one JSON document (`watch` and `imu -n`: one per line). Colours appear only on a terminal
and not when `$NO_COLOR` is set. Ctrl-C stops what the command has started, and says whether the robot
stands still. This is not an emergency stop: keep the red button within reach.

Poses are metres and degrees in the map, counter-clockwise positive.
"""
_ROSPROTO = """## rosproto

The master is `--master URI`, `$ROS_MASTER_URI`, that of `woosh connect`, or this computer. Verbs and options
are those of rostopic, rosnode, rosservice, rosparam, rosmsg, rossrv and rosbag, and the output has the same
form. Values are JSON or one-line YAML (`'{linear: {x: 0.1}}'`); YAML over several lines needs PyYAML
(`pip install ".[cli]"`). Facts go to stdout, warnings and errors to stderr.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the pages, or check them; the exit code."""
    parser = argparse.ArgumentParser(prog="python -m tools.manual", description="Write the manual.")
    parser.add_argument("--check", action="store_true", help="write nothing; exit code 1 when a page is old")
    check = parser.parse_args(arguments).check
    old = 0
    pages = {
        name: with_table((DOCS / name).read_text(encoding="utf-8"), language)
        for name, language in ALL_COMMANDS.items()
    }
    for name, text in {**manual(), **pages}.items():
        path = DOCS / name
        current = path.exists() and path.read_text(encoding="utf-8") == text
        if check:
            old += not current
            print(f"{path}: {'current' if current else 'old; run python -m tools.manual'}")
        elif not current:
            path.parent.mkdir(exist_ok=True)
            path.write_text(text, encoding="utf-8", newline="\n")
            print(f"wrote {path}")
    return 1 if old else 0


def with_table(text: str, language: str = "en") -> str:
    """A page with the table between its two marks renewed.

    Raises:
        ValueError: The page lacks the marks.
    """
    before, begin, rest = text.partition(_BEGIN)
    _, end, after = rest.partition(_END)
    if not (begin and end):
        raise ValueError(f"the marks of the table are missing: {_BEGIN} and {_END}")
    return "\n".join([before + begin, *_all_commands(language), end + after])


def _all_commands(language: str) -> Iterator[str]:
    from rosproto.cli.entry import COMMANDS as ROSPROTO
    from woosh_pure.cli.commands import COMMANDS
    from woosh_pure.language.table import translator_for

    say = translator_for(language).say

    rows = [("woosh", name, text) for name, text in COMMANDS.items()]
    rows += [("rosproto", name, command.help) for name, command in ROSPROTO.items()]
    yield from _table(
        {"en": ("command", "what it does"), "zh": ("命令", "作用")}[language],
        [(f"[`{prog} {name}`]({_section(prog, name)})", say(text)) for prog, name, text in rows],
    )


def _section(prog: str, name: str) -> str:
    """The link to a command's description, relative to docs/."""
    page = next(group.page for group in GROUPS if group.prog == prog and name in group.commands)
    return f"commands/{page}.md#{prog}-{name}"


def manual() -> Mapping[str, str]:
    """The text of each page, by its path in docs/."""
    pages = {"commands.md": [_HEAD, *_woosh(), "", *_rosproto()]}
    pages |= {f"commands/{group.page}.md": list(_page(group)) for group in GROUPS}
    return {name: "\n".join(lines).rstrip() + "\n" for name, lines in pages.items()}


def _woosh() -> Iterator[str]:
    from woosh_pure.cli.entry import parser_for
    from woosh_pure.cli.output import EXIT_CODES

    yield _WOOSH
    yield from _contents("woosh")
    yield from ("", "Options of every command:", "")
    yield from _table(("Option", ""), list(_options(parser_for(()), set())))
    yield from _exit_codes(EXIT_CODES)


def _rosproto() -> Iterator[str]:
    from rosproto.cli.exit_codes import EXIT_CODES

    yield _ROSPROTO
    yield from _contents("rosproto")
    yield from ("", "Options of every command, and, below them, of every one that talks to a graph:", "")
    yield from _table(
        ("Option", ""), [row for parser in _rosproto_shared() for row in _options(parser, set())]
    )
    yield from _exit_codes(EXIT_CODES)


def _rosproto_shared() -> list[Parser]:
    """Options of every command, and of every command with a graph."""
    from rosproto.cli.entry import add_general_options
    from rosproto.cli.graph_options import add_graph_options

    general, graph = Parser(add_help=False), Parser(add_help=False)
    add_general_options(general, 0, False)
    add_graph_options(graph)
    return [general, graph]


def _contents(prog: str) -> Iterator[str]:
    """A row for each page of a command's groups."""
    rows = [
        (
            f"[{group.title[:1].upper()}{group.title[1:]}](commands/{group.page}.md)",
            ", ".join(f"[`{name}`]({_section(prog, name)})" for name in group.commands),
        )
        for group in GROUPS
        if group.prog == prog
    ]
    yield from _table(("Page", "Commands"), rows)


def _exit_codes(codes: Mapping[int, str]) -> Iterator[str]:
    yield from ("", "Exit codes:", "")
    yield from _table(("Code", "Meaning"), [(str(code), text) for code, text in codes.items()])


def _page(group: Group) -> Iterator[str]:
    from rosproto.cli.entry import parser_for as rosproto_parser
    from woosh_pure.cli.entry import parser_for as woosh_parser

    parser_for = woosh_parser if group.prog == "woosh" else rosproto_parser
    shared = [woosh_parser(())] if group.prog == "woosh" else _rosproto_shared()
    known = {_identity(action) for parser in shared for action in parser._actions}
    yield f"# `{group.prog}`: {group.title}"
    yield from ("", "Made by `python -m tools.manual` from what `--help` says; edit that, not this page.")
    yield "Options that every command takes, and exit codes: [The commands](../commands.md)."
    for name in group.commands:
        yield from ("", f"## {group.prog} {name}", "")
        yield from _body(f"{group.prog} {name}", _sub(parser_for([name]), name), known)


def _sub(parser: argparse.ArgumentParser, name: str) -> Parser:
    """The parser of a command inside the whole one."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            found = action.choices[name]
            assert isinstance(found, Parser)
            return found
    raise LookupError(f"{parser.prog} has no commands")


Known = set[tuple[tuple[str, ...], str]]
"""Names and help of the options in separate tables."""


def _identity(action: argparse.Action) -> tuple[tuple[str, ...], str]:
    return tuple(action.option_strings), action.help or ""


def _body(command: str, parser: Parser, known: Known) -> Iterator[str]:
    """Synopsis, what it does, its arguments; then the same of its verbs."""
    yield f"`{_synopsis(command, parser, known)}`"
    if parser.description:
        text = _plain(parser, parser.description)
        yield from ("", text[:1].upper() + text[1:] + ("" if text.endswith((".", ")")) else "."))
    rows = [*_positionals(parser), *_options(parser, known)]
    if rows:
        yield ""
        yield from _table(("Argument", ""), rows)
    if examples := getattr(parser, "examples", ()):
        yield from ("", *(f"    {line}" for line in examples))
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            helps = {choice.dest: choice.help or "" for choice in action._choices_actions}
            for verb, sub in action.choices.items():
                sub.description = sub.description or helps.get(verb)
                yield ""
                yield from _body(f"{command} {verb}", sub, known)


def _synopsis(command: str, parser: Parser, known: Known) -> str:
    """The usage line, without the common options."""
    common = {text for names, _ in known for text in names}
    return synopsis(command, parser, {"-h", "--help", *common})


def _positionals(parser: argparse.ArgumentParser) -> Iterator[tuple[str, str]]:
    for action in parser._actions:
        if not (action.option_strings or isinstance(action, argparse._SubParsersAction)) and _told(action):
            yield f"`{value_names(action)}`", _plain(parser, action.help or "", action)


def _told(action: argparse.Action) -> bool:
    return bool(action.help) and action.help != argparse.SUPPRESS


def _options(parser: argparse.ArgumentParser, known: Known) -> Iterator[tuple[str, str]]:
    for action in parser._actions:
        names = action.option_strings
        if not names or _identity(action) in known or "--help" in names or action.help == argparse.SUPPRESS:
            continue
        values = "" if action.nargs == 0 else f" {value_names(action)}"
        yield f"`{', '.join(names)}{values}`", _plain(parser, action.help or "", action)


def _plain(parser: argparse.ArgumentParser, text: str, action: argparse.Action | None = None) -> str:
    """With argparse's %(default)s and %% resolved."""
    facts = {"prog": parser.prog, **({} if action is None else vars(action))}
    return " ".join((text % facts).split())


def _table(head: tuple[str, str], rows: Sequence[tuple[str, str]]) -> Iterator[str]:
    yield f"| {head[0]} | {head[1]} |"
    yield "| --- | --- |"
    for row in rows:
        yield "| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |"


if __name__ == "__main__":
    sys.exit(main())
