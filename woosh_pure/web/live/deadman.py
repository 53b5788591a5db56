"""The dead-man switch of one page, decided on the server: whether the robot may still be driven. Pure: times
are arguments.

While a person holds the control, the page sends a press and then a beat every 100 ms, each with a sequence
number and the page's time. When the person lets go, or the page is hidden, suspended or disconnected, beats
stop, and their absence ends the drive.

| state   | press                 | opened  | beat                     | let go, gone, stop | 0.4 s silent |
|---------|-----------------------|---------|--------------------------|--------------------|--------------|
| idle    | newer number: opening | zero    | ignored                  | -                  | -            |
| opening | a second one: ended   | driving | in time: noted           | ended              | ended        |
| driving | a second one: ended   | zero    | in time: drive           | ended              | ended        |
| ended   | newer number: opening | zero    | ignored: nothing resumes | -                  | -            |

A beat is late if it took more than 0.25 s longer than the fastest one so far: beats that a network delayed
and delivers together are out of date. The two clocks need not agree. If the page's clock is set back, all
beats are late, which ends the drive. If it is set forward, the next beat becomes the fastest, and later ones
are compared with it. Drift between the clocks is corrected between two presses, but never during one.

All times count from the sending of a beat, not from its reading: a beat that is 0.2 s late moves the robot
for 0.1 s only. So a slow network or a busy server can shorten a drive, but never lengthen it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

SILENCE_SECONDS = 0.4
"""A drive ends after this time without a timely beat."""
VALID_FOR = 0.3
"""A beat moves the robot for this time after it was sent, even if the event loop is blocked."""
MAX_LATE_SECONDS = 0.25
"""A beat may take this much longer than the fastest one."""
DRIFT = 1e-3
"""Allowed drift between the two clocks, in seconds per second; real clocks drift much less."""

State = Literal["idle", "opening", "driving", "ended"]
Act = Literal["none", "open", "drive", "zero"]


@dataclass(frozen=True, slots=True)
class Verdict:
    """What to do after one event.

    Attributes:
        act: "open" a drive, "drive" at `vx` and `wz`, end it with "zero", or "none".
        vx, wz: m/s, rad/s.
        valid_for: For how many seconds to drive.
        reason: Why the drive ended or was refused, as a short word for programs; "" otherwise.
    """

    act: Act
    vx: float = 0.0
    wz: float = 0.0
    reason: str = ""
    valid_for: float = 0.0


NOTHING = Verdict("none")


class DeadManSwitch:
    """The dead-man switch of one person.

    Attributes:
        state: See the table above.
    """

    def __init__(self) -> None:
        self.state: State = "idle"
        self._seq = -1
        self._fastest = math.inf
        self._pressed = -math.inf
        self._alive = -math.inf
        self._wish = (0.0, 0.0)

    @property
    def held(self) -> bool:
        """True while a drive is open or being opened."""
        return self.state in ("opening", "driving")

    def press(self, seq: int, at: float, vx: float, wz: float, now: float) -> Verdict:
        """The person begins to hold the control."""
        if self.held:
            return self._end("pressed twice")
        if not self._is_new(seq, at, vx, wz):
            return Verdict("none", reason="not a new press")
        if self._pressed > -math.inf:
            self._fastest += DRIFT * max(0.0, now - self._pressed)
        self._pressed = now
        late = self._lateness(at, now)
        if late > MAX_LATE_SECONDS:
            return Verdict("none", reason="late")
        self.state, self._alive, self._wish = "opening", now - late, (vx, wz)
        return Verdict("open")

    def opened(self, now: float) -> Verdict:
        """Note that the drive is open. The person may have let go meanwhile."""
        if self.state != "opening":
            return Verdict("zero", reason="released early")
        if (ended := self.tick(now)).act == "zero":
            return ended
        self.state = "driving"
        return self._drive(now)

    def beat(self, seq: int, at: float, vx: float, wz: float, now: float) -> Verdict:
        """The person still holds the control."""
        if not self.held:
            return NOTHING
        if not (math.isfinite(at) and math.isfinite(vx) and math.isfinite(wz)):
            return self._end("no number")
        if (ended := self.tick(now)).act == "zero":
            return ended
        if not self._is_new(seq, at, vx, wz):
            return NOTHING  # a repeated beat does not end the silence
        late = self._lateness(at, now)
        if late > MAX_LATE_SECONDS:
            return NOTHING
        self._alive, self._wish = max(self._alive, now - late), (vx, wz)
        return self._drive(now) if self.state == "driving" else NOTHING

    def _drive(self, now: float) -> Verdict:
        """Drive for the remaining time of the last beat; if it is over, wait for the next beat."""
        left = VALID_FOR - (now - self._alive)
        return Verdict("drive", *self._wish, valid_for=left) if left > 0.0 else NOTHING

    def tick(self, now: float) -> Verdict:
        """End the drive if the silence has lasted too long. Call this every 50 ms at least while `held`."""
        if self.held and now - self._alive > SILENCE_SECONDS:
            return self._end("silent")
        return NOTHING

    def end(self, reason: str) -> Verdict:
        """End the drive: it was released, disconnected, stopped or refused, or has ended by itself."""
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
        """Return the seconds by which a beat took longer than the fastest one."""
        took = now - at
        self._fastest = min(self._fastest, took)
        return took - self._fastest
