"""`ApiLink`: one WebSocket to a robot, made again when it is lost. Needs the extra `api`.

Nobody waits for the socket: one thread connects and reads, another one writes. A velocity is sent at once or
never: the slot holds the newest one only, for `FRESH_SECONDS`, and never repeats it. A zero goes first.
"""

from __future__ import annotations

import itertools
import json
import queue
import socket
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager
from functools import partial
from typing import Any, NamedTuple

from rosproto.errors import CodecError, ConnectionLost, LocalProtocolError, RosError, RosTimeout
from rosproto.extras import optional_module
from rosproto.json_text import JsonError
from rosproto.logs import get_logger
from rosproto.sentence import both, say, sentence_of
from rosproto.text import printable
from rosproto.transport import Backoff, Deadline, HostNames, connect, interrupt, make_uri, next_item
from woosh_pure.errors import ApiRefused
from woosh_pure.robot_api import wire
from woosh_pure.robot_api.http import MAX_BYTES, WANTS_PASSWORD, ApiAddress, authorization, body_of, read_json
from woosh_pure.robot_api.translate import ROBOT
from woosh_pure.robot_api.wire import Values

OPEN_SECONDS = 3.0
LATE_SECONDS, GONE_SECONDS = 0.5, 2.0
"""Seconds without an answer after which the link is late, and after which it is given up."""
MAX_UNANSWERED = 4  # velocities
FORGET_SECONDS, MAX_OPEN = 60.0, 200
"""A request without an answer is forgotten after so many seconds; so many of them end the connection."""
FRESH_SECONDS = 0.3
ZEROS, ZERO_PAUSE, ZERO_AGAIN, MAX_ZEROS = 3, 0.05, 0.25, 40
"""A zero is sent so often and so many seconds apart; then more seldom, until one is accepted."""
TWIST = ROBOT + "Twist"
_log = get_logger("woosh_pure.api_bridge")
Answer = Values | RosError
"""The values of an answer, or why there are none: it is refused, late, lost or does not fit."""
Done = Callable[[Answer], object]


class _Asked(NamedTuple):
    """A request without an answer; `prompt` ones are answered at once while the link is good."""

    request: str
    done: Done
    prompt: bool
    at: float


def _subscription(topics: list[str], wanted: bool) -> str:
    return json.dumps({"type": wire.SUBSCRIPTION, "body": {"sub": wanted, "topics": topics}})


def _answer(request: str, frame: object) -> Answer:
    try:
        return wire.load(wire.requests()[request].answer, body_of(request, frame))
    except RosError as error:
        return error


class ApiLink:
    """A connection to the Robot API. Thread-safe; only `ask`, `start` and `close` wait.

    Args:
        topics: Subscribed as soon as it is connected.
        received: Called with the type and the values of each push, in the reading thread.
        refused: Called with the robot's words when it refuses a velocity, in the reading thread.

    Attributes:
        number: How often it has connected.
        up: Whether it is connected.
    """

    def __init__(
        self,
        address: ApiAddress,
        topics: Iterable[str],
        received: Callable[[str, Values], object],
        refused: Callable[[str], object],
        hosts: HostNames | None = None,
    ) -> None:
        missing = LocalProtocolError(
            'a robot at ws:// needs the package websockets (14 or newer): pip install ".[api]"'
        )
        self._websockets = optional_module("websockets.sync.client", missing)
        self._problems = optional_module("websockets.exceptions", missing)
        self.address, self._hosts, self._topics = address, hosts, {*topics}
        self.uri = make_uri(address.host, address.port, "ws")
        self._received, self._refused = received, refused
        self.number, self.up = 0, False
        self._news = threading.Condition()
        self._queue: deque[str] = deque()  # to be sent, as texts
        self._asked: dict[int, _Asked] = {}
        self._numbers = itertools.count(1)
        self._slot: tuple[Values, float] | None = None  # the newest velocity, and when it came
        self._zeros: int | None = None  # sent since one was due; None: none is due
        self._zero_at, self._zero_taken, self._zero_series = 0.0, False, 0
        self._refused_series = -1  # in which a velocity was refused: none is sent until the next zero
        self._driving = False
        self._socket: socket.socket | None = None
        self._connection: Any = None
        self._ended, self._tried = threading.Event(), threading.Event()
        self._failed: RosError | None = None
        self._threads = [
            threading.Thread(target=work, name=f"woosh:robot api {name}", daemon=True)
            for name, work in (("link", self._run), ("writing", self._write))
        ]

    def start(self) -> None:
        """Connect, and stay connected.

        Raises:
            ConnectionLost, RosTimeout, ApiRefused: It does not succeed; it is not tried again.
        """
        for thread in self._threads:
            thread.start()
        self._tried.wait(OPEN_SECONDS + 1.0)
        if not self.up:
            failed = self._failed or RosTimeout(say("no answer"), what=self.uri, seconds=OPEN_SECONDS)
            self.close()
            raise failed

    def close(self) -> None:
        """Send the zero that is due, and end the connection. Bounded; may be called again."""
        self.end_drive()
        with self._news:
            self._news.wait_for(lambda: self._zeros is None or not self.up, 1.0)
        self._ended.set()
        self.cut()
        with self._news:
            self._news.notify_all()
        for thread in self._threads:
            if thread.is_alive() and thread is not threading.current_thread():
                thread.join(3.0)

    def cut(self) -> None:
        """End the present connection; what waits to be sent is discarded. It is made again unless closed."""
        if (sock := self._socket) is not None:
            interrupt(sock, deliver=False)

    # -- asking ---------------------------------------------------------------------------------------------

    def post(
        self,
        request: str,
        body: Mapping[str, Any] | None = None,
        done: Done = lambda answer: None,
        *,
        prompt: bool = False,
    ) -> None:
        """Send a request. Does not wait.

        Args:
            done: Called with the answer, or why there is none; in the reading thread.
            prompt: Whether the link counts as late if the answer is late.

        Raises:
            CodecError: A value does not fit.
        """
        values = wire.dump(request, body or {}, zeros=False)
        with self._news:
            if len(self._asked) >= MAX_OPEN:
                self.cut()  # a robot that leaves so many without an answer
            elif self.up:
                self._queue.append(self._text(request, values, done, prompt=prompt))
                self._news.notify_all()
                return
        done(self._lost())

    def ask(self, request: str, body: Mapping[str, Any] | None = None, timeout: float = 5.0) -> Values:
        """Send a request and return the values of the answer.

        Raises:
            ApiRefused: The robot refused.
            ConnectionLost, RosTimeout: There is no answer.
            CodecError: The answer does not fit.
        """
        answers: queue.SimpleQueue[Answer] = queue.SimpleQueue()
        self.post(request, body, answers.put)
        try:
            answer = next_item(answers, timeout)
        except queue.Empty:
            raise self._late(request, timeout) from None
        if isinstance(answer, RosError):
            raise answer
        return answer

    def _lost(self) -> ConnectionLost:
        return ConnectionLost(say("{uri}: the connection is lost", uri=self.uri), peer=self.uri)

    def _late(self, request: str, seconds: float) -> RosTimeout:
        late = "{uri} has not answered {request} in {seconds} s"
        text = say(late, uri=self.uri, request=request, seconds=seconds)
        return RosTimeout(text, what=request, seconds=seconds)

    def subscribe(self, topic: str, wanted: bool) -> None:
        """Begin or end the pushes of a topic. Does not wait."""
        with self._news:
            (self._topics.add if wanted else self._topics.discard)(topic)
            self._queue.append(_subscription([topic], wanted))
            self._news.notify_all()

    @property
    def silence(self) -> float:
        """Seconds for which the oldest prompt request has no answer; 0 if none is open."""
        with self._news:
            return max((time.monotonic() - one.at for one in self._asked.values() if one.prompt), default=0.0)

    # -- velocities -----------------------------------------------------------------------------------------

    def velocity(self, body: Values) -> None:
        """Send a velocity at once, or not at all; after a refused one not before a zero. Does not wait."""
        values = wire.dump(TWIST, body, zeros=False)
        with self._news:
            if self.up and self._refused_series != self._zero_series:
                self._slot = values, time.monotonic()
                self._news.notify_all()

    def zero(self) -> None:
        """Send zero before everything else, several times and until one is accepted. Does not wait."""
        with self._news:
            self._want_zero()
            self._news.notify_all()

    def end_drive(self) -> None:
        """Send zero if a velocity was sent since the last one. Does not wait."""
        with self._news:
            if self._driving or self._slot is not None:
                self._want_zero()
            self._news.notify_all()

    @property
    def zero_due(self) -> bool:
        """Whether a zero is not accepted yet."""
        return self._zeros is not None

    def _want_zero(self) -> None:
        self._slot, self._zero_taken = None, False
        self._zero_series += 1
        self._zero_at = min(self._zero_at, time.monotonic() + ZERO_PAUSE)
        self._zeros = 0

    def _zero_answered(self, series: int, answer: Answer) -> None:
        with self._news:
            if isinstance(answer, ConnectionLost) or series != self._zero_series or self._zeros is None:
                return  # a velocity may have been sent after that zero
            self._zero_taken |= not isinstance(answer, RosError)
            if self._zeros >= (ZEROS if self._zero_taken else MAX_ZEROS):
                if not self._zero_taken:
                    _log.warning("! %s: the robot accepts no zero velocity: %s", self.uri, answer)
                self._zeros, self._driving = None, False
                self._news.notify_all()

    def _velocity_answered(self, series: int, answer: Answer) -> None:
        if isinstance(answer, ApiRefused):
            with self._news:
                self._refused_series = series
                self._slot = None if series == self._zero_series else self._slot
            self._refused(answer.robot_text)

    # -- the two threads ------------------------------------------------------------------------------------

    def _write(self) -> None:
        while not self._ended.is_set():
            with self._news:
                text, wait = self._next(time.monotonic())
                if text is None:
                    self._news.wait(wait)
                    continue
                connection = self._connection
            try:
                connection.send(text)
            except (self._problems.WebSocketException, OSError):
                pass  # the reading thread sees the end as well

    def _next(self, now: float) -> tuple[str | None, float | None]:
        """The next text to send, or how long there is none; the lock is held."""
        if not self.up:
            return None, None
        if self._zeros is not None:
            if now >= self._zero_at:
                self._zeros += 1
                self._zero_at = now + (ZERO_PAUSE if self._zeros < ZEROS else ZERO_AGAIN)
                done = partial(self._zero_answered, self._zero_series)
                return self._text(TWIST, {}, done, prompt=True), None
        elif self._slot is not None and self._twists < MAX_UNANSWERED:
            (values, at), self._slot = self._slot, None
            if now - at <= FRESH_SECONDS:
                self._driving = True
                done = partial(self._velocity_answered, self._zero_series)
                return self._text(TWIST, values, done, prompt=True, at=at), None
        if self._queue:
            return self._queue.popleft(), None
        return None, None if self._zeros is None else max(0.0, self._zero_at - now)

    @property
    def _twists(self) -> int:
        return sum(one.request == TWIST for one in self._asked.values())

    def _text(self, request: str, body: Values, done: Done, *, prompt: bool, at: float | None = None) -> str:
        """The text of a request, whose answer is expected from now on; the lock is held."""
        number = next(self._numbers)
        self._asked[number] = _Asked(request, done, prompt, time.monotonic() if at is None else at)
        return json.dumps({"type": request, "body": body, "sn": number})

    def _run(self) -> None:
        pauses = Backoff(0.2)
        while not self._ended.is_set():
            try:
                with self._opened() as connection:
                    if self._ended.is_set():
                        return  # `close` has cut the connection before this one
                    pauses.reset()
                    self._begin(connection)
                    try:
                        for text in connection:
                            self._take(text)
                    finally:
                        self._end()
            except RosError as error:
                self._failed = error
                self._tried.set()
                _log.debug("= %s", error)
            except (self._problems.WebSocketException, OSError, EOFError) as error:
                _log.debug("= %s: %s", self.uri, error)
            self._ended.wait(pauses.next())

    def _opened(self) -> AbstractContextManager[Any]:
        advice = say("is it the address of a robot with a Robot API (port 5480)?")
        try:
            sock = connect(self.address.host, self.address.port, Deadline(OPEN_SECONDS), hosts=self._hosts)
        except (ConnectionLost, RosTimeout) as error:
            raise ConnectionLost(both(sentence_of(error), advice), peer=self.uri) from error
        self._socket = sock
        try:
            made: AbstractContextManager[Any] = self._websockets.connect(
                self.uri,
                sock=sock,
                additional_headers=authorization(self.address),
                compression=None,
                open_timeout=OPEN_SECONDS,
                close_timeout=1.0,
                max_size=MAX_BYTES,
            )
            return made
        except (self._problems.WebSocketException, OSError, EOFError) as error:
            sock.close()
            if getattr(getattr(error, "response", None), "status_code", 0) == 401:
                raise ApiRefused("WebSocket", "", WANTS_PASSWORD, status=401) from error
            what = say("{uri} does not answer as a Robot API: {error}", uri=self.uri, error=error)
            raise ConnectionLost(both(what, advice), peer=self.uri) from error

    def _begin(self, connection: Any) -> None:
        with self._news:
            self._connection, self.up = connection, True
            self._queue = deque([_subscription(sorted(self._topics), True)])
            self.number += 1
            self._news.notify_all()
        self._tried.set()

    def _end(self) -> None:
        with self._news:
            self.up = False
            if self._driving or self._slot is not None or self._zeros is not None:
                self._want_zero()
            waiting = [*self._asked.values()]
            self._asked.clear()
            self._queue.clear()
            self._news.notify_all()
        for asked in waiting:
            self._call(partial(asked.done, self._lost()))

    def _take(self, text: str | bytes) -> None:
        try:
            self._forget()
            frame = read_json(text)
            if not isinstance(frame, dict):
                raise CodecError("it is not an object")
            if "ok" in frame:
                number = frame.get("sn")
                with self._news:
                    asked = self._asked.pop(number, None) if isinstance(number, int) else None
                    self._news.notify_all()  # another velocity may be sent
                if asked is not None:
                    self._call(partial(asked.done, _answer(asked.request, frame)))
                elif frame.get("type") == wire.SUBSCRIPTION and frame["ok"] is False:
                    _log.warning("! %s: it does not push: %s", self.uri, printable(str(frame.get("msg", ""))))
            elif isinstance(name := frame.get("type"), str) and name in self._topics:
                self._call(partial(self._received, name, wire.load(name, frame.get("body"))))
        except (JsonError, CodecError) as error:
            _log.debug("! %s: a message that does not fit: %s", self.uri, error)

    def _forget(self) -> None:
        """Expect no answer any more to what was asked long ago."""
        with self._news:
            before = time.monotonic() - FORGET_SECONDS
            late = [number for number, asked in self._asked.items() if asked.at < before]
            forgotten = [self._asked.pop(number) for number in late]
        for asked in forgotten:
            self._call(partial(asked.done, self._late(asked.request, FORGET_SECONDS)))

    def _call(self, callback: Callable[[], object]) -> None:
        try:
            callback()
        except Exception:
            _log.exception("! %s: a message could not be handled", self.uri)
