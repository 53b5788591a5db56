"""Who may do what through a gateway: verdicts over names, and over connections.

Reading is open, unless `allow` or `deny` says otherwise. Writing is closed, unless a pattern of `write` opens
it: whatever can move a robot is written (a velocity, a goal, a pose, a call), and which of all the topics do
so nobody can tell from their names alone. The few services that only answer are known by their type.
"""

from __future__ import annotations

import hmac
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fnmatch import translate
from ipaddress import ip_address
from typing import Literal
from urllib.parse import urlsplit

__all__ = [
    "Access",
    "Kind",
    "Refusal",
    "foreign_host",
    "foreign_origin",
    "is_loopback_host",
    "require_token_off_loopback",
    "token_fits",
]

Kind = Literal["topic", "service", "parameter", "action", "node"]

_PREFIXES: dict[str, Kind] = {
    "topic": "topic",
    "service": "service",
    "parameter": "parameter",
    "param": "parameter",
    "action": "action",
    "node": "node",
}
_WRITING: dict[Kind, str] = {
    "topic": "publishing on",
    "service": "calling or providing",
    "parameter": "setting",
    "action": "sending goals to or cancelling",
    "node": "changing",
}
_ONLY_ANSWER = frozenset({"roscpp/GetLoggers", "tf2_msgs/FrameGraph", "nav_msgs/GetMap"})
"""Services that tell and change nothing, by type: the md5sum of the call holds them to it."""

_SHOWN = 200  # characters of a client's name in a sentence


@dataclass(frozen=True, slots=True)
class Refusal:
    """Why something is not done, for the client and the log.

    Attributes:
        kind: What it was about.
        name: Its name.
        text: One sentence: what was refused, why, which option opens it.
    """

    kind: str
    name: str
    text: str

    def __str__(self) -> str:
        return self.text


class Access:
    """What clients of a gateway may see and change; asked for each name.

    A pattern is a name with `*`, `?` and `[...]` as the shell has them, and `*` matches slashes, too. It
    counts for everything of that name, or with `topic:`, `service:`, `action:`, `param:` or `node:` in front
    for that kind. An action is named without its topics; whoever may send goals to `/move_base` may do it by
    publishing on `/move_base/goal` and `/move_base/cancel`.

    Args:
        allow: What is seen at all.
        deny: What is not, though `allow` has it; wins over everything.
        write: What may be published on, called, provided, set, or given goals. Nothing at first.
        read_only: Refuse all of that whatever `write` says.

    Raises:
        ValueError: A pattern is empty or of no such kind.
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
        """None, or why this is not shown."""
        if self._denied.match(kind, name):
            return Refusal(kind, name, f"{kind} {_short(name)} is not open here: a --deny pattern covers it")
        if not self._allowed.match(kind, name):
            return Refusal(
                kind, name, f"{kind} {_short(name)} is not open here: no --allow pattern covers it"
            )
        return None

    def may_write(self, kind: Kind, name: str, type: str = "") -> Refusal | None:
        """None, or why this may not be changed.

        Args:
            kind: What is written: for a goal or its end "action".
            name: Resolved name; of an action without `/goal`.
            type: Of the topic or service, as its provider states it; "" when nobody knows.
        """
        refused = self._hidden(kind, name)
        if refused is not None:
            return refused
        if kind == "service" and type in _ONLY_ANSWER:
            return None
        doing = f"{_WRITING[kind]} {kind} {_short(name)}"
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
            f" start it with --allow-write {prefix}:{_short(name)}",
        )

    def _hidden(self, kind: Kind, name: str) -> Refusal | None:
        """As `may_read`, for a goal by either of its two ways."""
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
    """The action whose goals or cancels go over this topic, if one's do."""
    action, slash, last = topic.rpartition("/")
    return action if slash and action and last in ("goal", "cancel") else None


class _Patterns:
    """Patterns as one expression for each kind."""

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


def _short(name: str) -> str:
    return name if len(name) <= _SHOWN else f"{name[:_SHOWN]}..."


# -- connections --------------------------------------------------------------------------------------------


def token_fits(given: str | None, expected: str | None) -> bool:
    """Whether a client knows the token; compared in constant time. True where none is asked for."""
    if expected is None:
        return True
    return hmac.compare_digest((given or "").encode("utf-8", "replace"), expected.encode("utf-8"))


def is_loopback_host(host: str) -> bool:
    """Whether a host, as written in an address, is this computer alone: 127.0.0.0/8, ::1, localhost."""
    host = host.strip("[]").lower()
    if host == "localhost":
        return True
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return False


def require_token_off_loopback(host: str, token: str | None) -> None:
    """A gateway that others than this computer reach has to ask who they are.

    Raises:
        ValueError: It would not.
    """
    if token is not None and not token:
        raise ValueError("the token is empty; give a long random one")
    if token is None and not is_loopback_host(host):
        raise ValueError(
            f"{host or 'every address'} is reached from other computers, and who reaches a gateway sees the"
            f" robot: give a token (--token, in a program token=...), or listen on 127.0.0.1"
        )


def foreign_origin(origin: str | None, origins: Sequence[str]) -> str | None:
    """Why a page of this origin may not connect; None when it may.

    A browser sends the origin of the page with every WebSocket, and lets any page open one to any address: so
    a page on the internet would reach a robot through the browser of whoever looks at it. Without an origin
    it is no browser. Pages of this computer's own servers (`http://localhost:8080`) may.

    Args:
        origin: The header; None when there is none.
        origins: Origins that may, as a browser writes them; "*" for all.
    """
    if origin is None or origin in origins or "*" in origins:
        return None
    try:
        parts = urlsplit(origin)
        host = parts.hostname if parts.scheme in ("http", "https") else None
    except ValueError:
        host = None
    if host is not None and is_loopback_host(host):
        return None
    return (
        f"a page of {_short(origin)!r} may not connect; open it with --origin {_short(origin)}"
        if host is not None
        else f"a page whose origin is {_short(origin)!r} may not connect"
    )


def foreign_host(host: str | None, bound: str) -> str | None:
    """Why a request for this host is not for us, where we listen on loopback; None when it may be.

    Somebody's name that leads to 127.0.0.1 makes a page of his the same origin as a server here.

    Args:
        host: The Host header.
        bound: The address that is listened on.
    """
    if not is_loopback_host(bound) or host is None:
        return None
    name = host.rpartition(":")[0] if host.rpartition(":")[2].isdigit() else host
    if is_loopback_host(name):
        return None
    return f"this gateway serves this computer alone, and {_short(host)!r} is not its name: use localhost"
