"""`rosproto completion`: completion of commands, options and names for bash, zsh, fish and PowerShell.

The shell's script calls this command (`completion _words =... =...`), which walks the argparse parsers and
looks names up (topics, marks). For a message it offers every field with its default.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from rosproto.cli.parser import Parser, verbs_of
from rosproto.errors import RosError
from rosproto.text import printable

if TYPE_CHECKING:
    from rosproto.codec import Message

T = TypeVar("T")
Names = Callable[[], Iterable[str]]
FILES = 10
"""Exit code of `_words`: nothing is known to stand here, and a file may."""
_FILE_NAMES = frozenset(("FILE", "FOLDER", "BAG", "YAML", "PATH", "OUT", "BAGS"))
_FILE_DESTS = frozenset(("file", "files", "bag", "bags", "program", "output", "input", "out"))
MASTER_PATIENCE = 0.5
"""Seconds that a master may take to tell its topics: a person waits with a finger on the Tab key."""

# Each word has a "=" in front: so no word is empty or looks like an option.
_BASH = """\
# {prog} completion for bash: put `eval "$({prog} completion bash)"` into ~/.bashrc
_{name}_complete() {{
    # By spaces only: bash itself would also cut at the colons of a URI.
    local line=${{COMP_LINE:0:COMP_POINT}} words
    read -ra words <<< "$line"
    [[ $line == *" " ]] && words+=("")
    words=("${{words[@]:1}}")
    local IFS=$'\\n' word i
    COMPREPLY=($({prog} completion _words "${{words[@]/#/=}}" 2>/dev/null))
    [[ $? -eq 10 ]] || compopt +o default 2>/dev/null  # 10: a file may stand here
    for i in "${{!COMPREPLY[@]}}"; do
        word=${{COMPREPLY[i]}}
        case $word in *" "*|*"{{"*) COMPREPLY[i]="'$word'" ;; esac
    done
}}
complete -o default -F _{name}_complete {prog}
"""
_ZSH = """\
#compdef {prog}
# {prog} completion for zsh: put `eval "$({prog} completion zsh)"` into ~/.zshrc, after compinit
_{name}_complete() {{
    local -a typed found
    typed=("${{(@)words[2,CURRENT]}}")
    found=("${{(@f)$({prog} completion _words "${{(@)typed/#/=}}" 2>/dev/null)}}")
    local code=$?  # 10: a file may stand here
    if [[ "${{found[1]}}" == "{{"* ]]; then compadd -Q -- "'${{found[1]}}'"
    elif [[ -n "${{found[1]}}" ]]; then compadd -- "${{found[@]}}"
    elif (( code == 10 )); then _files; fi
}}
compdef _{name}_complete {prog}
"""
_FISH = """\
# {prog} completion for fish: {prog} completion fish > ~/.config/fish/completions/{prog}.fish
function __{name}_complete
    set -l typed (commandline -opc) (commandline -ct)
    set -g __{name}_found ({prog} completion _words (string replace -r '^' '=' -- $typed[2..-1]) 2>/dev/null)
    test $status -ne 10 -o -n "$__{name}_found"  # 10: a file may stand here
end
complete -c {prog} -n __{name}_complete -f -a '$__{name}_found'
"""
_POWERSHELL = """\
# {prog} completion for PowerShell: {prog} completion powershell | Out-String | Invoke-Expression
Register-ArgumentCompleter -Native -CommandName {prog} -ScriptBlock {{
    param($current, $line, $position)
    # What stands before the cursor: the last word up to it, and without the quotes that it is typed in.
    $typed = @($line.CommandElements | Select-Object -Skip 1 | ForEach-Object {{
        $at = $_.Extent.StartOffset
        if ($at -lt $position) {{
            $text = $_.Extent.Text
            "=" + $text.Substring(0, [Math]::Min($text.Length, $position - $at)).Trim("'", '"')
        }}
    }})
    if ($current -eq "") {{ $typed += "=" }}
    {prog} completion _words @typed 2>$null | ForEach-Object {{
        $word = if ($_ -match '[^\\w/.:~+=-]') {{ "'" + $_.Replace("'", "''") + "'" }} else {{ $_ }}
        [System.Management.Automation.CompletionResult]::new($word, $_, "ParameterValue", $_)
    }}
}}
"""
SHELLS = {"bash": _BASH, "zsh": _ZSH, "fish": _FISH, "powershell": _POWERSHELL}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the shell."""
    parser.add_argument(
        "shell",
        choices=[*SHELLS, "_words"],
        metavar="SHELL",
        help=f"{', '.join(SHELLS)}: print its script, whose first line says where to put it",
    )
    # What the scripts call: `words =WORD ...`, the typed words, the last one unfinished.
    parser.add_argument("words", nargs="*", default=[], help=argparse.SUPPRESS)


def run(arguments: argparse.Namespace) -> int:
    """Print the script or the completions."""
    from rosproto.cli.entry import parser_for

    words = _typed(arguments)
    given = _walked(parser_for(words), words[:-1]).given
    return answer("rosproto", arguments, parser_for, _names_of(words, given))


def _typed(arguments: argparse.Namespace) -> list[str]:
    return [word.removeprefix("=") for word in arguments.words] or [""]


def answer(
    prog: str,
    arguments: argparse.Namespace,
    parser_for: Callable[[Sequence[str]], Parser],
    names: Mapping[str, Names],
) -> int:
    """Run the `completion` of a command.

    Args:
        prog: Name of the command.
        arguments: See `add_arguments`.
        parser_for: Returns the parser for the given words.
        names: By the name of an argument: what to offer for it.
    """
    if arguments.shell in SHELLS:
        print(script(prog, arguments.shell), end="")
        return 0
    typed = _typed(arguments)
    parser = parser_for(typed[:-1])
    found = complete(parser, typed, names)
    if found:
        print("\n".join(map(printable, found)))
        return 0
    return FILES if _walked(parser, typed[:-1]).takes_file() else 0


def _walked(parser: Parser, words: Sequence[str]) -> _Walk:
    walk = _Walk(parser)
    for word in words:
        walk.take(word)
    return walk


def script(prog: str, shell: str) -> str:
    """Return the script for the shell to load."""
    return SHELLS[shell].format(prog=prog, name=prog.replace("-", "_"))


def complete(parser: Parser, words: Sequence[str], names: Mapping[str, Names] | None = None) -> list[str]:
    """Return the completions of the last word, sorted.

    Args:
        parser: Of the whole command.
        words: Without the command itself; the last one is unfinished, perhaps "".
        names: By the name of an argument: what to offer for it.
    """
    *done, current = words
    current = current.lstrip("'")  # of a quoted template
    walk = _walked(parser, done)
    if current.startswith("-") and walk.expected is None:
        offers: Iterable[str] = walk.options()
    else:
        offers = walk.offers(names or {})
    return sorted({offer for offer in offers if offer.startswith(current)})


class _Walk:
    """The position in a command line.

    Attributes:
        expected: The option whose value comes next, or None.
        given: The words of each positional argument so far, by its name.
    """

    def __init__(self, parser: Parser) -> None:
        self.given: dict[str, list[str]] = {}
        self._enter(parser)

    def _enter(self, parser: Parser) -> None:
        self._parser = parser
        self._positionals = [a for a in parser.actions if not a.option_strings]
        self.expected: argparse.Action | None = None
        self._left = 0

    def take(self, word: str) -> None:
        """Advance by a finished word."""
        if self.expected is not None and not word.startswith("--"):
            self._left -= 1
            self.expected = self.expected if self._left > 0 else None
            return
        self.expected = None
        if word.startswith("-") and len(word) > 1:
            option = self._parser.options.get(word)
            if option is not None and option.nargs != 0:
                self.expected = option
                self._left = option.nargs if isinstance(option.nargs, int) else 1
            return
        if self._positionals:
            self._take_positional(word)

    def _take_positional(self, word: str) -> None:
        action = self._positionals[0]
        if verbs := verbs_of(action):
            chosen = verbs.get(word)
            if chosen is not None:
                self._enter(chosen)
            return
        self.given.setdefault(action.dest, []).append(word)
        if action.nargs not in ("*", "+", argparse.REMAINDER):
            self._positionals.pop(0)

    def takes_file(self) -> bool:
        """Whether the next word may be a file or folder."""
        action = self.expected or (self._positionals[0] if self._positionals else None)
        if action is None:
            return False
        return action.metavar in _FILE_NAMES or action.dest in _FILE_DESTS or action.type is Path

    def options(self) -> list[str]:
        """Return the options allowed here."""
        return [
            text
            for action in self._parser.actions
            if action.help != argparse.SUPPRESS
            for text in action.option_strings
        ]

    def offers(self, names: Mapping[str, Names]) -> Iterable[str]:
        """Return the values allowed here."""
        action = self.expected or (self._positionals[0] if self._positionals else None)
        if action is None:
            return []
        if action.choices is not None:
            return [str(choice) for choice in action.choices if not str(choice).startswith("_")]
        source = names.get(action.dest) or names.get(action.dest.removesuffix("s"))
        return [] if source is None else source()


def _names_of(words: Sequence[str], given: Mapping[str, Sequence[str]]) -> dict[str, Names]:
    """Return the names of the graph; none if the master does not answer at once.

    Args:
        words: The command line so far.
        given: Its positional arguments.
    """
    from rosproto.cli.graph_options import add_graph_options, master_uri
    from rosproto.node.graph.master_client import MasterClient

    parser = argparse.ArgumentParser(add_help=False)
    add_graph_options(parser)
    options = parser.parse_known_args(list(words))[0]

    def ask(question: Callable[[MasterClient], Iterable[T]]) -> Callable[[], list[T]]:
        def names() -> list[T]:
            try:
                with MasterClient(
                    master_uri(options), "/rosproto_completion", timeout=MASTER_PATIENCE
                ) as master:
                    return list(question(master))
            except (RosError, ValueError):
                return []

        return names

    def values() -> Iterable[str]:
        """Offer the template of a message or request (`{data: ""}`), once."""
        return [] if "values" in given else _template_of(options, given)

    def types() -> Iterable[str]:
        """Offer the topic's type, or all types."""
        topic = given.get("topic", [""])[0]
        known = dict(ask(lambda master: master.get_topic_types().items())()) if topic else {}
        kind = known.get("/" + topic.lstrip("/"), "*")
        return _types(words) if kind == "*" else [kind]

    return {
        "value": values,
        "topic": ask(lambda master: master.get_topic_types()),
        "node": ask(lambda master: master.get_system_state().nodes),
        "service": ask(lambda master: master.get_system_state().services),
        "key": ask(lambda master: master.get_param_names()),
        "type": types,
    }


def _types(words: Sequence[str]) -> list[str]:
    from rosproto.msg import bundled

    library = bundled()
    listing = {"srv": library.services, "service": library.services, "action": library.actions}
    kind = listing.get(words[0] if words else "", library.messages)
    return [
        name if "/" in name else f"{package}/{name}"
        for package in library.packages()
        for name in kind(package)
    ]


def template(cls: type[Message]) -> str:
    """`{header: {seq: 0, stamp: now, frame_id: ""}, x: 0.0}`: YAML in one line, without single quotes.

    Args:
        cls: A message class.
    """
    from rosproto.codec.dicts import to_dict

    return _flow(to_dict(cls()))


def _flow(value: object) -> str:
    if isinstance(value, dict):
        stamped = value.keys() == {"seq", "stamp", "frame_id"} and isinstance(value["stamp"], dict)
        parts = [
            f"{name}: {'now' if stamped and name == 'stamp' else _flow(item)}" for name, item in value.items()
        ]
        return "{" + ", ".join(parts) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_flow(item) for item in value) + "]"
    return json.dumps(value)


def _template_of(options: argparse.Namespace, given: Mapping[str, Sequence[str]]) -> list[str]:
    """Return the template for `topic pub TOPIC TYPE` and `service call NAME`, or nothing."""
    from rosproto.cli.graph_clients import absolute
    from rosproto.cli.graph_options import library_for
    from rosproto.cli.service import type_of
    from rosproto.codec import message_class, service_class

    try:
        if "type" in given:
            kind = given["type"][0]
            return [template(message_class(kind, library_for(options, kind)))]
        if "service" in given:
            kind = type_of(options, absolute(given["service"][0]))
            request = service_class(kind, library_for(options, kind, "srv")).Request
            return [template(request)] if request.__slots__ else []
    except (RosError, ValueError):
        pass  # unknown type or no answer: no template
    return []
