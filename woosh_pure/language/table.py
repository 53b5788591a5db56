"""Translates English sentences by a table.

The table is text: an English template, the translation on the next line, then an empty line; `#` begins a
comment. `{name}` is a placeholder for a value, with the same name in both.

    the name {name} does not resolve: {error}
    名称 {name} 无法解析：{error}

A `rosproto.sentence.Sentence` is looked up by its template; a plain text is its own template. Sentences
joined by "; " are looked up as a whole, then one by one. Sentences without a translation stay English;
`python -m tools.templates` lists them.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Iterable, Iterator, Mapping
from enum import Enum
from functools import lru_cache
from importlib import resources
from string import Formatter
from typing import Any, NamedTuple

from rosproto.sentence import Sentence

__all__ = ["Translation", "Translator", "forms_of", "key_of", "read_table", "translator_for"]

_BETWEEN = "; "
_BOTH, _LISTED = "{first}; {second}", "{first}, {second}"
_STOPS = ("？", "！", "。")
_CHINESE = re.compile("[\u3400-\u9fff]")
_BLANK_BEHIND, _BLANK_BEFORE = re.compile(" [\u3400-\u9fff]"), re.compile("[\u3400-\u9fff] $")


class Translation(NamedTuple):
    """A row of the table.

    Attributes:
        english: The template, with `{name}` for each value.
        translated: The translation, with the same names.
    """

    english: str
    translated: str


class Translator:
    """Translates English sentences into one language; without rows it returns them unchanged.

    Args:
        rows: The table.
        language: Language of the table, for values that translate themselves.
    """

    def __init__(self, rows: Iterable[Translation] = (), language: str = "en") -> None:
        self._rows = {row.english: row.translated for row in rows}
        self._language = language
        self._mark = self._rows.get(_BOTH, _BOTH).removeprefix("{first}").removesuffix("{second}")

    def __bool__(self) -> bool:
        """False if the table is empty."""
        return bool(self._rows)

    def has(self, template: str) -> bool:
        """True if the table has a translation of the template."""
        return self._found(template) is not None or self._found(key_of(template)) is not None

    def say(self, text: str) -> str:
        """Translate a sentence; without a translation it stays English."""
        if not isinstance(text, Sentence) or not text.values:
            found = self._found(text)
            return text if found is None else functools.reduce(self._both, found)
        found = self._found(key_of(text.template))
        if found is None:
            return text
        said = {name: self._value(text.values[name], form) for name, form in forms_of(text.template)}
        return functools.reduce(self._both, [self._filled(each, said) for each in found])

    def _found(self, key: str) -> list[str] | None:
        """The translated sentences of a template; None if one is missing. A lone placeholder stays."""
        if key in self._rows and key != _BOTH:
            return [self._rows[key]]
        sentences = key.split(_BETWEEN)
        found = [each if _is_place(each) else self._rows.get(each) for each in sentences]
        known = [each for each in found if each is not None]
        return known if len(known) == len(found) else None

    def _both(self, first: str, second: str) -> str:
        return self._fill(_BOTH, {"first": first, "second": second})

    def _fill(self, key: str, said: Mapping[str, str]) -> str:
        return self._filled(self._rows.get(key, key), said)

    def _filled(self, template: str, said: Mapping[str, str]) -> str:
        """Fill a template with its values.

        A full stop at the end of a value replaces the separator after it. A space of the template between two
        Chinese characters is removed; values stay unchanged.
        """
        done = ""
        for text, name, _ in _parts(template):
            value = said[name] if name else ""
            if done.endswith(_STOPS):
                text = text.removeprefix(self._mark)
            if _BLANK_BEHIND.match(text) and _CHINESE.match(done[-1:]):
                text = text[1:]
            if _BLANK_BEFORE.search(text) and _CHINESE.match(value):
                text = text[:-1]
            done += text + value
        return done

    def _value(self, value: Any, form: str) -> str:
        """Format a value: translate sentences and enum members, leave data unchanged.

        Args:
            value: A value of a sentence.
            form: Its format in the template, such as `{:.2f}`.
        """
        if isinstance(value, (list, tuple)):
            sentences = any(isinstance(each, Sentence) for each in value)
            said = [self._value(each, "{}") for each in value]
            if not sentences:
                return ", ".join(said)
            return functools.reduce(lambda a, b: self._fill(_LISTED, {"first": a, "second": b}), said)
        if isinstance(value, (Sentence, Enum)) and form == "{}":
            return self.say(str(value))
        if said_in := getattr(value, "said", None):
            return str(said_in(self._language))
        return form.format(value)


@lru_cache(maxsize=512)
def _parts(template: str) -> list[tuple[str, str, str]]:
    """(text, name of the following placeholder, its format); the name is "" after the last text."""
    return [
        (text, name or "", f"{{{'!' + how if how else ''}{':' + form if form else ''}}}")
        for text, name, form, how in Formatter().parse(template)
    ]


def key_of(template: str) -> str:
    """The table's form of a template: placeholders as `{name}`, without formats."""
    return "".join(text + (f"{{{name}}}" if name else "") for text, name, _ in _parts(template))


def forms_of(template: str) -> list[tuple[str, str]]:
    """Name and format, such as `{:.2f}`, of each placeholder."""
    return [(name, form) for _, name, form in _parts(template) if name]


def _is_place(key: str) -> bool:
    return key.startswith("{") and key.endswith("}") and key[1:-1].isidentifier()


def read_table(text: str, name: str = "table") -> Iterator[Translation]:
    """Yield the rows of a table.

    Raises:
        ValueError: A sentence has no translation, or the translation has other placeholders.
    """
    for block in re.split(r"\n\s*\n", text):
        lines = [line for line in block.splitlines() if line.strip() and not line.startswith("#")]
        if not lines:
            continue
        if len(lines) != 2:
            raise ValueError(
                f"{name}: {lines[0]!r}: expected a sentence and its translation, got {len(lines)} lines"
            )
        row = Translation(*lines)
        there, here = (sorted({place for place, _ in forms_of(side)}) for side in row)
        if there != here:
            raise ValueError(f"{name}: {row.english!r}: the places are {there}, in the translation {here}")
        yield row


@lru_cache(maxsize=4)
def translator_for(language: str) -> Translator:
    """The translator for a language of `LANGUAGES`; the one for English has no rows."""
    if language == "en":
        return Translator()
    folder = resources.files(__package__).joinpath(language)
    tables = sorted(
        (entry for entry in folder.iterdir() if entry.name.endswith(".txt")), key=lambda e: e.name
    )
    rows = (row for entry in tables for row in read_table(entry.read_text(encoding="utf-8"), entry.name))
    return Translator(rows, language)
