"""Lists all commands and options from the parsers, and those that a command line uses.

A pair is ("rosproto topic echo", "--noarr"): the command, and an option, a choice (`--format=dot`) or an optional
argument (`<namespace>`).
"""

from __future__ import annotations

import argparse
import contextlib
import functools
import io
import json
import os
import shlex
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

from rosproto.cli.entry import COMMANDS as ROSPROTO
from rosproto.cli.entry import add_general_options
from rosproto.cli.entry import parser_for as rosproto_parser
from rosproto.cli.graph_options import add_graph_options
from rosproto.cli.parser import Parser, sub_parsers
from tests.support.waiting import until
from woosh_pure.cli.commands import COMMANDS as WOOSH
from woosh_pure.cli.entry import _common, parser_for

__all__ = [
    "Case",
    "Pair",
    "Result",
    "common_options",
    "covered",
    "every_pair",
    "leaves",
    "offers_json",
    "path_of",
    "run",
    "run_apart",
    "run_until",
]

ROOT = Path(__file__).resolve().parents[2]

Pair = tuple[str, str]


@dataclass(frozen=True)
class Result:
    """The result of a command.

    Attributes:
        code: Exit code, that of argparse's refusals too.
        out: Standard output.
        err: Standard error.
    """

    code: int
    out: str
    err: str

    @property
    def document(self) -> Any:
        """The one JSON document of standard output."""
        return json.loads(self.out, parse_constant=_no_json)


def _no_json(name: str) -> None:
    raise AssertionError(f"{name} is not JSON")


Check = Callable[..., object]


@dataclass(frozen=True)
class Case:
    """A command line and its expected result.

    Attributes:
        line: The words, as typed; `{name}` is put in from the fixture's places.
        check: Called with the `Result` (and the graph, when it takes two): a false value fails.
        code: Expected exit code.
        stdin: What it reads.
        more: Words that are not to be split.
    """

    line: str
    check: Check = field(default=lambda result: True)
    code: int = 0
    stdin: str = ""
    more: tuple[str, ...] = ()

    def words(self, **places: object) -> list[str]:
        """The command line."""
        return [*(word.format(**places) for word in shlex.split(self.line)), *self.more]


def parser_of(prog: str, words: Sequence[str]) -> argparse.ArgumentParser:
    """The parser that understands words that begin with a command."""
    return _parser_named(prog, words[0])


@functools.cache
def _parser_named(prog: str, name: str) -> argparse.ArgumentParser:
    return parser_for([name]) if prog == "woosh" else rosproto_parser([name])


def path_of(prog: str, words: Sequence[str]) -> str:
    """The command and verb: "rosproto topic echo"."""
    found, parser, rest = prog, parser_of(prog, words), iter(words)
    while subs := dict(sub_parsers(parser)):
        name = next(word for word in rest if word in subs)
        found, parser = f"{found} {name}", subs[name]
    return found


def common_options(prog: str) -> set[tuple[tuple[str, ...], str]]:
    """Options that every command takes: their names and help. Tested for all commands alike."""
    if prog == "woosh":
        parsers = [_common()]
    else:
        parsers = [Parser(add_help=False), Parser(add_help=False)]
        add_general_options(parsers[0], 0, False)
        add_graph_options(parsers[1])
    return {(tuple(a.option_strings), a.help or "") for parser in parsers for a in parser._actions}


def places(prog: str) -> Iterator[tuple[str, argparse.ArgumentParser]]:
    """Every command and verb: ("rosproto topic echo", its parser), those that only have verbs too."""

    def walk(path: str, parser: argparse.ArgumentParser) -> Iterator[tuple[str, argparse.ArgumentParser]]:
        yield path, parser
        for name, sub in sub_parsers(parser):
            yield from walk(f"{path} {name}", sub)

    for name in WOOSH if prog == "woosh" else ROSPROTO:
        yield from walk(f"{prog} {name}", dict(sub_parsers(parser_of(prog, [name])))[name])


def arguments_of(parser: argparse.ArgumentParser) -> list[argparse.Action]:
    """What a command takes: its options and its positional arguments, in their order."""
    return list(parser._actions)


def leaves(prog: str) -> list[str]:
    """Every command line that can run: commands without verbs, and verbs."""
    return [path for path, parser in places(prog) if not list(sub_parsers(parser))]


def offers_json(prog: str) -> set[str]:
    """The command lines that know --json."""
    found = {path for path, parser in places(prog) if "--json" in parser._option_string_actions}
    return found & set(leaves(prog))


def every_pair(prog: str) -> set[Pair]:
    """All that `--help` offers, without what every command takes."""
    common = common_options(prog)
    found: set[Pair] = set()
    for path, parser in places(prog):
        for action in parser._actions:
            if isinstance(action, argparse._SubParsersAction) or action.help == argparse.SUPPRESS:
                continue
            if "--help" in action.option_strings:
                continue
            if (tuple(action.option_strings), action.help or "") not in common:
                found |= {(path, name) for name in _names(action)}
    return found


def _names(action: argparse.Action) -> list[str]:
    option = action.option_strings[-1] if action.option_strings else ""
    name = option or f"<{action.dest}>"
    choices = [f"{name}={c}" for c in action.choices or () if not str(c).startswith("_")]
    return choices or ([name] if option or action.nargs in ("?", "*") else [])


def covered(prog: str, words: Sequence[str]) -> set[Pair]:
    """The pairs that a command line uses."""
    parser = parser_of(prog, words)
    given = parser.parse_args(list(words))
    path, found = prog, set()
    rest = iter(words)
    while True:
        for action in parser._actions:
            if isinstance(action, argparse._SubParsersAction):
                continue
            value = getattr(given, action.dest, None)
            if action.option_strings:
                used = any(w.partition("=")[0] in action.option_strings for w in words)
            else:
                used = value is not None and value != action.default
            if used:
                name = action.option_strings[-1] if action.option_strings else f"<{action.dest}>"
                found.add((path, f"{name}={value}" if action.choices else name))
        subs = dict(sub_parsers(parser))
        chosen = next((word for word in rest if word in subs), None)
        if chosen is None:
            return found
        path, parser = f"{path} {chosen}", subs[chosen]


def run(prog: str, words: Sequence[str], stdin: str = "") -> Result:
    """Run a command in this process."""
    from rosproto.cli import main as rosproto
    from woosh_pure.cli import main as woosh

    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), _stdin(stdin):
        try:
            code = (woosh if prog == "woosh" else rosproto)(list(words))
        except SystemExit as leaving:
            code = leaving.code if isinstance(leaving.code, int) else 1
    return Result(code, out.getvalue(), err.getvalue())


def run_apart(prog: str, words: Sequence[str], stdin: str = "") -> Result:
    """As `run`, in a process of its own."""
    done = subprocess.run(
        _command(prog, words), input=stdin, capture_output=True, text=True, encoding="utf-8", timeout=60,
        check=False, env=_environment(),
    )  # fmt: skip
    return Result(done.returncode, done.stdout, done.stderr)


def run_until(when: Callable[[str], object], prog: str, words: Sequence[str], lasts: float = 0.0) -> Result:
    """Run a command that goes on in a process of its own, and press Ctrl-C as soon as something holds.

    In this process the signal could meet pytest, before the command has begun or when it has ended.

    Args:
        when: Called with what the command has printed so far.
        prog: "rosproto" or "woosh".
        words: The rest of the command line.
        lasts: Seconds to wait after it holds.
    """
    with ExitStack() as stack:
        out, err = (stack.enter_context(tempfile.TemporaryFile("w+", encoding="utf-8")) for _ in range(2))

        def written(file: IO[str]) -> str:
            size = os.fstat(file.fileno()).st_size
            return os.pread(file.fileno(), size, 0).decode(errors="replace")  # leaves the writer's place

        process = stack.enter_context(
            subprocess.Popen(
                _command(prog, words), stdin=subprocess.DEVNULL, stdout=out, stderr=err, env=_environment()
            )
        )
        stack.callback(process.kill)
        until(
            lambda: process.poll() is not None or when(written(out) + written(err)),
            60.0,
            lambda: f"{prog} {shlex.join(words)}:\n{written(out)}{written(err)}",
        )
        time.sleep(lasts)
        process.send_signal(signal.SIGINT)
        return Result(process.wait(60.0), written(out), written(err))


def _command(prog: str, words: Sequence[str]) -> list[str]:
    return [sys.executable, "-u", "-m", "woosh_pure" if prog == "woosh" else "rosproto", *words]


def _environment() -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONIOENCODING": "utf-8"}


@contextlib.contextmanager
def _stdin(text: str) -> Iterator[None]:
    before, sys.stdin = sys.stdin, io.StringIO(text)
    try:
        yield
    finally:
        sys.stdin = before
