"""English sentences, looked up in a table and said in another language.

The table is text: an English sentence, below it the translation, then an empty line; `#` begins a
comment. `{name}` stands for what is filled in, and has the same name in both.

A `rosproto.sentence.Sentence` is found by its template, and its values are filled in. Other texts are
matched with the English sentences (the rooms that still say those are listed in `test_complete.py`):
`{name}` matches anything but the "; " that joins sentences, `{name+}` matches that, too. What is filled in is
translated itself where the table has it, but for `{name=}`: a name that somebody has given.

    the name {name} does not resolve: {error}
    名称 {name} 无法解析：{error}
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache
from importlib import resources
from string import Formatter
from typing import Any, NamedTuple

from rosproto.sentence import Sentence, sentence_of
from rosproto.text import padded, width

__all__ = ["Row", "Words", "read_table", "words_for"]

_PLACE = re.compile(r"\{(\w+)([+=]?)\}")
_COLUMNS = re.compile(r"( {2,})")
_COLOURED = re.compile(r"\x1b[0-9a-f]*\[[0-9;]*m[^\x1b]*\x1b[0-9a-f]*\[0m")
_KEPT = "\ue000"  # stands for a coloured word while the sentence around it is looked up
_LONGEST = 1000  # characters: what is longer comes from somebody else, and may be made to be hard to match
_MOST = 6  # sentences that one row of the table has, and colons before the sentence that is looked for
_ENGLISH = re.compile(r"[A-Za-z]{2,} [a-z]{2,}")


class Row(NamedTuple):
    """A row of the table.

    Attributes:
        english: With `{name}` and `{name+}`.
        translated: With `{name}` for each.
    """

    english: str
    translated: str


_JOINTS = (
    Row("{first}; {second}", "{first}；{second}"),
    Row("{head}: {tail}", "{head}：{tail}"),
    Row("{place}: {tail}", "{place}: {tail}"),
    Row("{first}", "{first}"),
)
"""How sentences are joined: `rosproto.sentence.both` and `led`."""


class Words:
    """Says English sentences in another language; without sentences, as they are.

    Args:
        rows: The table.
        rule: Asked for what the table does not have: a translation, or None.
    """

    def __init__(self, rows: Iterable[Row] = (), rule: Callable[[str], str | None] | None = None) -> None:
        self._exact: dict[str, str] = {}
        self._patterns: list[_Pattern] = []
        self._rule = rule
        self._templates: dict[str, _Template] = {row.english: _Template(row) for row in _JOINTS}
        for row in rows:
            if _PLACE.search(row.english):
                self._patterns.append(_Pattern(row))
                template = _Template(row)
                self._templates[template.key] = template
            else:
                self._exact[row.english] = row.translated
        # The pattern with the most fixed text is tried first.
        self._patterns.sort(key=lambda pattern: -pattern.weight)
        # The end of a text is looked up again and again.
        self._sentence = lru_cache(maxsize=512)(self._looked_up)

    def __bool__(self) -> bool:
        """Whether there is anything to translate to."""
        return bool(self._exact or self._patterns)

    def say(self, text: str) -> str:
        """A text for people, also of several lines, columns and colours; what is not known stays English."""
        if not self or text.isspace():
            return text
        if isinstance(text, Sentence) and (said := self._filled(text)) is not None:
            return said
        return "\n".join(map(self._line, text.split("\n")))

    def _filled(self, sentence: Sentence) -> str | None:
        """The translated template with the values; None when the table does not have it."""
        if not sentence.values:
            return self._exact.get(sentence.template)
        places = _places(sentence.template)
        template = self._templates.get(
            "".join(f"{text}{{{name}}}" if name else text for text, name, _ in places)
        )
        if template is None:
            return None
        values = sentence.values
        said = {
            name: self._value(values[name], form, name in template.names) for _, name, form in places if name
        }
        return re.sub("(?<=[？！。])；", "", _PLACE.sub(lambda place: said[place[1]], template.translated))

    def _value(self, value: Any, form: str, given: bool) -> str:
        """What is filled in: a sentence in this language, data as it is.

        Args:
            value: Of a sentence.
            form: How its template has it: `{:.2f}`.
            given: It is a name that somebody has given.
        """
        if isinstance(value, (list, tuple)):
            sentences = any(isinstance(each, (Sentence, BaseException)) for each in value)
            return ("、" if sentences else ", ").join(self._value(each, "{}", given) for each in value)
        if isinstance(value, BaseException):
            value = sentence_of(value)
        if isinstance(value, Sentence):
            return self.say(value)
        text = form.format(value)
        return text if given or isinstance(value, (int, float)) else self._fact(text)

    def _line(self, line: str) -> str:
        coloured: list[str] = []

        def keep(match: re.Match[str]) -> str:
            coloured.append(match[0])
            return _KEPT

        cells = _COLUMNS.split(_COLOURED.sub(keep, line))
        if "  " in line.strip() and (whole := self._exact.get(line.strip())) is not None:
            return line[: len(line) - len(line.lstrip())] + whole
        said, before, here = "", 0, 0  # columns: of the English line so far, and where its cell began
        for cell in cells:
            here, before = before, before + width(cell)
            if cell.isspace():
                continue
            said = padded(said, here) if width(said) <= here else said + "  " * bool(said)
            said += self._sentence(cell)
        for piece in coloured:
            said = said.replace(_KEPT, piece, 1)
        return padded(said, before) if line.endswith(" ") else said

    def _looked_up(self, text: str) -> str:
        """A cell: one sentence, several, a word before a sentence, or something that is none."""
        if len(text) > _LONGEST:
            return text
        stripped = text.strip()
        known = self._known(stripped)
        if known is None and stripped.endswith(" ..."):
            known = self._sentence(stripped[:-4]) + " ..."
        if known is None:
            known = self._composed(stripped)
        lead = len(text) - len(text.lstrip())
        return text[:lead] + known + " " * (len(text) - lead - len(stripped))

    def _composed(self, text: str) -> str:
        parts = text.split("; ")
        said, complete = self._joined(parts)
        if complete:
            return said
        left, colon, right = text.partition(": ")
        for _ in range(_MOST):
            if not colon:
                break
            after = self._sentence(right)
            if after != right:
                head = self._known(left)
                if head is not None:
                    return f"{head}：{after}"
                if not _ENGLISH.search(left):
                    return f"{left}: {after}"
            further, colon, right = right.partition(": ")
            left = f"{left}: {further}"
        return said

    def _joined(self, parts: list[str]) -> tuple[str, bool]:
        """Sentences in a row: the longest run that the table has, then the rest; were all known?"""
        said, complete, at = [], True, 0
        while at < len(parts):
            for end in range(min(len(parts), at + _MOST), at, -1):
                run = "; ".join(parts[at:end])
                known = self._known(run)
                if known is not None:
                    break
            else:
                known, end = self._words(parts[at]), at + 1
                complete = complete and not _ENGLISH.search(known)
            said.append(known)
            at = end
        return re.sub("(?<=[？！。])；", "", "；".join(said)), complete

    def _words(self, text: str) -> str:
        """Words with commas between them, all of which the table has; other texts stay as they are."""
        listed = [self._known(part) for part in text.split(", ")]
        return text if None in listed else "，".join(filter(None, listed))

    def _known(self, text: str) -> str | None:
        exact = self._exact.get(text)
        if exact is not None:
            return exact
        if self._rule is not None and (found := self._rule(text)) is not None:
            return found
        for pattern in self._patterns:
            facts = pattern.facts(text)
            if facts is not None:
                return pattern.fill(
                    {name: v if name in pattern.names else self._fact(v) for name, v in facts.items()}
                )
        return None

    def _fact(self, text: str) -> str:
        """What is filled in: a sentence or words of the table, a list of such, or a name or number."""
        listed = [self._known(part) for part in text.split(", ")]
        if len(listed) > 1 and None not in listed:
            return "、".join(filter(None, listed))
        known = self._known(text)
        if known is not None:
            return known
        return self._sentence(text) if "; " in text or ": " in text else text


class _Template:
    """A row of the table, found by its English template.

    Attributes:
        key: The template, its places as `{name}`.
        translated: With the same places.
        names: Those of places that somebody has given a name.
    """

    def __init__(self, row: Row) -> None:
        self.key = _PLACE.sub(lambda place: f"{{{place[1]}}}", row.english)
        self.translated = _PLACE.sub(lambda place: f"{{{place[1]}}}", row.translated)
        self.names = {place[1] for place in _PLACE.finditer(row.english) if place[2] == "="}


@lru_cache(maxsize=512)
def _places(template: str) -> list[tuple[str, str, str]]:
    """Text, name of the place behind it, how that is formatted; the last text has no place."""
    return [
        (text, name or "", f"{{{'!' + how if how else ''}{':' + form if form else ''}}}")
        for text, name, form, how in Formatter().parse(template)
    ]


class _Pattern:
    """A sentence with places to fill; compiled when its longest fixed part is first seen."""

    def __init__(self, sentence: Row) -> None:
        self._sentence = sentence
        fixed = _PLACE.split(sentence.english)[::3]
        self._mark = max(fixed, key=len)
        self._regex: re.Pattern[str] | None = None
        self.weight = sum(map(len, fixed))
        self.names = {place[1] for place in _PLACE.finditer(sentence.english) if place[2] == "="}

    def facts(self, text: str) -> dict[str, str] | None:
        """The texts in its places; None when the text does not match."""
        if self._mark not in text:
            return None
        if self._regex is None:
            self._regex = re.compile(self._expression(), re.DOTALL)
        found = self._regex.fullmatch(text)
        return None if found is None else found.groupdict()

    def _expression(self) -> str:
        pieces, at = [], 0
        for place in _PLACE.finditer(self._sentence.english):
            pieces.append(re.escape(self._sentence.english[at : place.start()]))
            pieces.append(f"(?P<{place[1]}>{'.+?' if place[2] == '+' else '(?:(?!; |  ).)+?'})")
            at = place.end()
        return "".join(pieces) + re.escape(self._sentence.english[at:])

    def fill(self, facts: dict[str, str]) -> str:
        """The translation with these facts."""
        return _PLACE.sub(lambda place: facts[place[1]], self._sentence.translated)


def read_table(text: str, name: str = "table") -> Iterator[Row]:
    """The rows of a table.

    Raises:
        ValueError: A sentence has no translation, or other places to fill than it.
    """
    for block in re.split(r"\n\s*\n", text):
        lines = [line for line in block.splitlines() if line.strip() and not line.startswith("#")]
        if not lines:
            continue
        if len(lines) != 2:
            raise ValueError(
                f"{name}: {lines[0]!r}: expected a sentence and its translation, got {len(lines)} lines"
            )
        sentence = Row(*lines)
        there, here = (sorted(place[1] for place in _PLACE.finditer(side)) for side in sentence)
        if sorted(set(there)) != sorted(set(here)) or len(there) != len(set(there)):
            raise ValueError(
                f"{name}: {sentence.english!r}: the places are {there}, in the translation {here}"
            )
        yield sentence


@lru_cache(maxsize=4)
def words_for(language: str) -> Words:
    """The words of a language of `LANGUAGES`; English are none."""
    if language == "en":
        return Words()
    from woosh_pure.language.codes import chinese_of_code

    folder = resources.files(__package__).joinpath(language)
    tables = sorted(
        (entry for entry in folder.iterdir() if entry.name.endswith(".txt")), key=lambda e: e.name
    )
    rows = [row for entry in tables for row in read_table(entry.read_text(encoding="utf-8"), entry.name)]
    return Words(rows, chinese_of_code)
