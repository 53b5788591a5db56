"""The sentences of the sources, and those without a translation.

python -m tools.templates            lists what has no Chinese, ready to be pasted, and rows that nobody says
python -m tools.templates --check    lists, and fails by, what the owners of a robot see

A sentence is the template of a `say` or of a `line` with values, or another text with at least three English
words that is neither a docstring, nor an example of a parser, nor a line for the log, nor a pattern. Texts of
`--help` are taken from the parsers of `woosh`.
"""

from __future__ import annotations

import ast
import re
import sys
from argparse import SUPPRESS
from collections.abc import Iterator, Sequence
from enum import Enum
from functools import cache
from pathlib import Path
from string import Formatter
from typing import NamedTuple, TypeGuard

from rosproto.cli.parser import leaves, sub_parsers
from woosh_pure import enums, faults, hints
from woosh_pure.cli.commands import COMMANDS
from woosh_pure.cli.entry import parser_for
from woosh_pure.language.table import forms_of, key_of, read_table, translator_for

__all__ = [
    "OWNERS",
    "TABLES",
    "Said",
    "advice_places",
    "english_left",
    "help_texts",
    "hinted",
    "main",
    "missing",
    "mixed",
    "places_of",
    "said_in",
    "texts",
    "unsaid",
    "untold",
]

ROOT = Path(__file__).resolve().parents[1]
TABLES = sorted((ROOT / "woosh_pure/language/zh").glob("*.txt"))
_COMMANDS = "api start state driving drive".split()
_CLI = "connection entry follow_goal arguments".split()
_ROOMS = (
    "connection/arguments connection/clients connection/connection doctor/checks doctor/examination "
    "feed/feed motion/action_goal motion/motion motion/steps motion/task "
    "outcome readiness/readiness_state readiness/robot_facts robot_api/api robot_api/http selftest "
    "stopping/stop_executor stopping/other_clients stopping/report stopping/active_motions "
    "stopping/stop velocity/drive connection/other_drivers velocity/shaper velocity/end_conditions"
).split()
_ROSPROTO = (
    "profile cli/exit_codes cli/options cli/parser selftest/checking selftest/computing "
    "selftest/nodes transport/uri transport/name_lookup "
    "transport/own_address transport/tcp transport/deadline transport/robot_host_names "
    "transport/os_errors"
).split()
OWNERS = [
    *(f"woosh_pure/cli/commands/{name}.py" for name in _COMMANDS),
    *(f"woosh_pure/cli/{name}.py" for name in _CLI),
    *(f"woosh_pure/{name}.py" for name in _ROOMS),
    *(f"rosproto/{name}.py" for name in _ROSPROTO),
]
"""What the commands that an owner types are made of, as far as it says something: all of it has its "
""
"Chinese."""
NOT_FOR_PEOPLE = {
    "a longer text, of more than sixteen bytes": "sent by the self-test",
    "as the system says": "a representation",
    "woosh: the robot is to stop": "a reason that is told to another program",
}
FROM_ARGPARSE = {
    "expected one argument",
    "expected at least one argument",
    "positional arguments",
    "options",
    "show this help message and exit",
    "show program's version number and exit",
}
FROM_JSON = {
    "Expecting value",
    "Expecting property name enclosed in double quotes",
    "Expecting ',' delimiter",
    "Expecting ':' delimiter",
    "Extra data",
    "Invalid control character at",
    "Unterminated string starting at",
    "Illegal trailing comma before end of object",
    "Illegal trailing comma before end of array",
}
"""Of Python's module `json`."""
_SAYING = {"say", "advice", "both", "led", "refusing"}
_MAY_SAY = re.compile(r"\b(say|advice|both|led|line|refusing)\(")
_LEFT_OUT_CALLS = set(
    "add_argument add_argument_group add_parser debug info warning exception compile sub search match "
    "fullmatch Thread NamedTuple getattr removeprefix startswith".split()
)
_LEFT_OUT_NAMES = {
    "__all__",
    "EXIT_CODES",
    "EXAMPLES",
    "MEANT",
    "COMMON_LINE",
    "COMMANDS",
    "COLOUR_WORDS",
    "_TASK_KINDS",
    "_TASK_COMMANDS",
}
_QUOTED = re.compile(
    r"`[^`]*`|https?://\S+|'[^']*'|--?[a-zA-Z][\w-]*|/[\w/.-]+|\b\w+\(\)|\b[\w.]+\.\w+(\(.*?\))?|\{[^}]*\}"
)
_WORDS = re.compile(r"[A-Za-z]{2,}(?:[ ,:;]+(?:[a-z]{1,}|[A-Z]{2,})){2,}")


class Said(NamedTuple):
    """A sentence of a source file.

    Attributes:
        line: Its number.
        template: With `{name}` for what is filled in; of an f-string `{}`.
        made: "say" of a `Sentence`, "text" of a plain text, "f-string", "help".
    """

    line: int
    template: str
    made: str


def english_left(text: str) -> str:
    """A run of three English words or more in a text for people; "" when there is none.

    Commands in backquotes, options, paths, addresses, quoted words, places and names in code are not English.
    """
    found = _WORDS.search(_QUOTED.sub("·", text))
    return found[0] if found else ""


def said_in(path: Path) -> Iterator[Said]:
    """The sentences of a source file."""
    yield from _in(_tree(path))


@cache
def _tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text("utf-8"))


def _in(node: ast.AST) -> Iterator[Said]:
    if isinstance(node, ast.Constant):
        if isinstance(node.value, str) and english_left(node.value):
            yield Said(node.lineno, node.value, "text")
        return
    if isinstance(node, ast.JoinedStr):
        parts = [str(part.value) if isinstance(part, ast.Constant) else "{}" for part in node.values]
        if english_left("".join(parts)):
            yield Said(node.lineno, "".join(parts), "f-string")
        for part in node.values:
            if isinstance(part, ast.FormattedValue):
                yield from _in(part.value)
        return
    name = _called(node)
    if name in _LEFT_OUT_CALLS or _is_left_out(node):
        return
    children = list(ast.iter_child_nodes(node))
    says = name in _SAYING or (name == "line" and isinstance(node, ast.Call) and node.keywords)
    if says and isinstance(node, ast.Call) and node.args:
        first = node.args[0]
        if isinstance(first, ast.Constant) and isinstance(first.value, str):
            yield Said(node.lineno, first.value, "say")
            children.remove(first)
    for child in children:
        if not (isinstance(child, ast.Expr) and isinstance(child.value, ast.Constant)):  # a docstring
            yield from _in(child)


def _called(node: ast.AST) -> str:
    if not isinstance(node, ast.Call):
        return ""
    return node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")


def _is_left_out(node: ast.AST) -> bool:
    if isinstance(node, (ast.Assign, ast.AnnAssign)):
        targets = node.targets if isinstance(node, ast.Assign) else [node.target]
        return any(getattr(target, "id", "") in _LEFT_OUT_NAMES for target in targets)
    return isinstance(node, ast.FunctionDef) and node.name == "add_arguments"


def missing(language: str = "zh") -> list[tuple[str, Said]]:
    """(place, sentence) of user-visible texts that the table lacks or that are f-strings."""
    words = translator_for(language)
    return [
        (f"{name}:{said.line}", said)
        for name in OWNERS
        for said in said_in(ROOT / name)
        if said.template not in NOT_FOR_PEOPLE and (said.made == "f-string" or not words.has(said.template))
    ] + [
        (f"{command} --help", Said(0, text, "help"))
        for text, command in help_texts().items()
        if english_left(text) and words.say(text) == text
    ]


@cache
def help_texts() -> dict[str, str]:
    """Each text of the help of `woosh`, and a command that shows it."""
    parsers = [parser_for([])]
    for name in COMMANDS:
        command = dict(sub_parsers(parser_for([name])))[name]
        parsers += [command, *leaves(command)]
    return {
        text: parser.prog
        for parser in parsers
        for text in (
            parser.description,
            parser.epilog,
            *(action.help for action in parser.actions),
            *(choice.help for action in parser.actions for choice in getattr(action, "_choices_actions", ())),
            *(group.title for group in parser._action_groups),
        )
        if text and text != SUPPRESS
    }


def untold(language: str = "zh") -> list[tuple[str, Said]]:
    """(place, sentence) of the other templates that the table lacks: they are shown in English."""
    words = translator_for(language)
    return [
        (f"{path.relative_to(ROOT).as_posix()}:{said.line}", said)
        for path in _sources()
        if path.relative_to(ROOT).as_posix() not in OWNERS
        for said in said_in(path)
        if said.made == "say" and not words.has(said.template)
    ]


def mixed() -> list[tuple[str, Said]]:
    """(place, sentence) of templates that have one name with two formats: a translation has one."""
    return [
        (f"{path.relative_to(ROOT).as_posix()}:{said.line}", said)
        for path in _sources()
        if _MAY_SAY.search(path.read_text("utf-8"))  # to read all sources costs five times as much
        for said in said_in(path)
        if said.made == "say" and len(set(forms_of(said.template))) > len(dict(forms_of(said.template)))
    ]


def unsaid() -> list[str]:
    """Rows of the tables that no source uses."""
    members = [each for kind in {**vars(enums), **vars(faults)}.values() if _is_enum(kind) for each in kind]
    said = {
        *map(str, members),
        *(each.name.lower() for each in members),
        *FROM_ARGPARSE,
        *FROM_JSON,
        *texts(),
        *help_texts(),
        *hinted(),
    }
    rows = (row for path in TABLES for row in read_table(path.read_text("utf-8"), path.name))
    return [row.english for row in rows if row.english not in said]


def texts() -> set[str]:
    """Every plain text of the sources as a template, and what stands between "; " in it."""
    found = {
        _key(node.value)
        for path in _sources()
        for node in ast.walk(_tree(path))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    }
    return found | {part for text in found for part in text.split("; ")}


def hinted() -> set[str]:
    """The right calls that `woosh_pure.hints` names."""
    tables = [table for name, table in vars(hints).items() if name.isupper() and isinstance(table, str)]
    return {line.rpartition(": ")[0] for table in tables for line in table.splitlines()}


def advice_places() -> dict[str, set[str]]:
    """The key of each `advice` of the sources, and the places that all templates with it have."""
    found: dict[str, set[str]] = {}
    for path in _sources():
        if "advice(" not in path.read_text("utf-8"):
            continue  # parsing all of them takes several seconds
        for node in ast.walk(_tree(path)):
            if isinstance(node, ast.Call) and _called(node) == "advice":
                key = next(ast.literal_eval(word.value) for word in node.keywords if word.arg == "key")
                places = places_of(ast.literal_eval(node.args[0]))
                found[key] = found.get(key, places) & places
    return found


def places_of(template: str) -> set[str]:
    """The names in a template."""
    return {name for _, name, _, _ in Formatter().parse(template) if name}


def _is_enum(kind: object) -> TypeGuard[type[Enum]]:
    return isinstance(kind, type) and issubclass(kind, Enum)


def _key(text: str) -> str:
    try:
        return key_of(text)
    except ValueError:
        return text  # braces of something else


def _sources() -> Iterator[Path]:
    """The source files of the packages."""
    for room in ("woosh_pure", "rosproto"):
        yield from sorted((ROOT / room).rglob("*.py"))


def main(argv: Sequence[str] | None = None) -> int:
    """Print the missing sentences."""
    argv = sys.argv[1:] if argv is None else argv
    lacking, others, rows = missing(), untold(), unsaid()
    for place, said in lacking if "--check" in argv else [*lacking, *others]:
        print(f"# {place} ({said.made})\n{said.template}\n")
    for row in rows:
        print(f"# nobody says: {row}")
    print(
        f"without Chinese: {len(lacking)} of what owners see, {len(others)} others; rows unused: {len(rows)}"
    )
    return 1 if lacking or rows else 0


if __name__ == "__main__":
    raise SystemExit(main())
