"""The dead man: may the robot still be driven for this person? Judged on the server. Pure: times are given.

A page that is held sends a press and then a beat every 100 ms, each with a number and with its own time.
Whoever lets go, hides, freezes, sleeps or is cut off sends none, and that is what ends a drive; nothing else
is needed.

| state   | press                 | opened  | beat                     | let go, gone, stop | 0.4 s silent |
|---------|-----------------------|---------|--------------------------|--------------------|--------------|
| idle    | newer number: opening | zero    | ignored                  | -                  | -            |
| opening | a second one: ended   | driving | in time: noted           | ended              | ended        |
| driving | a second one: ended   | zero    | in time: drive           | ended              | ended        |
| ended   | newer number: opening | zero    | ignored: nothing resumes | -                  | -            |

Late is a beat that took more than 0.25 s longer than the fastest one seen: beats that a network has kept and
delivers in one heap are old wishes. Clocks need not agree, they must only run: one that is set back makes all
beats late, which ends the drive; one that is set forward makes all earlier ones late. Clocks run a little
apart, which is forgiven between two presses, never while somebody holds.

Everything counts from when a beat was sent, not from when it was read: one that was 0.2 s late moves the
robot for 0.1 s only. So a slow network and a busy server shorten a drive, and never lengthen it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

__all__ = ["LATEST", "SILENCE", "DeadMan", "State", "Verdict"]

SILENCE = 0.4
"""Seconds without a beat in time after which a drive is over."""
VALID_FOR = 0.3
"""Seconds for which one beat moves the robot, from when it was sent, whatever becomes of the event loop."""
LATEST = 0.25
"""Seconds by which a beat may be slower than the fastest one."""
DRIFT = 1e-3
"""Seconds by which two clocks may run apart in a second: far more than they do."""

State = Literal["idle", "opening", "driving", "ended"]
Act = Literal["none", "open", "drive", "zero"]


@dataclass(frozen=True, slots=True)
class Verdict:
    """What follows from one event.

    Attributes:
        act: "open" a drive, "drive" at `vx` and `wz`, "zero" ends it; "none".
        vx, wz: m/s, rad/s.
        valid_for: Seconds for which it drives.
        reason: Why it ended or was refused, a short word for programs; "" else.
    """

    act: Act
    vx: float = 0.0
    wz: float = 0.0
    reason: str = ""
    valid_for: float = 0.0


NOTHING = Verdict("none")


class DeadMan:
    """One person's hand on the robot.

    Attributes:
        state: See the table above.
        late: Beats refused as late so far.
    """

    def __init__(self, silence: float = SILENCE, latest: float = LATEST) -> None:
        self.state: State = "idle"
        self.late = 0
        self._silence, self._latest = silence, latest
        self._seq = -1
        self._fastest = math.inf
        self._pressed = -math.inf
        self._alive = -math.inf
        self._wish = (0.0, 0.0)

    @property
    def held(self) -> bool:
        """True while a drive is being opened, or open."""
        return self.state in ("opening", "driving")

    def press(self, seq: int, at: float, vx: float, wz: float, now: float) -> Verdict:
        """Somebody begins to hold."""
        if self.held:
            return self._end("pressed twice")
        if not self._is_new(seq, at, vx, wz):
            return Verdict("none", reason="not a new press")
        if self._pressed > -math.inf:
            self._fastest += DRIFT * max(0.0, now - self._pressed)
        self._pressed = now
        late = self._lateness(at, now)
        if late > self._latest:
            return Verdict("none", reason="late")
        self.state, self._alive, self._wish = "opening", now - late, (vx, wz)
        return Verdict("open")

    def opened(self, now: float) -> Verdict:
        """The drive stands; it may have taken longer than the person held."""
        if self.state != "opening":
            return Verdict("zero", reason="let go meanwhile")
        if (ended := self.tick(now)).act == "zero":
            return ended
        self.state = "driving"
        return self._drive(now)

    def beat(self, seq: int, at: float, vx: float, wz: float, now: float) -> Verdict:
        """Somebody still holds."""
        if not self.held:
            return NOTHING
        if not (math.isfinite(at) and math.isfinite(vx) and math.isfinite(wz)):
            return self._end("no number")
        if (ended := self.tick(now)).act == "zero":
            return ended
        if not self._is_new(seq, at, vx, wz):
            return NOTHING  # no sign of life: the silence goes on
        late = self._lateness(at, now)
        if late > self._latest:
            return NOTHING
        self._alive, self._wish = max(self._alive, now - late), (vx, wz)
        return self._drive(now) if self.state == "driving" else NOTHING

    def _drive(self, now: float) -> Verdict:
        """What is left of the last beat; nothing where it is too old, until the next one."""
        left = VALID_FOR - (now - self._alive)
        return Verdict("drive", *self._wish, valid_for=left) if left > 0.0 else NOTHING

    def tick(self, now: float) -> Verdict:
        """Time passes; to be called at least every 50 ms while `held`."""
        if self.held and now - self._alive > self._silence:
            return self._end("silent")
        return NOTHING

    def end(self, reason: str) -> Verdict:
        """Let go, gone, stopped, refused, or the robot has ended the drive."""
        return self._end(reason) if self.held else NOTHING

    def _end(self, reason: str) -> Verdict:
        self.state, self._wish = "ended", (0.0, 0.0)
        return Verdict("zero", reason=reason)

    def _is_new(self, seq: int, at: float, vx: float, wz: float) -> bool:
        if seq <= self._seq or not all(map(math.isfinite, (at, vx, wz))):
            return False
        self._seq = seq
        return True

    def _lateness(self, at: float, now: float) -> float:
        """Seconds by which it took longer than the fastest."""
        took = now - at
        self._fastest = min(self._fastest, took)
        late = took - self._fastest
        self.late += late > self._latest
        return late
