"""The languages of texts for people. Chosen by --lang, else by the environment, else by Windows.

All other packages write English sentences. This package has a table for each other language, with named
placeholders: `zh/*.txt`. A sentence is looked up when it is printed, and its values are filled into the
translation. JSON for programs is not translated. The table (`table.translator_for`) is loaded only for a
language other than English.

In Python, `str(x)` is English everywhere, so logs, tests and reports of faults are the same on each computer.
`x.sentence()` and `said(x)` are in the language of the user.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from typing import TextIO

from rosproto.sentence import sentence_of

__all__ = ["LANGUAGES", "Spoken", "language_of", "said", "translated"]

LANGUAGES = ("en", "zh")
_CHINESE = 0x04  # primary language identifier of Windows
_PRIMARY = 0x3FF


class Spoken:
    """Base of what has a text for people, its `str()`."""

    __slots__ = ()

    def sentence(self, lang: str | None = None) -> str:
        """Return the text in a language, see `said`; `str()` is the English text."""
        return said(self, lang)


def said(thing: object, lang: str | None = None) -> str:
    """Return the text of an exception, an outcome or another object in a language.

    Args:
        thing: What has no translation stays English.
        lang: One of `LANGUAGES`; None for the user's, as the commands choose it (`language_of`).

    Raises:
        ValueError: The language is not one of `LANGUAGES`.
    """
    text = sentence_of(thing) if isinstance(thing, BaseException) else str(thing)
    return translated(text, language_of(stream=sys.stdout) if lang is None else lang)


def translated(text: str, language: str) -> str:
    """Return a text in a language of `LANGUAGES`."""
    if language not in LANGUAGES:
        raise ValueError(f"lang={language!r}: expected one of {', '.join(LANGUAGES)}")
    if language == "en":
        return text
    from woosh_pure.language.table import translator_for

    return translator_for(language).say(text)


def language_of(
    words: Sequence[str] = (),
    environment: Mapping[str, str] | None = None,
    *,
    platform: str = sys.platform,
    stream: TextIO | None = None,
) -> str:
    """One of `LANGUAGES`.

    Args:
        words: Of the command line; a wrong value of --lang is the parser's to refuse (`cn`: in Chinese).
        environment: LC_ALL, LC_MESSAGES or LANG, the first that is set; None for the process's own.
        platform: As `sys.platform`.
        stream: Where it is to be printed: what cannot be shown there is not chosen unless --lang says so.
    """
    for number, word in enumerate(words):
        name, equals, value = word.partition("=")
        if name == "--lang":
            given = value if equals else next(iter(words[number + 1 :]), "")
            meant = "zh" if given[:2].lower() in ("zh", "cn", "中文", "汉语") else "en"
            return given if given in LANGUAGES else meant
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
