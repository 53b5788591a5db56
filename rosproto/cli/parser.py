"""The argument parser of both commands: one-line errors with near matches and the next step."""

from __future__ import annotations

import argparse
import itertools
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from typing import Any, NoReturn, cast

from rosproto.sentence import Sentence, both, hint, say
from rosproto.text import wrapped

WRONG_USE = 2


class WrongUse(SystemExit):
    """The arguments are invalid; the error is already on stderr. Exit code 2.

    Attributes:
        text: The error without the usage line.
    """

    def __init__(self, text: str) -> None:
        super().__init__(WRONG_USE)
        self.text = text


class _Formatter(argparse.HelpFormatter):
    """A help formatter that omits actions and translates headings and texts."""

    def __init__(
        self,
        *args: Any,
        spoken: Callable[[str], str],
        hidden: Sequence[argparse.Action] = (),
        **options: Any,
    ) -> None:
        super().__init__(*args, **options)
        self._spoken, self._hidden = spoken, hidden

    def add_argument(self, action: argparse.Action) -> None:
        """See argparse."""
        if action not in self._hidden:
            super().add_argument(action)

    def add_usage(self, usage: Any, actions: Any, groups: Any, prefix: str | None = None) -> None:
        """See argparse."""
        super().add_usage(usage, actions, groups, f"{self._spoken('usage')}: " if prefix is None else prefix)

    def start_section(self, heading: str | None) -> None:
        """See argparse."""
        super().start_section(heading and self._spoken(heading))

    def add_text(self, text: str | None) -> None:
        """See argparse."""
        super().add_text(text and self._spoken(text))

    def _get_help_string(self, action: argparse.Action) -> str | None:
        return action.help and self._spoken(action.help)

    def _split_lines(self, text: str, width: int) -> list[str]:
        return super()._split_lines(text, width) if text.isascii() else wrapped(text, width)

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        return "\n".join(indent + line for line in self._split_lines(text, width - len(indent)))


class Parser(argparse.ArgumentParser):
    """An argparse parser with one-line usage, examples in the help, and similar words in errors.

    Args:
        shared: A parser with options for this one and its verbs; the help of the whole command lists them.

    Attributes:
        examples: Commands to copy.
        meant: Returns the probably intended command for a word that is not a choice; None or "" for none.
    """

    examples: Sequence[str] = ()
    meant: Callable[[str], str | None] = staticmethod(lambda word: None)

    @property
    def actions(self) -> Sequence[argparse.Action]:
        """The arguments in the order of addition; argparse has no public list."""
        return self._actions

    @property
    def options(self) -> Mapping[str, argparse.Action]:
        """The options by each of their names."""
        return {text: action for action in self.actions for text in action.option_strings}

    def format_help(self) -> str:
        """Return the help with usage in one line."""
        self.usage = synopsis(self.prog, self).replace("%", "%%")
        lines = "".join(f"  {line}\n" for line in self.examples)
        return super().format_help() + (f"\n{self.spoken('examples')}:\n{lines}" if lines else "")

    def __init__(self, *args: Any, shared: Parser | None = None, **options: Any) -> None:
        # `parse_known_args` says the error; `--no` must not mean the only option that begins so.
        options["exit_on_error"] = options["allow_abbrev"] = False
        hidden: Sequence[argparse.Action] = ()
        if shared is not None:
            options["parents"], hidden = [shared], shared.actions
        options["formatter_class"] = partial(_Formatter, spoken=self.spoken, hidden=hidden)
        super().__init__(*args, **options)
        self._shared = shared

    def error(self, message: str) -> NoReturn:
        """Print the error on stderr and end with code 2."""
        text = both(self._with_verbs(message), say("see: {command}", command=f"{self.prog} --help"))
        usage = f"{self.spoken('usage')}: {synopsis(self.prog, self)}"
        with suppress(SystemExit, BrokenPipeError):
            self.exit(WRONG_USE, f"{usage}\n{self.prog}: {self.spoken(text)}\n")
        raise WrongUse(f"{self.prog}: {text}")

    def spoken(self, text: str) -> str:
        """Return the text of an error or of the help; a subclass may translate it."""
        return text

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse, and report unknown words in the innermost parser.

        argparse fills a positional only from one group of adjacent words. In `play -r 2 a.bag /b` and
        `pub /cmd TYPE -r 1 -- 1 2` the remaining words are added to the argument that takes many.
        """
        self._check_places(args or ())
        try:
            found, rest = super().parse_known_args(self._with_units(args), namespace)
        except argparse.ArgumentError as error:
            why, name = _own_words(error.message), error.argument_name
            self.error(say("argument {name}: {why}", name=name, why=why) if name else why)
        many = [a for a in self.actions if not a.option_strings and a.nargs in ("*", "+")]
        if rest and many:
            words, rest = _plain_words(rest)
            setattr(found, many[-1].dest, [*(getattr(found, many[-1].dest, None) or ()), *words])
        if rest:
            words = [word.partition("=")[0] for word in rest if word.startswith("-")]
            unknown = say("not understood: {words}", words=" ".join(rest))
            self.error(both(unknown, *hint(words[0], self.options)) if words else unknown)
        return found, rest

    def _check_places(self, words: Sequence[str]) -> None:
        """Refuse an option before the command that follows one: its value would be read as the command."""
        verbs = [verb for action in self.actions for verb in verbs_of(action)]
        before = itertools.takewhile(lambda word: verbs and word not in verbs, words)
        names = (word.partition("=")[0] for word in before if word.startswith("--"))
        if wrong := next((name for name in names if name not in {*self.options, "--"}), ""):
            line = f"{self.prog} {next((word for word in words if word in verbs), 'COMMAND')} ... {wrong}"
            place = say("an option of a command is written behind it: {line}", line=line)
            self.error(both(say("not understood: {words}", words=wrong), *hint(wrong, self.options), place))

    def _with_units(self, words: Sequence[str] | None) -> Sequence[str] | None:
        """Join `1 m`, and put a blank in front of `-90°`, which argparse takes for an option without it."""
        if words is None or "--" in words or any(a.nargs in ("...", argparse.PARSER) for a in self.actions):
            return words
        units = {unit for action in self.actions for unit in getattr(action.type, "units", ()) if unit}
        joined: list[str] = []
        for word in words:
            if joined and word in units and re.fullmatch(r"[+-]?[0-9.,]+", joined[-1]):
                joined[-1] += word
            else:
                joined.append(word)
        return [f" {word}" if re.match(r"-\.?[0-9][^ ]*[^0-9. ]", word) else word for word in joined]

    def add_subparsers(self, **options: Any) -> Any:
        """Like argparse's; the verbs also have the options of `shared`."""
        if self._shared is not None:
            verb = partial(type(self), shared=self._shared, epilog=self.epilog)
            options.setdefault("parser_class", verb)
        return super().add_subparsers(**options)

    def options_with_value(self) -> set[str]:
        """Return the options with a value: `--chassis`."""
        return {text for text, action in self.options.items() if action.nargs != 0}

    def _check_value(self, action: argparse.Action, value: object) -> None:
        """Check a choice; similar choices come first in the error."""
        if action.choices is None or value in action.choices:
            return
        shown = [str(choice) for choice in action.choices if not str(choice).startswith("_")]
        wrong = say(
            "unknown {noun} {value!r}" if verbs_of(action) else "{value!r} is not a valid {noun}",
            value=value,
            noun=_noun(action),
        )
        if meant := self.meant(str(value)):
            raise argparse.ArgumentError(None, both(wrong, say("did you mean {names}?", names=f"`{meant}`")))
        raise argparse.ArgumentError(
            None, both(wrong, *hint(str(value), shown), say("one of: {names}", names=shown))
        )

    def _with_verbs(self, message: str) -> str:
        """Complete the error of a missing verb with the list of verbs."""
        for action in self.actions:
            verbs = verbs_of(action)
            if verbs and message.endswith(f": {action.metavar}"):
                return say("{what} is missing; one of: {names}", what=_noun(action), names=", ".join(verbs))
        return _own_words(message)


_OF_ARGPARSE = (
    "the following arguments are required: {names}",
    "expected {count} arguments",
    "ignored explicit argument {value}",
    "not allowed with argument {other}",
    "one of the arguments {names} is required",
)


def _own_words(message: str) -> str:
    """Convert argparse's error text to a sentence; ours are sentences already."""
    if isinstance(message, Sentence):
        return message
    for template in _OF_ARGPARSE:
        pattern = re.sub(r"\\{(\w+)\\}", r"(?P<\1>.+)", re.escape(template))
        if found := re.fullmatch(pattern, message):
            return say(template, **found.groupdict())
    return message


def verbs_of(action: argparse.Action) -> Mapping[str, Parser]:
    """Return the sub-parsers of an argument by word; empty for other arguments."""
    return cast("Mapping[str, Parser]", action.choices) if action.nargs == argparse.PARSER else {}


def _plain_words(rest: Sequence[str]) -> tuple[list[str], list[str]]:
    """Split into values, with all after `--`, and options."""
    before, after = list(rest), []
    if "--" in before:
        at = before.index("--")
        before, after = before[:at], before[at + 1 :]
    words = [word for word in before if not word.startswith("-")]
    return [*words, *after], [word for word in before if word.startswith("-")]


def _noun(action: argparse.Action) -> Sentence:
    if action.option_strings:
        return say("value of {option}", option=action.option_strings[-1])
    return say(str(action.metavar or action.dest).lower())


def near(word: str, names: Iterable[str]) -> str:
    """`; did you mean /odom or /odom_raw?`, "" when no name is near."""
    return "".join(f"; {hint}" for hint in hint(word, names))


def synopsis(command: str, parser: Parser, known: Iterable[str] = ("-h", "--help")) -> str:
    """`rosproto topic echo [options] topic`; `known` are options that need no `[options]`."""
    words, left_out = [command], set(known)
    if any(set(action.option_strings) - left_out for action in parser.actions if _shown(action)):
        words.append(parser.spoken("[options]"))
    for action in parser.actions:
        if not action.option_strings and _shown(action):
            names = value_names(action)
            names = parser.spoken(names) if names.isupper() else names  # others are words of an error, too
            words.append(f"[{names}]" if action.nargs in ("?", "*") else names)
    return " ".join(words)


def _shown(action: argparse.Action) -> bool:
    return action.help != argparse.SUPPRESS


def value_names(action: argparse.Action) -> str:
    """Return the metavars, the same on every version of Python."""
    if action.nargs == argparse.PARSER:
        return str(action.metavar or "COMMAND")
    if isinstance(action.metavar, tuple):
        return " ".join(action.metavar)
    name = action.metavar
    if name is None and action.choices is not None:
        name = "|".join(str(choice) for choice in action.choices)
    if name is None:
        name = action.dest if not action.option_strings else action.dest.upper()
    if action.nargs in ("*", "+", argparse.REMAINDER):
        return f"{name} ..."
    return " ".join([name] * action.nargs) if isinstance(action.nargs, int) else name


def sub_parsers(parser: Parser) -> Iterator[tuple[str, Parser]]:
    """Yield (name, parser) of the verbs or commands."""
    for action in parser.actions:
        yield from verbs_of(action).items()


def give_examples(parser: Parser, examples: Mapping[str, Sequence[str]]) -> None:
    """Set the examples of a command and its verbs; keys are command lines without the program's name."""
    for one in {id(p): p for p in (parser, *leaves(parser))}.values():
        one.examples = examples.get(one.prog.partition(" ")[2], ())


def leaves(parser: Parser) -> Sequence[Parser]:
    """Return the parsers without verbs."""
    below = [leaf for _, sub in sub_parsers(parser) for leaf in leaves(sub)]
    return below or [parser]
