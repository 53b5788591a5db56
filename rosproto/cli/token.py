"""The token of a server: on the command line, where others on this computer can read it, in a file, or in
the environment.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from rosproto.files import read_text
from rosproto.sentence import say


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
        help=f"the token in a file that only you may read (or ${variable}); nobody else sees it",
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
        raise ValueError(say("{path}: others may read it; run chmod 600 {path}", path=path))
    token = read_text(path).strip()
    if not token:
        raise ValueError(say("{path}: there is no token in it", path=path))
    return token
