"""The messages between a program and its watchdog, and when the watchdog acts. Pure: callers pass the time.

Each line of the pipe is one JSON object. The program sends `Prepare`, `Arm`, `Disarm`, `Drop` and
`Heartbeat`. The watchdog replies `Ready` when a watch is prepared, again when that changes, and every second
while lines come; and `Sent` when it has acted although the program is still alive. Any line from the program
counts as a heartbeat; the end of the pipe means that it has ended.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from rosproto.errors import RemoteProtocolError

HEARTBEAT_SECONDS = 0.1  # between two heartbeats while a watch is armed
SILENCE_SECONDS = 0.8  # without a line, after which the program counts as gone
PAUSES = (0.01, 0.02, 0.04, 0.2)
"""Seconds between two rounds. The first ones are quick: the robot may read the program's last velocity, which
is on another connection, after the first zero, and the watchdog may be killed soon after the program."""
ROUNDS = len(PAUSES) + 1
"""How often a zero or a cancel is sent, by this process and by the watchdog: one can be lost."""
READY_SECONDS = 1.0  # between two reports of the watchdog while the program talks to it
_SUFFIX = "_rosproto_watchdog"


def watchdog_name(node: str, taken: int = 0) -> str:
    """Name of the watchdog's node for a watched node, when so many names were taken by other nodes."""
    return f"{node}_{taken + 1}{_SUFFIX}" if taken else f"{node}{_SUFFIX}"


def is_watchdog_name(node: str) -> bool:
    """Whether a node is a program's watchdog: it publishes velocity topics, but never drives."""
    return node.endswith(_SUFFIX)


@dataclass(frozen=True, slots=True)
class WatchedNode:
    """The watched node and its graph.

    Attributes:
        master_uri: URI of the master.
        node: Name of the watched node.
        host: Address under which this computer is reached; None finds it.
        resolve: Host name -> address.
        msg_path: Folders with additional definitions.
    """

    master_uri: str
    node: str
    host: str | None = None
    resolve: Mapping[str, str] = field(default_factory=dict)
    msg_path: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class LastMessage:
    """A message to publish when the program has ended.

    Attributes:
        topic: The topic.
        type: "package/Type".
        text: Full definition of the type.
        data: The encoded message. The stamp of its header, if it has one, is set when it is sent.
    """

    topic: str
    type: str
    text: str
    data: bytes


@dataclass(frozen=True, slots=True)
class LastCall:
    """A service to call when the program has ended.

    Attributes:
        service: Its name.
        type: "package/Type".
        data: The encoded request.
        seconds: For so long it is called again and again, since what it ends may be followed by more.
    """

    service: str
    type: str
    data: bytes
    seconds: float = 0.0


@dataclass(frozen=True, slots=True)
class LastRequest:
    """A POST over HTTP when the program has ended, to a server that answers `{"ok": ..., "body": {...}}`.

    Attributes:
        uri: Of the server.
        path, body: The request, JSON.
        ask_path: A request that only asks, with the body {}: it opens the connection in advance.
        only_if: A key of the body of its answer, and the value as text: with another one nothing is sent. It
            is sent if that cannot be asked. Empty: sent in any case, in each round.
        headers: Of HTTP.
        seconds: For so long it is sent again and again, since what it ends may be followed by more.
    """

    uri: str
    path: str
    body: str
    ask_path: str
    only_if: tuple[str, ...] = ()
    headers: Mapping[str, str] = field(default_factory=dict)
    seconds: float = 0.0


@dataclass(frozen=True, slots=True)
class Prepare:
    """Prepare to send this; the reply is `Ready`."""

    key: int
    watched: WatchedNode
    messages: tuple[LastMessage, ...] = ()
    calls: tuple[LastCall, ...] = ()
    requests: tuple[LastRequest, ...] = ()
    armed: bool = True


@dataclass(frozen=True, slots=True)
class Arm:
    """Something moves from now on; `data` replaces the contents of the messages."""

    key: int
    data: tuple[bytes, ...] = ()


@dataclass(frozen=True, slots=True)
class Disarm:
    """It has stopped; stay prepared."""

    key: int


@dataclass(frozen=True, slots=True)
class Drop:
    """The watch has ended; discard what was prepared."""

    key: int


@dataclass(frozen=True, slots=True)
class Heartbeat:
    """The program is alive."""


@dataclass(frozen=True, slots=True)
class Ready:
    """The watch of the key is prepared; `problem` says what could not be. Told again all the time."""

    key: int
    problem: str = ""


@dataclass(frozen=True, slots=True)
class Sent:
    """The program was silent for `seconds`, so the watchdog has acted."""

    keys: tuple[int, ...]
    seconds: float


Line = Prepare | Arm | Disarm | Drop | Heartbeat | Ready | Sent
_KINDS: dict[str, type[Line]] = {kind.__name__: kind for kind in Line.__args__}


def write_line(line: Line) -> bytes:
    """Encode a line, with its line end."""
    fields = {"line": type(line).__name__, **asdict(line)}
    return json.dumps(fields, default=_text_of).encode() + b"\n"


def _text_of(value: object) -> str:
    if isinstance(value, bytes):
        return base64.b64encode(value).decode()
    raise TypeError(f"{type(value).__name__} cannot be encoded in a line")


def read_line(data: bytes) -> Line:
    """Decode a line.

    Raises:
        RemoteProtocolError: It is invalid.
    """
    try:
        fields = json.loads(data)
        kind = _KINDS[fields.pop("line")]
        if kind is Prepare:
            fields["watched"] = WatchedNode(
                **{**fields["watched"], "msg_path": tuple(fields["watched"]["msg_path"])}
            )
            fields["messages"] = tuple(LastMessage(**_with_bytes(each)) for each in fields["messages"])
            fields["calls"] = tuple(LastCall(**_with_bytes(each)) for each in fields["calls"])
            fields["requests"] = tuple(
                LastRequest(**{**each, "only_if": tuple(each["only_if"])}) for each in fields["requests"]
            )
        elif kind is Arm:
            fields["data"] = tuple(base64.b64decode(each) for each in fields["data"])
        elif kind is Sent:
            fields["keys"] = tuple(fields["keys"])
        line: Line = kind(**fields)
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise RemoteProtocolError(f"not a line of a watchdog's pipe: {data[:80]!r}") from error
    return line


def _with_bytes(fields: dict[str, Any]) -> dict[str, Any]:
    return {**fields, "data": base64.b64decode(fields["data"])}


class WatchTable:
    """The watches, and what is due now.

    A watch is prepared, and armed while something moves. When the program is silent, each armed watch is due
    at once and in a few more rounds (a zero can be lost, and a cancel can overtake its goal). After a silence
    has been handled, the next one counts only after another heartbeat. The end of the pipe makes every armed
    watch due again.

    Args:
        now: When the last line came.
    """

    def __init__(self, now: float) -> None:
        self._heard = now
        self._acted = False
        self._armed: set[int] = set()
        self._rounds: dict[int, int] = {}
        self._next = now
        self.ended = False
        """The pipe has ended."""

    @property
    def armed(self) -> tuple[int, ...]:
        """Keys of the armed watches."""
        return tuple(sorted(self._armed))

    def heard(self, now: float) -> None:
        """A line came."""
        self._heard, self._acted = now, False

    def arm(self, key: int) -> None:
        """Arm a watch."""
        self._armed.add(key)
        if self.ended:  # the pipe ended while it was being prepared
            self._rounds[key] = ROUNDS

    def disarm(self, key: int) -> None:
        """Disarm a watch."""
        self._armed.discard(key)
        self._rounds.pop(key, None)

    def end(self, now: float) -> None:
        """The pipe has ended: all armed watches are due now."""
        self.ended = True
        self._begin(now)

    def _begin(self, now: float) -> None:
        self._acted, self._next = True, now
        self._rounds = dict.fromkeys(self._armed, ROUNDS)

    def silent(self, now: float) -> float:
        """Seconds of a silence that must be handled now; returned once, else 0.0."""
        seconds = now - self._heard
        if self._acted or self.ended or not self._armed or seconds < SILENCE_SECONDS:
            return 0.0
        self._begin(now)
        return seconds

    def due(self, now: float) -> tuple[int, ...]:
        """Keys of the watches to send now; each call is one round."""
        if not self._rounds or now < self._next:
            return ()
        keys, left = tuple(sorted(self._rounds)), max(self._rounds.values())
        self._next = now + PAUSES[min(ROUNDS - left, len(PAUSES) - 1)]
        self._rounds = {key: left - 1 for key, left in self._rounds.items() if left > 1}
        return keys

    def wait(self, now: float) -> float | None:
        """Seconds until something can be due; None if nothing is armed, or everything was sent."""
        if self._rounds:
            return max(0.0, self._next - now)
        if self._armed and not self._acted and not self.ended:
            return max(0.0, self._heard + SILENCE_SECONDS - now)
        return None
