"""The states of an order, of the vehicle's motion and of an action, and what holds a vehicle back: as tables.

The end of a drive never says that the vehicle stands. STANDING is entered only from SETTLING, by a
measurement that is younger than the last end of a drive, of a moving action or of a stop. From UNKNOWN
nothing leads on but a stop that the robot has answered.

A hold is what keeps the vehicle from something until it is taken away; several may be set.

    hold         set by                          taken away by
    ----------------------------------------------------------------------------------------------
    PAUSED       startPause                      stopPause
    RESTARTED    a restart of our program        stopPause, a new order, the end of the order
    FAILED       a drive that failed             time, stopPause, a new order, the end of the order
    DISK         a write that failed             a write that succeeded
    TOO_FAST     an edge's maxSpeed, exceeded    the end of that drive
    MODE         the operating mode              the operating mode
    PLACE        no position                     a position
    MAP          the next node's map             a position on that map
    NOT_KNOWN    motion UNKNOWN or STOPPING      the stop

Pure. `transition.py` is the only one that changes a state, and asks these tables.
"""

from __future__ import annotations

from enum import Enum


class OrderPhase(Enum):
    """What becomes of the order."""

    OPEN = "carried out, or finished: an update continues it"
    ENDING = "given up: what is under way is being ended"
    CLOSED = "over before its end: only a new order is taken"


class OrderEvent(Enum):
    """What happened to it."""

    TAKEN = "an order was taken"
    GIVEN_UP = "cancelOrder, an operating mode of others, or the end of the program"
    OVER = "all of it has ended"


class Motion(Enum):
    """Whether the vehicle moves because of us."""

    STANDING = "measured standing"
    SETTLING = "nothing of ours drives it, and it was not measured standing since"
    DRIVING = "a drive is under way"
    HALTING = "the drive under way was asked to end"
    UNKNOWN = "how something that moves it has ended is not known"
    STOPPING = "it is being stopped because of that"


class MotionEvent(Enum):
    """What happened to it."""

    DRIVE = "a drive was given out"
    HALT = "the drive was asked to end"
    ENDED = "the drive has ended"
    NOT_KNOWN = "how a drive or a moving action ended is not known"
    MOVED = "measured moving, not heard, or moved by an action"
    STOOD = "measured standing"
    STOP = "everything was told to stop"
    STOPPED = "and the robot stands"
    NOT_STOPPED = "and nobody knows whether it does"


class ActionStatus(str, Enum):
    """`actionStatus`."""

    WAITING = "WAITING"
    INITIALIZING = "INITIALIZING"
    RUNNING = "RUNNING"
    PAUSED = "PAUSED"
    FINISHED = "FINISHED"
    FAILED = "FAILED"

    @property
    def final(self) -> bool:
        """True when it has ended, well or badly."""
        return self in (ActionStatus.FINISHED, ActionStatus.FAILED)

    @property
    def begun(self) -> bool:
        """True from its beginning to its end."""
        return not self.final and self is not ActionStatus.WAITING


class Hold(Enum):
    """What keeps the vehicle from something."""

    PAUSED = "startPause"
    RESTARTED = "our program was restarted while it carried the order out"
    FAILED = "a drive has failed"
    DISK = "nothing can be written on disk"
    TOO_FAST = "it is faster than its edge allows"
    MODE = "the fleet manager is not in control"
    PLACE = "it does not know where it is"
    MAP = "the next node is on another map"
    NOT_KNOWN = "how something that moves it has ended is not known"


class Barred(Enum):
    """What a hold keeps it from."""

    GOING_ON = "a drive under way is halted"
    DRIVING = "no drive begins, and no node is passed by"
    ORDER = "no action of the order begins"
    MOVING = "no action begins that moves the vehicle"
    INSTANT = "no instant action begins"


_ORDER = """
        TAKEN  GIVEN_UP  OVER
OPEN    .      ENDING    !
ENDING  !      .         CLOSED
CLOSED  OPEN   !         !
"""

# What is measured while a drive is open, or while its end is not known, says nothing of how it ends.
_MOTION = """
          DRIVE    HALT     ENDED     NOT_KNOWN  MOVED     STOOD     STOP      STOPPED   NOT_STOPPED
STANDING  DRIVING  !        !         UNKNOWN    SETTLING  .         !         !         !
SETTLING  DRIVING  !        !         UNKNOWN    .         STANDING  !         !         !
DRIVING   .        HALTING  SETTLING  UNKNOWN    .         .         !         !         !
HALTING   !        !        SETTLING  UNKNOWN    .         .         !         !         !
UNKNOWN   !        !        !         .          .         .         STOPPING  !         !
STOPPING  !        !        !         .          .         .         !         SETTLING  UNKNOWN
"""

_ACTION = """
              INITIALIZING  RUNNING  PAUSED  FINISHED  FAILED
WAITING       !             +        !       !         +
INITIALIZING  +             +        +       +         +
RUNNING       +             +        +       +         +
PAUSED        +             +        +       +         +
"""

BARS = {
    Hold.PAUSED: {Barred.GOING_ON, Barred.DRIVING, Barred.MOVING},
    Hold.RESTARTED: {Barred.GOING_ON, Barred.DRIVING, Barred.ORDER},
    Hold.FAILED: {Barred.DRIVING},
    Hold.DISK: {Barred.DRIVING, Barred.ORDER, Barred.MOVING, Barred.INSTANT},
    Hold.TOO_FAST: {Barred.GOING_ON, Barred.DRIVING},
    Hold.MODE: {Barred.GOING_ON, Barred.DRIVING, Barred.ORDER},
    Hold.PLACE: {Barred.GOING_ON, Barred.DRIVING},
    Hold.MAP: {Barred.GOING_ON, Barred.DRIVING},
    Hold.NOT_KNOWN: {Barred.DRIVING},
}
"""What each hold keeps the vehicle from."""


def _read(table: str) -> dict[tuple[str, str], str]:
    """The cells of a table, by row and column. A cell is the state after the event; "." stays, "!" cannot
    be."""
    head, *rows = (line.split() for line in table.strip().splitlines())
    return {
        (row, event): row if cell == "." else cell
        for row, *cells in rows
        for event, cell in zip(head, cells, strict=True)
        if cell != "!"
    }


_NEXT_PHASE, _NEXT_MOTION, _NEXT_STATUS = _read(_ORDER), _read(_MOTION), _read(_ACTION)


def next_phase(phase: OrderPhase, event: OrderEvent) -> OrderPhase:
    """What becomes of an order.

    Raises:
        AssertionError: The event cannot happen in this phase: a bug here.
    """
    following = _NEXT_PHASE.get((phase.name, event.name))
    assert following is not None, f"{event} in {phase}"
    return OrderPhase[following]


def next_motion(motion: Motion, event: MotionEvent) -> Motion:
    """What becomes of the motion.

    Raises:
        AssertionError: The event cannot happen in this state: a bug here.
    """
    following = _NEXT_MOTION.get((motion.name, event.name))
    assert following is not None, f"{event} in {motion}"
    return Motion[following]


def may_become(status: ActionStatus, new: ActionStatus) -> bool:
    """Whether an action may come from one status to another one; nothing leads on from an end."""
    return (status.name, new.name) in _NEXT_STATUS
