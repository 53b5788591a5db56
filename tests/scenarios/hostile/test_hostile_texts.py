"""No command lets a peer, a bag or a master command the terminal or forge a line: each one is fed, whichever there are.

The commands are those that the parsers know, so a new one is fed by itself.
"""

from __future__ import annotations

import argparse
import signal
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path

import pytest

from tests.support.hostile_peer import EVIL, HostilePeer, hostile_bag, wrongs_of
from tests.support.options import leaves, places
from tests.support.warm import WarmPython

pytestmark = pytest.mark.slow

SECONDS = 6.0
PROGRAMS = ("rosproto run", "woosh run")
"""They print what a program of the user's likes."""
MODULES = {"rosproto": "rosproto", "woosh": "woosh_pure"}
LINES = [(prog, path) for prog in MODULES for path in leaves(prog) if path not in PROGRAMS]
BY_DEST = {
    "topic": "/t", "topics": "/t", "node": "/node", "service": "/srv", "key": "/p", "namespace": "/", "mark": "A1",
    "host": "127.0.0.1", "type": "std_msgs/String", "values": "", "field": "data", "expression": "m.data",
    "package": "std_msgs", "shell": "bash", "target": "map", "source": "odom", "seconds": "1", "value": "1",
}  # fmt: skip


@pytest.fixture(scope="module")
def peer() -> Iterator[HostilePeer]:
    with HostilePeer() as hostile:
        yield hostile


@pytest.fixture(scope="module")
def pythons() -> Iterator[list[WarmPython]]:
    """As many as a command has forms; each begins with its first program."""
    with ExitStack() as stack:
        yield [stack.enter_context(WarmPython()) for _ in range(8)]


def translator_for(prog: str, path: str, peer: HostilePeer, folder: Path) -> list[str]:
    """The command with something for each argument that it needs."""
    parser = dict(places(prog))[path]
    words = path.split()[1:]
    for action in parser._actions:
        if action.option_strings or action.nargs in ("?", "*", argparse.REMAINDER, argparse.PARSER):
            needed = action.required and bool(action.option_strings)
            if not needed:
                continue
            words.append(action.option_strings[0])
        words.append(_value(action, folder))
    for group in parser._mutually_exclusive_groups:
        first = group._group_actions[0]
        if group.required and first.option_strings:
            count = first.nargs if isinstance(first.nargs, int) else 1
            words += [first.option_strings[0], *[_value(first, folder)] * count]
    offered = parser._option_string_actions
    for option, value in (
        ("-n", "2"),
        ("--count", "2"),
        ("--seconds", "1"),
        ("--duration", "1"),
        ("--timeout", "2"),
    ):
        if option in offered and offered[option].nargs != 0:
            words += [option, value]
    if "--master" in offered:
        words += ["--master", peer.uri]
    return words


def _value(action: argparse.Action, folder: Path) -> str:
    if action.choices:
        return str(next(iter(action.choices)))
    name = f"{action.dest} {action.metavar}".lower()
    if "output" in name or "file" in name:
        return str(folder / "out.bag")
    if "bag" in name:
        return str(folder / "evil.bag")
    return BY_DEST.get(action.dest, "1")


def outcome(python: WarmPython, prog: str, words: list[str], folder: Path) -> tuple[str, str]:
    """Both streams of the command; one that would go on is interrupted."""
    script = folder / "command.py"
    script.write_text(f"from {MODULES[prog]}.cli import main\nraise SystemExit(main())\n")
    home = {"WOOSH_CONFIG_DIR": str(folder / "config"), "HOME": str(folder), "XDG_DATA_HOME": str(folder)}
    done = python.run(
        script,
        folder,
        words,
        before=f"import os\nos.environ.update({home})",
        timeout=3 * SECONDS,
        interrupts={SECONDS: signal.SIGINT, 2 * SECONDS: signal.SIGTERM},
        errors="surrogatepass",
    )
    return done.stdout, done.stderr


@pytest.mark.promise("cannot control a terminal or forge a line", "YAML and JSON output uses its own escapes")
@pytest.mark.parametrize(("prog", "path"), LINES, ids=[path for _, path in LINES])
def test_no_command_lets_a_peer_write_to_the_terminal(
    prog: str, path: str, peer: HostilePeer, pythons: list[WarmPython], tmp_path: Path
) -> None:
    """Standard output, standard error and the log on it, plainly, with JSON and with all that is logged."""
    parser = dict(places(prog))[path]
    forms = [[]] + ([["--json"]] if "--json" in parser._option_string_actions else [])
    for option in ("--csv", "--details", "--pretty", "--yaml"):
        if option in parser._option_string_actions:
            forms.append([option])
    if "--bag" in parser._option_string_actions and prog == "rosproto":
        forms += [[*form, "--bag", "evil.bag"] for form in forms]
    loud = ["--verbose"] * 2 if "--verbose" in parser._option_string_actions else []

    def form(number: int) -> tuple[str, str]:
        folder = tmp_path / str(number)
        folder.mkdir()
        hostile_bag(folder / "evil.bag")
        words = [*translator_for(prog, path, peer, folder), *forms[number], *loud]
        return outcome(pythons[number], prog, words, folder)

    # All at once, since most of them wait; but not those that listen, on the same port.
    with ThreadPoolExecutor(1 if "--port" in parser._option_string_actions else len(forms)) as pool:
        outcomes = list(pool.map(form, range(len(forms))))
    for more, (out, err) in zip(forms, outcomes, strict=True):
        assert not wrongs_of(out), (more, out)
        assert not wrongs_of(err), (more, err)
        assert "Traceback" not in err, err
        assert "usage:" not in err, err


def test_the_watch_sees_what_it_should() -> None:
    """A command that printed the name as it is would be found."""
    assert len(wrongs_of(f"topic {EVIL}\n")) > 8
    assert wrongs_of("harmless\n\tand indented\n") == []
