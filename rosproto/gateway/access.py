"""`Access`: which names clients of a gateway may read and write.

Everything is readable unless `allow` or `deny` says otherwise. Nothing is writable without a pattern in
`write`: velocities, goals, poses and calls can all move a robot, and a name does not show which ones do. The
few services that only answer are recognised by their type.

Every name is compared in its canonical form, whatever the client's spelling: `//a/b/` is `/a/b`.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from fnmatch import translate
from typing import Literal

from rosproto.names import canonicalize
from rosproto.sentence import both, say
from rosproto.text import short

Kind = Literal["topic", "service", "parameter", "action", "node", "api"]

_WRITING: dict[Kind, str] = {
    "topic": "publishing on",
    "service": "calling or providing",
    "parameter": "setting",
    "action": "sending goals to or cancelling",
    "node": "changing",
    "api": "requesting",
}
_PREFIXES: dict[str, Kind] = {**{kind: kind for kind in _WRITING}, "param": "parameter"}
ACTION_PARTS = frozenset(("cancel", "feedback", "goal", "result", "status"))
"""The topics of an action, below its name."""
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
    applies to everything of that name, or, with the prefix `topic:`, `service:`, `action:`, `param:`, `node:`
    or `api:` (a command of another protocol, as `api:Twist`), to that kind only. An action is named without
    its topics; a client that may send goals to `/move_base` may also do so by publishing on
    `/move_base/goal` and `/move_base/cancel`.

    A pattern of `deny` also covers everything below a name: `/walk` hides `/walk/goal`, and `/` everything.
    An action and its five topics are hidden together. `allow` and `write` open only what they match.

    Args:
        allow: Visible names.
        deny: Hidden names, and all below them; it has precedence over `allow` and `write`.
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
        self._denied = _Patterns(self.deny, below=True)
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
        name = _global(name)
        refused = self.denied(kind, name)
        if refused is None and not self._allowed.match(kind, name):
            text = f"{kind} {short(name, _SHOWN)} is not open here: no --allow pattern covers it"
            refused = Refusal(kind, name, text)
        return refused

    def shows(self, kind: Kind, name: str) -> bool:
        """Whether clients may see a name."""
        return self.may_read(kind, name) is None

    def visible(self, kind: Kind, names: Iterable[str]) -> list[str]:
        """The visible ones of some names, sorted, without duplicates."""
        return sorted(name for name in set(names) if self.shows(kind, name))

    def denied(self, kind: Kind, name: str) -> Refusal | None:
        """The reason if `deny` covers the name; for an action also if it covers one of its topics."""
        name = _global(name)
        others: list[tuple[Kind, str]] = []
        if kind == "action":
            others = [("topic", f"{name}/{part}") for part in ACTION_PARTS]
        elif kind == "topic" and (action := _action_of(name, ACTION_PARTS)) is not None:
            others = [("action", action)]
        if any(self._denied.match(*each) for each in ((kind, name), *others)):
            return Refusal(
                kind, name, f"{kind} {short(name, _SHOWN)} is not open here: a --deny pattern covers it"
            )
        return None

    def may_write(self, kind: Kind, name: str, type: str = "") -> Refusal | None:
        """Return None if the name may be written, else the reason.

        Args:
            kind: The kind of name; "action" for a goal or its cancel.
            name: Resolved name; that of an action without `/goal`.
            type: Type of the topic or service by its provider; "" if unknown.
        """
        name = _global(name)
        refused = self._hidden(kind, name)
        if refused is not None:
            return refused
        if kind == "service" and type in _ONLY_ANSWER:
            return None
        shown = short(name.lstrip("/") if kind == "api" else name, _SHOWN)
        doing = f"{_WRITING[kind]} {kind} {shown}"
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
            f" start it with --allow-write {prefix}:{shown}",
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
        raise ValueError(f"patterns must be a list of strings; for a single one write [{patterns!r}]")
    return tuple(patterns)


def _global(name: str) -> str:
    """The canonical form of a resolved name."""
    return canonicalize(f"/{name}")


def _action_of(topic: str, parts: Collection[str] = ("goal", "cancel")) -> str | None:
    """The action of a goal or cancel topic; None for other topics."""
    action, slash, last = topic.rpartition("/")
    return action if slash and action and last in parts else None


class _Patterns:
    """Patterns, compiled into one regular expression for each kind.

    Args:
        patterns: As they were given.
        below: They also match everything below a name that they match.
    """

    def __init__(self, patterns: Sequence[str], *, below: bool = False) -> None:
        by_kind: dict[str, list[str]] = {kind: [] for kind in _WRITING}
        for pattern in patterns:
            kinds, glob = _parsed(pattern)
            for kind in kinds:
                by_kind[kind].append(translate(glob))
                if below:
                    by_kind[kind].append(translate(f"{glob.rstrip('/')}/*"))
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
            wrong = say("pattern {pattern!r}: {kind!r} is not a kind", pattern=pattern, kind=prefix)
            raise ValueError(both(wrong, "one of topic, service, action, param, node, api"))
        kinds, pattern = (_PREFIXES[prefix],), rest
    if not pattern:
        raise ValueError("a pattern is empty; * matches everything")
    return kinds, canonicalize(pattern if pattern[0] in "/*?[" else f"/{pattern}")
