"""Tables: the states of an order, of the vehicle's motion and of an action; the holds and what they prevent.

The end of a drive does not mean that the vehicle stands. STANDING is entered only from SETTLING, by a
measurement that is newer than the last end of a drive, of a moving action or of a stop. UNKNOWN is left only
by a stop that the robot has confirmed.

A hold prevents activities of the vehicle until it is released; several may be set.

    hold            set by                          released by
    -------------------------------------------------------------------------------------------------
    PAUSED          startPause                      stopPause
    HELD            a restart of our program, or a  stopPause, a new order, the end of the order
                    stop by somebody else, during
                    the order
    FAILED          a drive that failed             time, stopPause, a new order, the end of the order
    DISK            a write that failed             a write that succeeded
    TOO_FAST        an edge's maxSpeed, exceeded    the end of that drive
    MODE            the operating mode              the operating mode
    NO_POSITION     no position                     a position
    OTHER_MAP       the next node's map             a position on that map
    UNKNOWN_MOTION  motion UNKNOWN or STOPPING      the stop

Pure. Only `transition.py` changes a state, by these tables.
"""

from __future__ import annotations

from enum import Enum
from typing import TypeVar


class _Member(Enum):
    """Hashed by identity, since each member is there once; `Enum` hashes the name, in Python code."""

    __hash__ = object.__hash__


class OrderPhase(_Member):
    """The phase of the order."""

    OPEN = "running or finished: an update continues it"
    ENDING = "cancelled: its drive and actions are being ended"
    CLOSED = "ended early: only a new order is accepted"


class OrderEvent(_Member):
    """Changes the phase of the order."""

    TAKEN = "an order was accepted"
    GIVEN_UP = "cancelOrder, another operating mode, or the end of the program"
    OVER = "its drive and all its actions have ended"


class Motion(_Member):
    """Whether this program moves the vehicle."""

    STANDING = "measured standing"
    SETTLING = "no drive is under way, and the vehicle was not measured standing yet"
    DRIVING = "a drive is under way"
    HALTING = "the drive under way is being cancelled"
    UNKNOWN = "it is not known whether a drive or a moving action has ended"
    STOPPING = "the vehicle is being stopped because of that"


class MotionEvent(_Member):
    """Changes the motion."""

    DRIVE = "a drive was started"
    HALT = "the drive is to be cancelled"
    ENDED = "the drive has ended"
    NOT_KNOWN = "it is not known whether a drive or a moving action has ended"
    MOVED = "measured moving, contact lost or regained, or moved by an action"
    STOOD = "measured standing"
    STOP = "a stop of everything was sent"
    STOPPED = "the stop has ended, and the robot stands"
    NOT_STOPPED = "the stop has ended, and it is not known whether the robot stands"


class ActionStatus(str, Enum):
    """`actionStatus`; an action is never INITIALIZING or PAUSED."""

    WAITING = "WAITING"
    RUNNING = "RUNNING"
    FINISHED = "FINISHED"
    FAILED = "FAILED"

    @property
    def final(self) -> bool:
        """True after it has ended, FINISHED or FAILED."""
        return self is ActionStatus.FINISHED or self is ActionStatus.FAILED

    @property
    def begun(self) -> bool:
        """True while it runs."""
        return self is ActionStatus.RUNNING


class Hold(_Member):
    """A reason that prevents activities of the vehicle."""

    PAUSED = "startPause"
    HELD = "this program was restarted, or somebody else stopped the robot, during the order"
    FAILED = "a drive has failed"
    DISK = "the state cannot be written on disk"
    TOO_FAST = "the vehicle is faster than its edge allows"
    MODE = "the fleet manager is not in control"
    NO_POSITION = "the vehicle does not know its position"
    OTHER_MAP = "the next node is on another map"
    UNKNOWN_MOTION = "it is not known whether a drive or a moving action has ended"


class Activity(_Member):
    """An activity that a hold may prevent."""

    CONTINUE_DRIVE = "going on with a drive under way"
    START_DRIVE = "starting a drive, and passing a node without a stop"
    START_ORDER_ACTION = "starting an action of the order"
    START_MOVING_ACTION = "starting an action that moves the vehicle"
    START_INSTANT_ACTION = "starting an instant action"


_ORDER = """
        TAKEN  GIVEN_UP  OVER
OPEN    .      ENDING    !
ENDING  !      .         CLOSED
CLOSED  OPEN   !         !
"""

# Measurements during a drive, or while its end is not known, do not change the motion.
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
         RUNNING  FINISHED  FAILED
WAITING  +        !         +
RUNNING  !        +         +
"""

PREVENTED_ACTIVITIES = {
    Hold.PAUSED: {Activity.CONTINUE_DRIVE, Activity.START_DRIVE, Activity.START_MOVING_ACTION},
    Hold.HELD: {Activity.CONTINUE_DRIVE, Activity.START_DRIVE, Activity.START_ORDER_ACTION},
    Hold.FAILED: {Activity.START_DRIVE},
    Hold.DISK: {
        Activity.START_DRIVE,
        Activity.START_ORDER_ACTION,
        Activity.START_MOVING_ACTION,
        Activity.START_INSTANT_ACTION,
    },
    Hold.TOO_FAST: {Activity.CONTINUE_DRIVE, Activity.START_DRIVE},
    Hold.MODE: {Activity.CONTINUE_DRIVE, Activity.START_DRIVE, Activity.START_ORDER_ACTION},
    Hold.NO_POSITION: {Activity.CONTINUE_DRIVE, Activity.START_DRIVE},
    Hold.OTHER_MAP: {Activity.CONTINUE_DRIVE, Activity.START_DRIVE},
    Hold.UNKNOWN_MOTION: {Activity.START_DRIVE},
}
"""The activities that each hold prevents."""


S = TypeVar("S", bound=Enum)
E = TypeVar("E", bound=Enum)


def _read(table: str, states: type[S], events: type[E]) -> dict[tuple[S, E], str]:
    """The cells of a table, by state and event; "." keeps the state, "!" is impossible."""
    head, *rows = (line.split() for line in table.strip().splitlines())
    return {
        (states[row], events[event]): row if cell == "." else cell
        for row, *cells in rows
        for event, cell in zip(head, cells, strict=True)
        if cell != "!"
    }


_NEXT_PHASE = {key: OrderPhase[cell] for key, cell in _read(_ORDER, OrderPhase, OrderEvent).items()}
_NEXT_MOTION = {key: Motion[cell] for key, cell in _read(_MOTION, Motion, MotionEvent).items()}
_NEXT_STATUS = _read(_ACTION, ActionStatus, ActionStatus)


def _following(table: dict[tuple[S, E], S], state: S, event: E) -> S:
    following = table.get((state, event))
    assert following is not None, f"{event} in {state}"
    return following


def next_phase(phase: OrderPhase, event: OrderEvent) -> OrderPhase:
    """The phase after an event.

    Raises:
        AssertionError: The event is impossible in this phase: a bug in this package.
    """
    return _following(_NEXT_PHASE, phase, event)


def next_motion(motion: Motion, event: MotionEvent) -> Motion:
    """The motion after an event.

    Raises:
        AssertionError: The event is impossible in this state: a bug in this package.
    """
    return _following(_NEXT_MOTION, motion, event)


def may_become(status: ActionStatus, new: ActionStatus) -> bool:
    """Whether an action may change from one status to another; none changes after its end."""
    return (status, new) in _NEXT_STATUS
