"""One viewer: sends frames to a page at the pace at which the page reads, and applies its dead-man switch.

At most two frames are under way; the page acknowledges each. So a slow link gets fewer values, but fresh
ones, and a page that has stopped reading costs two frames of memory and is disconnected with a reason.
"""

from __future__ import annotations

import asyncio
import json
import math
import time
from collections import deque
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from starlette.websockets import WebSocketDisconnect

from rosproto.errors import RosError
from rosproto.text import printable
from rosproto.version import __version__
from woosh_pure.web.access import TokenBucket
from woosh_pure.web.live.deadman import SILENCE, DeadMan, Verdict
from woosh_pure.web.live.hub import STATE_PARTS
from woosh_pure.web.problems import Problem, problem_of
from woosh_pure.web.snapshot import lease_part, plain, stop_part, text_of

if TYPE_CHECKING:
    from concurrent.futures import Future

    from starlette.websockets import WebSocket

    from woosh_pure.stopping.report import StopReport
    from woosh_pure.web.clients import Client
    from woosh_pure.web.context import WebContext
    from woosh_pure.web.live.hub import Hub

__all__ = ["Viewer"]

CREDITS = 2
MOST_TEXT, MOST_ENTRIES = 4096, 50
NOTHING_READ, SEND_SECONDS = 15.0, 10.0
"""Seconds after which a viewer that acknowledges nothing, or accepts nothing, is disconnected."""
MOST_ROUND_TRIP = 0.4
"""Seconds that a frame and its acknowledgement may take when a person begins to drive. No clock tells how
long the first press itself was under way."""
GOING_AWAY = 1001
"""With this code a browser closes the connections of a page that is closed or left. What the page's script
sends then does not always arrive (Firefox); a network that is cut says nothing."""
_AT_ONCE = ("lost",)
_ORDER = ("scan", "state", "map", "marks", "footprint", "plan", "journal")
_BINARY = ("camera color", "camera depth", "costmap")


class BadMessage(Exception):
    """A message that our page would not send; the text says what is wrong with it."""


class Viewer:
    """See above. Used in the event loop only. `run` lasts as long as the connection."""

    def __init__(self, socket: WebSocket, context: WebContext, hub: Hub, client: Client) -> None:
        self._socket, self._context, self._hub, self._client = socket, context, hub, client
        self._robot = hub.robot
        self._wake = asyncio.Event()
        self._sent = self._acked = 0
        self._under_way: deque[float] = deque()  # when each unacknowledged frame was sent
        self._round_trip = 0.0  # how long the last frame and its acknowledgement took
        self._heard = time.monotonic()  # the last acknowledgement, or when one became due
        self._versions: dict[str, int] = {}
        self._last_sent: dict[str, int] = {}  # for each kind, the number of its last frame
        self._journal = -1
        self._lease: object = None
        self._own_messages: deque[str] = deque(maxlen=32)
        self._wanted: set[str] = set()  # cameras and costmap that the page wants to see
        self._watched: set[str] = set()  # of these, what the hub was told
        self._is_looking = False
        self._parts: deque[bytes] = deque()  # of a costmap that is being sent
        self._confirmed = False
        self._dead_man = DeadMan()
        self._presses = 0
        self._driving = False
        self._drive_entry = 0
        self._tasks: set[asyncio.Task[None]] = set()
        self._pace = TokenBucket(200.0, 400.0)

    async def run(self, lang: str) -> None:
        """Serve the page until the connection ends. The drive is ended first of all."""
        self._hub.join(self._wake.set)
        self._tell(self._hello(lang))
        tasks = [asyncio.ensure_future(part()) for part in (self._read, self._write, self._watch)]
        code, reason = 1000, ""
        try:
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                error = task.exception()
                if isinstance(error, BadMessage):
                    code, reason = 1008, str(error)
                elif isinstance(error, TimeoutError):
                    code, reason = 4408, str(error)
                elif error is not None and not isinstance(
                    error, (WebSocketDisconnect, RuntimeError, OSError)
                ):
                    raise error
        finally:
            self._dead_man.end("gone")
            if self._driving:
                self._end_drive("gone")
            if self._robot.chassis.lease.withdraw(self._client.name):
                self._hub.wake()
            try:
                await _end_all({*tasks, *self._tasks})
                for what in list(self._watched):
                    await self._hub.watch(what, False)
            finally:
                self._hub.leave(self._wake.set)
        try:
            await asyncio.wait_for(self._socket.close(code, printable(reason)[:120]), 2.0)
        except (RuntimeError, OSError, asyncio.TimeoutError, WebSocketDisconnect):
            pass  # it is gone

    def _hello(self, lang: str) -> dict[str, Any]:
        return {
            "t": "hello",
            "robot": self._robot.name,
            "robots": list(self._context.robots),
            "session": self._client.session,
            "you": self._client.name,
            "allow_driving": self._context.allow_driving,
            "lang": lang,
            "limits": self._robot.teleop.limits,
            "dead_man": {"beat": 0.1, "silence": SILENCE},
            "version": __version__,
            "time": round(time.time(), 3),
        }

    # -- to the page -----------------------------------------------------------------------------------------

    def _tell(self, document: Mapping[str, Any]) -> None:
        self._own_messages.append(text_of(document))
        self._wake.set()

    async def _write(self) -> None:
        while True:
            self._wake.clear()
            frame = self._next()
            if frame is None:
                if self._sent > self._acked and time.monotonic() - self._heard > NOTHING_READ:
                    raise TimeoutError("you have stopped reading; connect again")
                try:
                    await asyncio.wait_for(self._wake.wait(), 1.0)
                except asyncio.TimeoutError:
                    pass
                continue
            if self._sent == self._acked:
                self._heard = time.monotonic()  # from now on an acknowledgement is due
            self._sent += 1
            self._under_way.append(time.monotonic())
            is_bytes = isinstance(frame, bytes)
            event = {"type": "websocket.send", "bytes" if is_bytes else "text": frame}
            try:
                await asyncio.wait_for(self._socket.send(event), SEND_SECONDS)
            except asyncio.TimeoutError:
                raise TimeoutError("you take nothing any more; connect again") from None

    def _next(self) -> str | bytes | None:
        if self._own_messages:  # messages for this page alone are few, and cannot wait
            return self._own_messages.popleft()
        if self._sent - self._acked >= CREDITS:
            return None
        lease = self._lease_news()
        if lease is not None:
            return lease
        for kind in self._in_turn():
            frame = self._state() if kind == "state" else self._news(kind)
            if frame is not None:
                self._last_sent[kind] = self._sent
                return frame
        return None

    def _in_turn(self) -> list[str]:
        """All kinds, in the order in which to send them. Over a slow link, pose and scan have always changed
        again, and must not keep out the rest. So the pose gets every other frame, and the rest takes turns.
        """
        looked_at = [kind for kind in _BINARY if kind.removeprefix("camera ") in self._watched]
        others = sorted([*_ORDER, *looked_at], key=lambda kind: self._last_sent.get(kind, -1))
        if self._last_sent.get("pose", -2) == self._sent - 1:
            return [*_AT_ONCE, *others, "pose"]
        return [*_AT_ONCE, "pose", *others]

    def _news(self, kind: str) -> str | bytes | None:
        if kind == "journal":
            return self._journal_news()
        if kind == "costmap" and self._parts:  # the rest of the one that was begun
            return self._parts.popleft()
        version, content = self._hub.newest.get(kind, (0, ""))
        if version <= self._versions.get(kind, 0):
            return None
        self._versions[kind] = version
        if isinstance(content, tuple):
            self._parts.extend(content)
            return self._parts.popleft()
        return content

    def _state(self) -> str | None:
        newest, parts = self._hub.newest, []
        for part in STATE_PARTS:
            version, content = newest.get(part, (0, ""))
            if version > self._versions.get(part, 0):
                self._versions[part] = version
                parts.append(f'"{part}":{content!s}')
        version, content = newest.get("ages", (0, ""))
        if not parts and version <= self._versions.get("ages", 0):
            return None
        self._versions["ages"] = version
        ages = content or "{}"
        return '{"t":"state",' + "".join(f"{part}," for part in parts) + f'"ages":{ages!s}}}'

    def _journal_news(self) -> str | None:
        journal = self._robot.journal
        if journal.version <= self._journal:
            return None
        since, self._journal = self._journal, journal.version
        return text_of(
            {"t": "journal", "entries": [entry.as_json() for entry in journal.since(since)[-MOST_ENTRIES:]]}
        )

    def _lease_news(self) -> str | None:
        state = self._robot.chassis.lease.state
        seen = (state.holder, state.asking, round(state.seconds) // 5)
        if seen == self._lease:
            return None
        self._lease = seen
        return text_of({"t": "lease", **lease_part(state, mine=self._client.name)})

    # -- from the page ---------------------------------------------------------------------------------------

    async def _read(self) -> None:
        while True:
            event = await self._socket.receive()
            if event["type"] == "websocket.disconnect":
                if event.get("code") == GOING_AWAY:
                    self._give()
                return
            text = event.get("text")
            if text is None or len(text) > MOST_TEXT:
                raise BadMessage(f"expected text of at most {MOST_TEXT} letters")
            message = _document(text)
            if message.get("t") == "stop":  # also one that is too many
                self._stop(message.get("n"))
            if not self._pace.take(time.monotonic()):
                raise BadMessage("more than 200 messages a second")
            self._handle(message)

    def _handle(self, message: dict[str, Any]) -> None:
        """Nothing here waits: a beat or a stop that comes next must not wait for it."""
        kind = message.get("t")
        if kind == "stop":
            pass  # it is on its way
        elif kind == "ack":
            self._ack(message.get("n"))
        elif kind == "beat":
            now = time.monotonic()
            self._apply(self._dead_man.beat(*_control_fields(message), now), now)
            self._keep_lease()
        elif kind == "press":
            self._press(*_control_fields(message))
        elif kind == "release":
            self._apply(self._dead_man.end("released"))
        elif kind == "confirm":
            self._confirmed = True
        elif kind == "look":
            self._look(message)
        elif kind == "lease":
            self._ask_lease(message)
        else:
            raise BadMessage(f"t={kind!r:.40} is no message of this connection")

    def _ack(self, number: object) -> None:
        if isinstance(number, bool) or not isinstance(number, int) or not self._acked <= number <= self._sent:
            raise BadMessage(
                f"n={number!r:.40}: expected the number of frames you have got, {self._sent} at most"
            )
        now = time.monotonic()
        for _ in range(number - self._acked):
            self._round_trip = now - self._under_way.popleft()
        self._acked, self._heard = number, now
        self._wake.set()

    def _stop(self, number: object) -> None:
        """Stop for this page, which needs neither the lease nor a confirmation for it."""
        stop = self._robot.begin_stop(self._client.name)
        self._tell({"t": "stop", "n": plain(number), "state": "begun"})
        self._start(self._tell_stop(stop, number))

    async def _tell_stop(self, stop: Future[StopReport], number: object) -> None:
        part: dict[str, Any] = {"stands_still": None}
        try:
            part.update(stop_part(await asyncio.wrap_future(stop)))
        except Exception as error:
            part["text"] = problem_of(error).text
        self._tell({"t": "stop", "n": plain(number), "state": "done", **part})

    def _look(self, message: dict[str, Any]) -> None:
        camera, costmap = message.get("camera"), message.get("costmap", "costmap" in self._wanted)
        if camera not in ("color", "depth", None) or not isinstance(costmap, bool):
            raise BadMessage('look: expected camera "color", "depth" or null, and costmap true or false')
        self._wanted = {what for what, on in ((camera, True), ("costmap", costmap)) if on and what}
        if "costmap" not in self._wanted:
            self._parts.clear()
        if not self._is_looking:
            self._is_looking = True
            self._start(self._follow_look())

    async def _follow_look(self) -> None:
        """Watch what is wanted; what is wanted meanwhile comes afterwards."""
        try:
            while changed := self._watched ^ self._wanted:
                what = min(changed)
                on = what in self._wanted
                self._watched ^= {what}  # before it is waited for: at the end of `run` all of it is given up
                await self._hub.watch(what, on)
        finally:
            self._is_looking = False

    def _ask_lease(self, message: dict[str, Any]) -> None:
        lease, me, op = self._robot.chassis.lease, self._client.name, message.get("op")
        if op == "ask":
            if not lease.acquire(me):
                lease.request(me)
        elif op == "give":
            self._give()
        elif op == "keep":
            lease.renew(me)
        elif op == "grant":
            to = message.get("to") or next(iter(lease.state.asking), "")
            if isinstance(to, str) and lease.grant(me, to):
                self._apply(self._dead_man.end("no lease"))
        else:
            raise BadMessage(f"op={op!r:.40}: expected ask, give, keep or grant")
        self._lease = None
        self._hub.wake()

    def _give(self) -> None:
        """Give control back, after the drive has ended."""
        self._apply(self._dead_man.end("no lease"))
        self._robot.chassis.lease.release(self._client.name)

    def _keep_lease(self) -> None:
        if self._dead_man.held and not self._robot.chassis.lease.renew(self._client.name):
            self._apply(self._dead_man.end("no lease"))

    # -- driving ---------------------------------------------------------------------------------------------

    def _press(self, seq: int, at: float, vx: float, wz: float) -> None:
        refusal = self._refusal()
        if refusal is not None:
            self._tell({"t": "drive", "state": "refused", "reason": refusal[0], "text": refusal[1]})
            return
        self._apply(self._dead_man.press(seq, at, vx, wz, time.monotonic()))

    def _refusal(self) -> tuple[str, str] | None:
        if not self._context.allow_driving:
            return "not allowed", "driving is off; it is allowed by starting the server with --allow-driving"
        if self._robot.chassis.lease.holder != self._client.name:
            return "no lease", "ask for the lease first: one person drives at a time"
        if not self._confirmed:
            return "not confirmed", "read and confirm the warning first"
        oldest = time.monotonic() - self._under_way[0] if self._under_way else 0.0
        trip = max(self._round_trip, oldest)
        if trip > MOST_ROUND_TRIP:
            return "slow link", f"the network takes {trip:.1f} s: nobody can drive through that"
        driver = self._robot.teleop.driver
        if driver not in (None, self._client.name):
            return "busy", f"{driver} drives, or has just let go"
        return None

    def _apply(self, verdict: Verdict, now: float | None = None) -> None:
        """Do what the dead-man switch says, without waiting; `now` is the time at which it decided."""
        if verdict.act == "drive":
            try:
                self._robot.teleop.steer(verdict.vx, verdict.wz, verdict.valid_for, now)
            except (RosError, ValueError) as error:
                self._drive_failed(error)
        elif verdict.act == "open":
            self._tell({"t": "drive", "state": "opening", "reason": "", "text": ""})
            self._presses += 1
            self._start(self._open(self._presses))
        elif verdict.act == "zero":
            self._end_drive(verdict.reason)
        elif verdict.reason:
            self._tell({"t": "drive", "state": "refused", "reason": verdict.reason, "text": "press again"})

    async def _open(self, press: int) -> None:
        """Open a drive for one press. If another press came meanwhile, it is ended again at once."""
        teleop, name = self._robot.teleop, self._client.name
        opening = self._context.drives.run(teleop.open, name)
        try:
            await asyncio.shield(opening)
        except asyncio.CancelledError:  # the page disconnected while the drive was being opened
            opening.add_done_callback(lambda done: self._abandon(done, "the page has gone"))
            raise
        except Exception as error:
            if press == self._presses:
                problem = problem_of(error)
                reason = problem.kind if isinstance(error, Problem) else "refused"
                self._dead_man.end(reason)
                self._tell({"t": "drive", "state": "refused", "reason": reason, "text": problem.text})
            return
        if press != self._presses:
            self._abandon(opening, "the hand has let go meanwhile")
            return
        self._driving = True
        entry = self._robot.journal.begin(name, "drive")
        now = time.monotonic()
        verdict = self._dead_man.opened(now)
        if self._dead_man.state == "driving":
            self._tell({"t": "drive", "state": "driving", "reason": "", "text": "", "limits": teleop.limits})
        self._drive_entry = entry
        self._apply(verdict, now)

    def _abandon(self, opening: asyncio.Future[None], why: str) -> None:
        """End a drive that is no longer wanted, if it was opened. If it was not, another's drive may be open,
        which must not be ended.
        """
        if not opening.cancelled() and opening.exception() is None:
            self._context.drives.run(self._robot.teleop.finish, why)

    def _end_drive(self, reason: str, text: str = "") -> None:
        """Send zero now; the journal and the page are told afterwards."""
        if not self._driving:
            if reason:
                self._tell({"t": "drive", "state": "ended", "reason": reason, "text": text})
            return
        self._driving = False
        why = text or f"the hand at the page: {reason}"
        self._robot.teleop.halt(why)
        self._robot.journal.end(self._drive_entry, "done", f"ended: {text or reason}")
        self._tell({"t": "drive", "state": "ended", "reason": reason, "text": text})
        self._context.drives.run(self._robot.teleop.finish, why)

    def _drive_failed(self, error: Exception) -> None:
        """The drive was ended by the robot, a stop, or a lost link."""
        self._dead_man.end("over")
        self._end_drive("over", str(error))

    async def _watch(self) -> None:
        """Check for silence every 50 ms."""
        while True:
            await asyncio.sleep(0.05)
            if self._dead_man.held:
                self._apply(self._dead_man.tick(time.monotonic()))

    def _start(self, job: Any) -> None:
        task = asyncio.ensure_future(job)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)


async def _end_all(tasks: set[asyncio.Task[None]]) -> None:
    """Cancel tasks until they have ended: up to Python 3.11, `asyncio.wait_for` may swallow a cancel."""
    until = time.monotonic() + 2.0
    while tasks and time.monotonic() < until:
        for task in tasks:
            task.cancel()
        done, tasks = await asyncio.wait(tasks, timeout=0.1)
        for task in done:
            if not task.cancelled():
                task.exception()


def _document(text: str) -> dict[str, Any]:
    try:
        message = json.loads(text)
    except (ValueError, RecursionError):
        raise BadMessage("expected JSON") from None
    if not isinstance(message, dict):
        raise BadMessage("expected an object")
    return message


def _control_fields(message: dict[str, Any]) -> tuple[int, float, float, float]:
    seq = message.get("seq")
    if isinstance(seq, bool) or not isinstance(seq, int) or not 0 <= seq < 2**53:
        raise BadMessage(f"seq={seq!r:.40}: expected a whole number that grows")
    return seq, *(_number(message, name) for name in ("at", "vx", "wz"))  # type: ignore[return-value]


def _number(message: dict[str, Any], name: str) -> float:
    value = message.get(name, 0.0)
    good = isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e15
    if not good or not math.isfinite(value):
        raise BadMessage(f"{name}={value!r:.40}: expected a finite number")
    return float(value)
