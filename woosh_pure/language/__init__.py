"""The languages of the commands' texts. Chosen by --lang, else by the environment, else by Windows.

All other packages write English sentences. This package has a table for each other language, with named
placeholders: `zh/*.txt`. A sentence is looked up when it is printed, and its values are filled into the
translation. JSON for programs is not translated. The table (`table.translator_for`) is loaded only for a
language other than English.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from typing import TextIO

__all__ = ["LANGUAGES", "language_of"]

LANGUAGES = ("en", "zh")
_CHINESE = 0x04  # primary language identifier of Windows
_PRIMARY = 0x3FF


def language_of(
    words: Sequence[str] = (),
    environment: Mapping[str, str] | None = None,
    *,
    platform: str = sys.platform,
    stream: TextIO | None = None,
) -> str:
    """One of `LANGUAGES`.

    Args:
        words: Of the command line; a wrong value of --lang is the parser's to refuse.
        environment: LC_ALL, LC_MESSAGES or LANG, the first that is set; None for the process's own.
        platform: As `sys.platform`.
        stream: Where it is to be printed: what cannot be shown there is not chosen unless --lang says so.
    """
    for number, word in enumerate(words):
        name, equals, value = word.partition("=")
        if name == "--lang":
            given = value if equals else next(iter(words[number + 1 :]), "")
            return given if given in LANGUAGES else "en"
        if word == "--":
            break
    environment = os.environ if environment is None else environment
    said = next((environment[n] for n in ("LC_ALL", "LC_MESSAGES", "LANG") if environment.get(n)), None)
    chinese = _windows_is_chinese() if said is None and platform == "win32" else _is_chinese(said or "")
    return "zh" if chinese and _shows_chinese(stream) else "en"


def _is_chinese(locale: str) -> bool:
    """zh_CN.UTF-8, zh_TW, zh-Hans, zh."""
    return locale.lower().replace("-", "_").partition(".")[0].partition("_")[0] == "zh"


def _windows_is_chinese() -> bool:
    """LANG is rarely set there."""
    try:
        import ctypes

        identifier = int(ctypes.windll.kernel32.GetUserDefaultUILanguage())  # type: ignore[attr-defined,unused-ignore]
    except (ImportError, AttributeError, OSError, ValueError):
        return False  # no such library, or not such a Windows
    return identifier & _PRIMARY == _CHINESE


def _shows_chinese(stream: TextIO | None) -> bool:
    encoding = getattr(stream, "encoding", None)
    if not encoding:
        return True  # nothing that could refuse it
    try:
        "底盘".encode(encoding)
    except (UnicodeEncodeError, LookupError):
        return False
    return True
