"""Translatable sentences: English text that keeps its template and values.

`say("{topic}: nothing was received within {seconds:g} s", ...)` returns a `str`, so errors, logs and
documents have the English text. A command looks up the template in the table of its language and fills in
the same values, so no code parses a sentence.

A sentence that becomes a plain `str` (an f-string around it, `"; ".join`, a slice) is English and is not
translated. `both` and `led` keep it translatable.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable, Mapping
from enum import Enum
from string import Formatter

from rosproto.text import near_names, printable

__all__ = ["Sentence", "advice", "both", "hint", "led", "say", "sentence_of", "shown"]


class Sentence(str):
    """A text with its template and values; equal to its text. Make it with `say`.

    Attributes:
        template: With `{name}` for each value, as for `str.format`.
        values: The values. A `Sentence`, an error or object whose text is one, a member of an enum, and a
            list of these are translated as well; every other value is data and the same in each language. A
            value with a method `said(language)` translates itself. Of other objects only the text is kept.
        key: Of `advice`; "" for other sentences.
    """

    __slots__ = ("key", "template", "values")
    template: str
    values: Mapping[str, object]
    key: str

    def __str__(self) -> str:
        return self

    def __reduce__(self) -> tuple[object, ...]:
        return _restored, ("".join(self), self.template, dict(self.values), self.key)

    def advised(self, templates: Mapping[str, str]) -> Sentence:
        """With other advice here and in the values, where the mapping has a template for its key."""
        values = {name: _advised(value, templates) for name, value in self.values.items()}
        return _made(templates.get(self.key, self.template), values, self.key)

    def escaped(self, keep: str = "") -> str:
        """Safe for a terminal: the values are escaped, see `rosproto.text`."""
        if printable(self, keep=keep) == self:
            return self
        values = {name: _escaped(value, keep) for name, value in self.values.items()}
        made = _made(self.template, values, self.key)
        return made if printable(made, keep=keep) == made else printable(made, keep=keep)


def say(template: str, /, **values: object) -> Sentence:
    """Make a sentence; the template is its key in the tables of other languages. A `Sentence` is returned as
    it is.

    Args:
        template: `{name}`, `{name!r}`, `{name:.2f}`; a list or tuple is joined by commas.
        values: For each name. A plain text is data; make a word that must be translated a `Sentence`.
    """
    return template if isinstance(template, Sentence) else _made(template, values)


def advice(template: str, /, *, key: str, **values: object) -> Sentence:
    """Make a sentence for Python programs; a command or an API says its own by the key: see `advised`."""
    return _made(template, values, key)


def _made(template: str, values: Mapping[str, object], key: str = "") -> Sentence:
    text = template.format_map({n: _listed(v) for n, v in values.items()}) if values else template
    return _restored(text, template, {n: _kept(v, n, template) for n, v in values.items()}, key)


def _restored(text: str, template: str, values: Mapping[str, object], key: str = "") -> Sentence:
    sentence = Sentence(text)
    sentence.template = template
    sentence.values = values
    sentence.key = key
    return sentence


def _listed(value: object) -> object:
    return ", ".join(map(str, value)) if isinstance(value, (list, tuple)) else value


class _FormattedValue(str):
    """The formatted text of an object, whatever format is asked for later."""

    __slots__ = ()

    def __repr__(self) -> str:
        return "".join(self)

    def __format__(self, spec: str) -> str:
        return "".join(self)


def _kept(value: object, name: str, template: str) -> object:
    """The part of a value that a sentence keeps: nothing that may change, be large, or fail to be copied."""
    if isinstance(value, (list, tuple)):
        return [_kept(each, "", "") for each in value]
    if isinstance(value, BaseException):
        return say(sentence_of(value))
    if value is None or isinstance(value, (str, int, float, Enum)) or hasattr(value, "said"):
        return value
    text = str(value)
    if isinstance(text, Sentence):
        return text
    if hasattr(value, "__float__"):  # numpy's numbers can be formatted
        return value
    for _, place, spec, how in Formatter().parse(template):
        if place == name:
            return _FormattedValue(
                f"{{{'!' + how if how else ''}{':' + spec if spec else ''}}}".format(value)
            )
    return text


def both(first: str, *more: str) -> Sentence:
    """Join sentences: `first; second`."""
    return functools.reduce(lambda a, b: say("{first}; {second}", first=a, second=say(b)), more, say(first))


def led(head: str, tail: str) -> Sentence:
    """Put a subject in front of a sentence: `head: tail`. A plain `str` as head is a name or place."""
    if isinstance(head, Sentence):
        return say("{head}: {tail}", head=head, tail=say(tail))
    return say("{place}: {tail}", place=head, tail=say(tail))


def hint(word: str, names: Iterable[str], cutoff: float = 0.72) -> list[Sentence]:
    """`did you mean /odom or /odom_raw?`, for `both`; empty when no name is near, see `near_names`."""
    found = near_names(word, names, cutoff=cutoff)
    either = functools.reduce(lambda a, b: say("{first} or {second}", first=a, second=b), found or [""])
    return [say("did you mean {names}?", names=either)] if found else []


def sentence_of(error: BaseException) -> str:
    """The text of an error, as a `Sentence` if it was made of one."""
    if isinstance(error, KeyError) and error.args:
        return str(error.args[0])  # str() of a KeyError adds quotes
    return str(error)


def _advised(value: object, templates: Mapping[str, str]) -> object:
    if isinstance(value, BaseException):
        value = sentence_of(value)
    if isinstance(value, Sentence):
        return value.advised(templates)
    if isinstance(value, (list, tuple)):
        return [_advised(each, templates) for each in value]
    return value


def shown(text: str, keep: str = "") -> str:
    """Safe for a terminal, see `rosproto.text.printable`; a `Sentence` stays one."""
    return text.escaped(keep) if isinstance(text, Sentence) else printable(text, keep=keep)


def _escaped(value: object, keep: str) -> object:
    if isinstance(value, BaseException):
        value = sentence_of(value)
    if isinstance(value, str):
        return shown(value, keep)
    if isinstance(value, (list, tuple)):
        return [_escaped(each, keep) for each in value]
    return value
