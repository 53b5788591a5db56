"""Argument types with range checks, and options of several commands.

Numbers are plain decimals in ASCII. Python also accepts `1_0`, `1e1` and digits of other scripts
(from an input method); a typing error must not drive a robot ten metres.
"""

from __future__ import annotations

import argparse
import math
import os
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from rosproto.files import read_text
from rosproto.sentence import say
from rosproto.text import short

_WHOLE = re.compile(r"[+-]?[0-9]{1,20}")  # as many digits as 64 bits have
_DECIMAL = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)")
_QUANTITY = re.compile(r"([+-]?[0-9.]*(?:,(?:[0-9]{1,2}|[0-9]{4,}))?)\s*([^\s0-9.,+-]*)")
_SHOWN = 40
_FROM_TO = "{text}: must be from {minimum:g} to {maximum:g}"
MAX_NUMBER = 10**9
"""A wait of more seconds does not fit into the system's calls."""
MAX_WHOLE = 2**32 - 1
"""The largest count that a queue or a message takes."""


class NotANumber(argparse.ArgumentTypeError, ValueError):
    """A text is not a valid number."""


def finite(text: str) -> float:
    """Parse a number of at most `MAX_NUMBER`, of either sign."""
    value = to_float(text)
    if not abs(value) <= MAX_NUMBER:
        raise NotANumber(say("{text}: must be at most {maximum}", text=_shown(text), maximum=MAX_NUMBER))
    return value


def to_float(text: str) -> float:
    """Convert a plain decimal: `-1.5`, `.5`, `12`.

    Raises:
        NotANumber: It is not one.
    """
    if _DECIMAL.fullmatch(text) is None:
        raise NotANumber(say("{text} is not a plain decimal number such as 0.5 or -12", text=_shown(text)))
    return float(text)


def to_int(text: str) -> int:
    """Convert a plain decimal integer.

    Raises:
        NotANumber: It is not one.
    """
    if _WHOLE.fullmatch(text) is None:
        raise NotANumber(say("{text} is not a whole number", text=_shown(text)))
    return int(text)


def _shown(text: str) -> str:
    """Shorten a long text."""
    return repr(short(text, _SHOWN))


def positive(text: str) -> float:
    """Parse a number above 0."""
    value = finite(text)
    if not value > 0.0:
        raise argparse.ArgumentTypeError(say("{text}: must be above 0", text=_shown(text)))
    return value


def seconds(text: str) -> float:
    """Parse a duration or a speed, 0 or more."""
    value = finite(text)
    if value < 0.0:
        raise argparse.ArgumentTypeError(say("{text}: must be 0 or more", text=_shown(text)))
    return value


class Quantity:
    """An argument type: a number in a unit, which may be written behind it.

    A comma with three digits behind it is refused: it may separate thousands, or be a decimal comma.

    Args:
        noun: What is expected, in the plural.
        examples: Of it.
        units: The accepted units, with the size of each; "" for none.
        maximum: Of its size.
    """

    def __init__(
        self, noun: str, examples: str, units: Mapping[str, float], maximum: float = math.inf
    ) -> None:
        self._noun, self._examples, self.units, self._maximum = noun, examples, units, maximum

    def __call__(self, text: str) -> float:
        """Parse `0.5`, `0,5`, `50cm` or `50 cm`."""
        found = _QUANTITY.fullmatch(text.strip())
        if found is None or not found[1]:
            return finite(text)  # raises
        if found[2] not in self.units:
            expected = "{text}: expected {noun}, such as {examples}"
            noun = say(self._noun)
            raise NotANumber(say(expected, text=_shown(text), noun=noun, examples=self._examples))
        value = finite(found[1].replace(",", ".")) * self.units[found[2]]
        if abs(value) > self._maximum:
            raise NotANumber(say(_FROM_TO, text=_shown(text), minimum=-self._maximum, maximum=self._maximum))
        return value


metres = Quantity("metres", "0.5, 50cm, 1m", {"": 1, "m": 1, "cm": 0.01, "mm": 0.001, "米": 1, "厘米": 0.01})
_RADIAN = math.degrees(1.0)
_DEGREES = {"": 1, "°": 1, "deg": 1, "degrees": 1, "度": 1, "rad": _RADIAN}
degrees = Quantity("degrees", "90, 90°, 1.57rad", _DEGREES)
heading = Quantity("degrees", "90, 90°, 1.57rad", _DEGREES, maximum=360.0)


def natural(text: str) -> int:
    """Parse an integer, 0 or more."""
    return _whole(text, 0)


def count(text: str) -> int:
    """Parse an integer, 1 or more."""
    return _whole(text, 1)


def _whole(text: str, minimum: int, maximum: int = MAX_WHOLE) -> int:
    try:
        value = to_int(text)
    except ValueError:
        value = minimum - 1
    if not minimum <= value <= maximum:
        wrong = "{text} is not a whole number from {minimum} to {maximum}"
        raise argparse.ArgumentTypeError(say(wrong, text=_shown(text), minimum=minimum, maximum=maximum))
    return value


def whole_from(minimum: int, maximum: int) -> Callable[[str], int]:
    """Return the type of an integer from `minimum` to `maximum`."""
    return lambda text: _whole(text, minimum, maximum)


def number_from(minimum: float, maximum: float) -> Callable[[str], float]:
    """Return the type of a number from `minimum` to `maximum`."""

    def parse(text: str) -> float:
        value = finite(text)
        if not minimum <= value <= maximum:
            raise NotANumber(say(_FROM_TO, text=_shown(text), minimum=minimum, maximum=maximum))
        return value

    return parse


def port(text: str) -> int:
    """Parse a TCP port; 0 lets the system choose."""
    if _WHOLE.fullmatch(text) and text.isdigit() and int(text) <= 65535:
        return int(text)
    raise argparse.ArgumentTypeError(say("{text} is not a port (0 to 65535)", text=_shown(text)))


def host(text: str) -> str:
    """Parse a host name or an address of this computer."""
    from rosproto.transport.uri import plain_host

    try:
        return plain_host(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def folder_exists(text: str) -> Path:
    """Parse the path of a new file; refuse a missing folder before the work."""
    path = Path(text)
    if path.is_dir():
        raise argparse.ArgumentTypeError(say("{text} is a folder; give the name of a file", text=text))
    if not path.parent.is_dir():
        raise argparse.ArgumentTypeError(
            say("folder {folder} does not exist; create it first", folder=path.parent)
        )
    return path


AddArguments = Callable[[argparse.ArgumentParser], object]
"""What gives a parser its arguments."""


def argument(*names: str, **options: Any) -> AddArguments:
    """Return the `add_arguments` of a verb with a single argument; parameters as `add_argument`."""
    return lambda parser: parser.add_argument(*names, **options)


def add_json(parser: argparse.ArgumentParser) -> None:
    """--json."""
    parser.add_argument("--json", action="store_true", help="print facts as JSON, for programs")


def add_allow_damaged(parser: argparse.ArgumentParser) -> None:
    """--allow-damaged; see `bag_files.opened`."""
    parser.add_argument(
        "--allow-damaged",
        action="store_true",
        help="exit code 0 even if a bag is damaged and messages may be missing",
    )


def add_quiet(parser: argparse.ArgumentParser) -> None:
    """-q."""
    parser.add_argument("-q", "--quiet", action="store_true", help="print errors only")


def add_compression(parser: argparse.ArgumentParser, default: str = "none") -> None:
    """Add --lz4 and --bz2, the compression of a bag."""
    group = parser.add_mutually_exclusive_group()
    group.add_argument(
        "--lz4", action="store_const", const="lz4", dest="compression", default=default, help="compress, fast"
    )
    group.add_argument(
        "-j", "--bz2", action="store_const", const="bz2", dest="compression", help="compress more, slowly"
    )


# -- the token of a server -----------------------------------------------------------------------------------
# On the command line, where others on this computer can read it, in a file, or in the environment.


def add_token(parser: argparse.ArgumentParser, variable: str, meaning: str) -> None:
    """Add --token and --token-file.

    Args:
        parser: Of the command.
        variable: The environment variable that is read when neither is given.
        meaning: What the token is for.
    """
    given = parser.add_mutually_exclusive_group()
    given.add_argument("--token", help=f"{meaning}; other users of this computer can see it")
    given.add_argument(
        "--token-file",
        type=Path,
        metavar="FILE",
        help=f"a file with the token, readable only by you (or ${variable})",
    )


def token_of(arguments: argparse.Namespace, variable: str) -> str | None:
    """Return the given token, or None.

    Raises:
        ValueError: Other users can read the file, or it has no token.
        OSError: The file cannot be read.
    """
    path: Path | None = arguments.token_file
    if arguments.token is not None:
        return str(arguments.token)
    if path is None:
        return os.environ.get(variable) or None
    if path.is_dir():
        raise ValueError(say("{path} is a folder; expected a file with the token", path=path))
    if os.name == "posix" and path.stat().st_mode & 0o077:
        raise ValueError(say("{path}: other users can read it; run chmod 600 {path}", path=path))
    token = read_text(path).strip()
    if not token:
        raise ValueError(say("{path}: there is no token in it", path=path))
    return token
