"""When a velocity block must end by itself, checked before every velocity that is sent.

A drive that has ended is never resumed: it may have been a person who stopped the robot.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from rosproto.errors import ConnectionLost, RosError
from rosproto.sentence import say
from woosh_pure.errors import MotionRefused
from woosh_pure.velocity import boottime
from woosh_pure.velocity.heartbeat import LATE

if TYPE_CHECKING:
    import rosproto
    from woosh_pure.feed.feed import Feed
    from woosh_pure.geometry import Velocity
    from woosh_pure.readiness.knowledge import Knowledge
    from woosh_pure.velocity.heartbeat import Heartbeat

__all__ = ["DriveWatch"]

PAUSED = 1.0
"""A drive is over when its sending thread has not run for so many seconds."""
DISOBEYED = 3.0
"""Seconds for which the robot may stand still although it is told to move."""
_TOLD_LINEAR, _TOLD_ANGULAR = 0.05, 0.1  # m/s, rad/s: commands below these may be measured as zero


class DriveWatch:
    """Checks one drive; only its sending thread calls `problem`.

    Args:
        knowledge: Where the reasons against moving are kept.
        measured: `/odom_twist`.
        publisher: Of the velocity topic.
        feedback_timeout: Seconds for which `/odom_twist` may be silent; None drives without it.
        heartbeat: Shows that the network still delivers, where `/odom_twist` is not used; else None.
        check: False drives on whatever the known state is.
    """

    def __init__(
        self,
        knowledge: Knowledge,
        measured: Feed[Velocity],
        publisher: rosproto.Publisher,
        feedback_timeout: float | None,
        heartbeat: Heartbeat | None = None,
        *,
        check: bool,
    ) -> None:
        self._knowledge = knowledge
        self._publisher = publisher
        self._feedback_timeout = feedback_timeout
        self._heartbeat = heartbeat
        self._check = check
        self._measured = measured
        self._last = self._obeyed = boottime.seconds()

    def problem(self, sent: Velocity) -> RosError | None:
        """Why the drive is over now; None while it is not.

        Args:
            sent: What was sent last.
        """
        return self._paused() or (self._blocked() if self._check else None) or self._lost(sent)

    def _paused(self) -> RosError | None:
        """A stopped process, a debugger, a closed laptop: the robot drove on, and is not where it was."""
        now = boottime.seconds()
        pause, self._last = now - self._last, now
        if pause <= PAUSED:
            return None
        return MotionRefused(
            say(
                "the drive is over: this program did not run for {seconds:.1f} s, in which the robot went on "
                "with the last velocity; nothing resumes by itself, look where it is and open a new drive",
                seconds=pause,
            )
        )

    def _blocked(self) -> RosError | None:
        """An emergency stop and the like: releasing the button must not resume the drive."""
        readiness = self._knowledge.known_readiness()
        if not readiness.refuses:
            return None
        return MotionRefused(
            "the drive is over and does not resume by itself; open a new one when the robot is ready",
            readiness=readiness,
        )

    def _lost(self, sent: Velocity) -> RosError | None:
        if self._publisher.connections == 0:
            return _connection_lost(say("{topic}: nobody subscribes any more", topic=self._publisher.topic))
        if self._heartbeat is not None and self._heartbeat.late:
            return _connection_lost(
                say(
                    "who listens to {topic} has not answered within {seconds:g} s, so what is sent "
                    "would come "
                    "late",
                    topic=self._publisher.topic,
                    seconds=LATE,
                )
            )
        if self._feedback_timeout is None:
            return None
        measured = self._measured.known
        if measured is None or measured.age > self._feedback_timeout:
            return _connection_lost(
                say(
                    "{topic} has been silent for more than {seconds} s",
                    topic=self._measured.topic,
                    seconds=self._feedback_timeout,
                )
            )
        return self._disobeyed(sent, measured.value) if self._check else None

    def _disobeyed(self, sent: Velocity, measured: Velocity) -> RosError | None:
        """The error of a robot that is told to move and stands still.

        The chassis does not report an emergency stop that was pressed before we connected; without this, the
        robot would start as soon as somebody releases the button.
        """
        now = boottime.seconds()
        if sent.is_standing(_TOLD_LINEAR, _TOLD_ANGULAR) or not measured.is_standing():
            self._obeyed = now
            if not measured.is_standing(_TOLD_LINEAR, _TOLD_ANGULAR):
                self._knowledge.refusals.end()
        if now - self._obeyed <= DISOBEYED:
            return None
        self._knowledge.refusals.note(
            "the last drive was not obeyed: the robot stood still", time.monotonic()
        )
        return MotionRefused(
            say(
                "the drive is over: the robot has stood still for {seconds:g} s although it was told to move;"
                " is its emergency stop pressed, its brake on, or something in its way? Nothing resumes by "
                "itself",
                seconds=DISOBEYED,
            )
        )


def _connection_lost(why: str) -> ConnectionLost:
    return ConnectionLost(
        say("the drive is over: {why}; nothing resumes by itself, check the network", why=why)
    )
