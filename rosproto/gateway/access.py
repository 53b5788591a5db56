"""`Access`: which names clients of a gateway may read and write.

Everything is readable unless `allow` or `deny` says otherwise. Nothing is writable without a pattern in
`write`: velocities, goals, poses and calls can all move a robot, and a name does not show which ones do. The
few services that only answer are recognised by their type.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fnmatch import translate
from typing import Literal

Kind = Literal["topic", "service", "parameter", "action", "node"]

_WRITING: dict[Kind, str] = {
    "topic": "publishing on",
    "service": "calling or providing",
    "parameter": "setting",
    "action": "sending goals to or cancelling",
    "node": "changing",
}
_PREFIXES: dict[str, Kind] = {**{kind: kind for kind in _WRITING}, "param": "parameter"}
_ONLY_ANSWER = frozenset({"roscpp/GetLoggers", "tf2_msgs/FrameGraph", "nav_msgs/GetMap"})
"""Types of services that change nothing. The md5sum of a call verifies the type."""

_SHOWN = 200  # characters of a client's text in a sentence


@dataclass(frozen=True, slots=True)
class Refusal:
    """Why a request is refused, for the client and the log.

    Attributes:
        kind: Kind of the name.
        name: The name.
        text: A sentence with the reason and the option that allows it.
    """

    kind: str
    name: str
    text: str

    def __str__(self) -> str:
        return self.text


class Refused(Exception):
    """A client's request is refused; the text is a sentence for the client."""


def insist(refusal: Refusal | None) -> None:
    """Raise `Refused` if there is a refusal."""
    if refusal is not None:
        raise Refused(refusal.text)


class Access:
    """Decides for each name whether clients of a gateway may read or write it.

    A pattern is a name with `*`, `?` and `[...]` as in a shell, except that `*` also matches slashes. It
    applies to everything of that name, or, with the prefix `topic:`, `service:`, `action:`, `param:` or
    `node:`, to that kind only. An action is named without its topics; a client that may send goals to
    `/move_base` may also do so by publishing on `/move_base/goal` and `/move_base/cancel`.

    Args:
        allow: Visible names.
        deny: Hidden names; it has precedence over `allow` and `write`.
        write: Names that clients may publish on, call, provide, set or send goals to. None by default.
        read_only: Refuse all writes, whatever `write` says.

    Raises:
        ValueError: A pattern is empty or has an unknown kind.
    """

    def __init__(
        self,
        *,
        allow: Iterable[str] = ("*",),
        deny: Iterable[str] = (),
        write: Iterable[str] = (),
        read_only: bool = False,
    ) -> None:
        self.allow = _given(allow)
        self.deny = _given(deny)
        self.write = _given(write)
        self.read_only = read_only
        self._allowed = _Patterns(self.allow)
        self._denied = _Patterns(self.deny)
        self._written = _Patterns(self.write)

    def __repr__(self) -> str:
        return (
            f"Access(allow={self.allow!r}, deny={self.deny!r}, write={self.write!r},"
            f" read_only={self.read_only!r})"
        )

    @property
    def writes_anything(self) -> bool:
        """Whether any write may be allowed."""
        return bool(self.write) and not self.read_only

    def may_read(self, kind: Kind, name: str) -> Refusal | None:
        """Return None if the name is visible, else the reason."""
        if self._denied.match(kind, name):
            return Refusal(kind, name, f"{kind} {short(name)} is not open here: a --deny pattern covers it")
        if not self._allowed.match(kind, name):
            return Refusal(kind, name, f"{kind} {short(name)} is not open here: no --allow pattern covers it")
        return None

    def may_write(self, kind: Kind, name: str, type: str = "") -> Refusal | None:
        """Return None if the name may be written, else the reason.

        Args:
            kind: The kind of name; "action" for a goal or its cancel.
            name: Resolved name; that of an action without `/goal`.
            type: Type of the topic or service by its provider; "" if unknown.
        """
        refused = self._hidden(kind, name)
        if refused is not None:
            return refused
        if kind == "service" and type in _ONLY_ANSWER:
            return None
        doing = f"{_WRITING[kind]} {kind} {short(name)}"
        if self.read_only:
            return Refusal(kind, name, f"{doing} is refused: this gateway is read only (--read-only)")
        if self._written.match(kind, name) or (
            kind == "topic"
            and (action := _action_of(name)) is not None
            and self._written.match("action", action)
        ):
            return None
        prefix = "param" if kind == "parameter" else kind
        return Refusal(
            kind,
            name,
            f"{doing} is refused: nothing is written through this gateway unless a pattern opens it;"
            f" start it with --allow-write {prefix}:{short(name)}",
        )

    def _hidden(self, kind: Kind, name: str) -> Refusal | None:
        """As `may_read`; for an action, its topics are checked too, and the other way round."""
        refused = self.may_read(kind, name)
        if refused is None and kind == "topic" and (action := _action_of(name)) is not None:
            refused = self.may_read("action", action)
        if refused is None and kind == "action":
            refused = self.may_read("topic", f"{name}/goal") or self.may_read("topic", f"{name}/cancel")
        return refused


def _given(patterns: Iterable[str]) -> tuple[str, ...]:
    if isinstance(patterns, str):
        raise ValueError(f"patterns are a list of texts; for one alone write [{patterns!r}]")
    return tuple(patterns)


def _action_of(topic: str) -> str | None:
    """The action of a goal or cancel topic; None for other topics."""
    action, slash, last = topic.rpartition("/")
    return action if slash and action and last in ("goal", "cancel") else None


class _Patterns:
    """Patterns, compiled into one regular expression for each kind."""

    def __init__(self, patterns: Sequence[str]) -> None:
        by_kind: dict[str, list[str]] = {kind: [] for kind in _WRITING}
        for pattern in patterns:
            kinds, glob = _parsed(pattern)
            for kind in kinds:
                by_kind[kind].append(translate(glob))
        self._regexes = {
            kind: re.compile("|".join(globs)) if globs else None for kind, globs in by_kind.items()
        }

    def match(self, kind: Kind, name: str) -> bool:
        regex = self._regexes[kind]
        return regex is not None and regex.match(name) is not None


def _parsed(pattern: str) -> tuple[tuple[str, ...], str]:
    prefix, colon, rest = pattern.partition(":")
    kinds: tuple[str, ...] = tuple(_WRITING)
    if colon:
        if prefix not in _PREFIXES:
            raise ValueError(
                f"pattern {pattern!r}: {prefix!r} is no kind; one of topic, service, action, param, node"
            )
        kinds, pattern = (_PREFIXES[prefix],), rest
    if not pattern:
        raise ValueError("a pattern is empty; * is everything")
    return kinds, pattern if pattern[0] in "/*?[" else f"/{pattern}"


def short(text: str) -> str:
    """A client's text for a sentence."""
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."
