"""The manual of both commands, made from the parsers that make `--help`.

It is docs/commands.md, and the table in docs/all-commands.md.

python -m tools.manual            writes them in this source tree
python -m tools.manual --check    exit code 1 when one of them is not current
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from rosproto.cli.parser import Parser, synopsis, value_names

__all__ = ["glance", "main", "manual", "page", "with_table"]

page = Path(__file__).resolve().parents[1] / "docs" / "commands.md"
"""Where the manual is in a source tree."""
glance = page.with_name("all-commands.md")
"""The page with one line for each command."""

_BEGIN = "<!-- commands: made by `python -m tools.manual` from what `--help` says -->"
_END = "<!-- end of commands -->"

_HEAD = """# The commands `woosh` and `rosproto`

Made by `python -m tools.manual` from what `--help` says; edit that, not this page.

Both commands are installed by `pip install`; `python -m woosh_pure` and `python -m rosproto` are the same.
Everything works with numpy, lz4 and the standard library. Shell completion:
`woosh completion bash` and `rosproto completion bash` (or zsh, fish, powershell) print a script whose first
line says where to put it.
"""
_WOOSH = """## woosh

A chassis is chosen by `--chassis HOST`, `--master URI`, `$ROS_MASTER_URI`, or the one remembered by
`woosh connect HOST`, in this order; `--sim` starts a simulated one for the command. With `--json` facts
come as one JSON document (`watch` and `imu -n`: one a line), errors too. Colours appear only on a terminal
and not when `$NO_COLOR` is set. Ctrl-C stops what the command has started, and says whether the robot
stands still. This is no emergency stop: keep the red button in reach.

Poses are metres and degrees in the map, counter-clockwise positive.
"""
_ROSPROTO = """## rosproto

The master is `--master URI`, `$ROS_MASTER_URI`, or this computer. Words and options are those of rostopic,
rosnode, rosservice, rosparam, rosmsg, rossrv and rosbag, and what they print reads the same. Values are JSON
or one-line YAML (`'{linear: {x: 0.1}}'`); YAML over several lines needs PyYAML
(`pip install ".[cli]"`). Facts go to stdout, warnings and errors to stderr.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the page, or check it; the exit code."""
    parser = argparse.ArgumentParser(prog="python -m tools.manual", description="Write the manual.")
    parser.add_argument("--check", action="store_true", help="write nothing; exit code 1 when it is old")
    check = parser.parse_args(arguments).check
    old = 0
    pages = {page: manual(), glance: with_table(glance.read_text(encoding="utf-8"))}
    for path, text in pages.items():
        current = path.exists() and path.read_text(encoding="utf-8") == text
        if check:
            old += not current
            print(f"{path}: {'current' if current else 'old; run python -m tools.manual'}")
        elif not current:
            path.parent.mkdir(exist_ok=True)
            path.write_text(text, encoding="utf-8", newline="\n")
            print(f"wrote {path}")
    return 1 if old else 0


def with_table(text: str) -> str:
    """A page with the table between its two marks renewed.

    Raises:
        ValueError: The page lacks the marks.
    """
    before, begin, rest = text.partition(_BEGIN)
    _, end, after = rest.partition(_END)
    if not (begin and end):
        raise ValueError(f"the marks of the table are missing: {_BEGIN} and {_END}")
    return "\n".join([before + begin, *_all_commands(), end + after])


def _all_commands() -> Iterator[str]:
    from rosproto.cli.entry import COMMANDS as ROSPROTO
    from woosh_pure.cli.commands import COMMANDS, load

    rows = [("woosh", name, load(name).HELP) for name in COMMANDS]
    rows += [("rosproto", name, command.help) for name, command in ROSPROTO.items()]
    yield from _table(
        ("command", "what it does"),
        [(f"[`{prog} {name}`](commands.md#{prog}-{name})", text) for prog, name, text in rows],
    )


def manual() -> str:
    """The whole page."""
    return "\n".join([_HEAD, *_woosh(), "", *_rosproto()]).rstrip() + "\n"


def _woosh() -> Iterator[str]:
    from woosh_pure.cli.commands import COMMANDS, load
    from woosh_pure.cli.entry import EXIT_CODES, parser_for

    yield _WOOSH
    yield from _table(("Command", ""), [(_link("woosh", name), load(name).HELP) for name in COMMANDS])
    yield from ("", "Options of every command:", "")
    top = parser_for(())
    common = {_identity(action) for action in top._actions}
    yield from _table(("Option", ""), list(_options(top, set())))
    yield from ("", "Exit codes:", "")
    yield from _table(("Code", "Meaning"), [(str(code), text) for code, text in EXIT_CODES.items()])
    for name in COMMANDS:
        yield from _section("woosh", name, _sub(parser_for([name]), name), common)


def _rosproto() -> Iterator[str]:
    from rosproto.cli.connection import add_graph_options
    from rosproto.cli.entry import COMMANDS, EXIT_CODES, add_general_options, parser_for

    yield _ROSPROTO
    rows = [(_link("rosproto", name), command.help) for name, command in COMMANDS.items()]
    yield from _table(("Command", ""), rows)
    yield from ("", "Options of every command, and, below them, of every one that talks to a graph:", "")
    general, graph = Parser(add_help=False), Parser(add_help=False)
    add_general_options(general, 0, False)
    add_graph_options(graph)
    yield from _table(("Option", ""), [*_options(general, set()), *_options(graph, set())])
    yield from ("", "Exit codes:", "")
    yield from _table(("Code", "Meaning"), [(str(code), text) for code, text in EXIT_CODES.items()])
    common = {_identity(action) for parser in (general, graph) for action in parser._actions}
    for name in COMMANDS:
        yield from _section("rosproto", name, _sub(parser_for([name]), name), common)


def _sub(parser: argparse.ArgumentParser, name: str) -> argparse.ArgumentParser:
    """The parser of a command inside the whole one."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            found = action.choices[name]
            assert isinstance(found, argparse.ArgumentParser)
            return found
    raise LookupError(f"{parser.prog} has no commands")


def _link(prog: str, name: str) -> str:
    return f"[`{prog} {name}`](#{prog}-{name})"


Known = set[tuple[tuple[str, ...], str]]
"""Options that stand in a table of their own: their names and their help."""


def _identity(action: argparse.Action) -> tuple[tuple[str, ...], str]:
    return tuple(action.option_strings), action.help or ""


def _section(prog: str, name: str, parser: argparse.ArgumentParser, known: Known) -> Iterator[str]:
    yield from ("", f"### {prog} {name}", "")
    yield from _body(f"{prog} {name}", parser, known)


def _body(command: str, parser: argparse.ArgumentParser, known: Known) -> Iterator[str]:
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


def _synopsis(command: str, parser: argparse.ArgumentParser, known: Known) -> str:
    """The same line as an error of the command shows, without what every command takes."""
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
