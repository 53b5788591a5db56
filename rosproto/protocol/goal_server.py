"""The server's view of goals: the states of one goal, and the list on the status topic. No I/O, no clock.

A goal is PENDING when it arrives. The program accepts it (ACTIVE) or rejects it; an accepted goal succeeds,
is aborted, or is cancelled. A client's cancel is a *request*: the goal becomes RECALLING (not accepted yet)
or PREEMPTING (active), and the program ends it, as cancelled (RECALLED, PREEMPTED) or otherwise, since work
may finish before the request is seen. Accepting a RECALLING goal makes it PREEMPTING.

The table has a row for each state that is not terminal and a column for each command; `-` is an error of the
calling program. A program may cancel an ACTIVE or PENDING goal without a request: a simple server does so
when a newer goal arrives.

The list (`GoalList`) has one entry for each goal id:

* A goal with a known id is a repetition and is not started again.
* A cancel names goals by id, by time ("at or before", stamp not zero), by both (either suffices), or all (id
  "" and stamp zero).
* A cancel may arrive before its goal, on another connection: an unknown id is kept as RECALLING for 5 s, and
  the goal that follows is RECALLED at once. The same holds for a goal not newer than the latest cancel stamp.
* Terminal entries stay in the status array for 5 s, so that a client that missed one array still sees the
  end.

Source: wiki.ros.org/actionlib/DetailedDescription ("Server Description"); where it is silent, rospy's
actionlib/action_server.py (internal_cancel_callback, internal_goal_callback) and roscpp's
action_server_base.h.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from rosproto.errors import LocalProtocolError
from rosproto.protocol.goal_status import GoalStatus, read_table

KEEP_SECONDS = 5.0  # for a terminal entry, or an early cancel
MAX_EARLY_CANCELS = 1000
MAX_ENDED = 1000  # ended goals still reported; with more, the oldest are dropped earlier
CANCELED_BY_TIME = "canceled: the goal is not newer than the latest cancel request"

_TABLE = """
            accept      reject    request_cancel  cancel     succeed    abort
PENDING     ACTIVE      REJECTED  RECALLING       RECALLED   -          -
RECALLING   PREEMPTING  REJECTED  -               RECALLED   -          -
ACTIVE      -           -         PREEMPTING      PREEMPTED  SUCCEEDED  ABORTED
PREEMPTING  -           -         -               PREEMPTED  SUCCEEDED  ABORTED
"""


_NEXT = {
    (GoalStatus[state], command): GoalStatus[cell]
    for state, command, cell in read_table(_TABLE)
    if cell != "-"
}


def next_status(status: GoalStatus, command: str) -> GoalStatus | None:
    """The status after `command`; None if the command is not allowed in `status`."""
    return _NEXT.get((status, command))


def is_meant(goal_id: str, stamp: int, cancel_id: str, cancel_stamp: int) -> bool:
    """Whether a cancel covers a goal, stamps in ns: by id, by time, or because it names neither."""
    if not cancel_id and not cancel_stamp:
        return True
    return goal_id == cancel_id or 0 < cancel_stamp >= stamp


def is_before(stamp: int, last_cancel: int) -> bool:
    """Whether a goal that arrives now was cancelled by time before; a goal without stamp was not."""
    return 0 < stamp <= last_cancel


@dataclass(slots=True, eq=False, repr=False)
class GoalRecord:
    """One goal in the server's list.

    Attributes:
        goal_id: Unique id, from the client.
        stamp: The goal id's stamp, nanoseconds: the client's, or the server's time when the client gave none.
        status: Current status.
        text: Text that accompanies the status.
        early_cancel: True for an entry made by a cancel whose goal has not arrived.
        expires: Time at which the entry leaves the list; None while the goal is active.
    """

    goal_id: str
    stamp: int
    status: GoalStatus = GoalStatus.PENDING
    text: str = ""
    early_cancel: bool = False
    expires: float | None = None

    def __repr__(self) -> str:
        return f"GoalRecord({self.goal_id!r}, {self.status.name})"


class GoalList:
    """All goals that a server reports.

    `now` is any monotonic clock in seconds, passed by the caller; the caller also does the locking.
    """

    def __init__(self) -> None:
        self._records: dict[str, GoalRecord] = {}
        self._last_cancel = 0

    def __iter__(self) -> Iterator[GoalRecord]:
        return iter(tuple(self._records.values()))

    def __len__(self) -> int:
        return len(self._records)

    def goal_received(
        self, goal_id: str, stamp: int, now: float, *, sent: int | None = None
    ) -> tuple[GoalRecord, bool]:
        """A goal message arrived.

        Args:
            goal_id: Its id.
            stamp: Its stamp in the list, nanoseconds.
            now: The clock.
            sent: The stamp in the message, 0 for none: only this one is compared with an earlier cancel by
                time, as in roscpp (rospy compares the stamp in the list). None: the same as `stamp`.

        Returns:
            The entry, and whether to notify the program. If not, it is a repetition (nothing to do) or was
            cancelled before it arrived: its status is then RECALLED, and a result must be published.
        """
        known = self._records.get(goal_id)
        if known is not None and not known.early_cancel:
            if known.expires is not None:
                known.expires = now + KEEP_SECONDS
            return known, False
        record = known or GoalRecord(goal_id, stamp)
        record.stamp = stamp
        self._records[goal_id] = record
        if known is not None:
            record.early_cancel = False
            self.apply(record, "cancel", now, "canceled before the goal arrived")
            return record, False
        if is_before(stamp if sent is None else sent, self._last_cancel):
            self.apply(record, "cancel", now, CANCELED_BY_TIME)
            return record, False
        return record, True

    def cancel_received(self, goal_id: str, stamp: int, now: float) -> list[GoalRecord]:
        """A cancel message arrived.

        Returns:
            The goals that became RECALLING or PREEMPTING; notify the program of them.
        """
        touched = [r for r in self._records.values() if is_meant(r.goal_id, r.stamp, goal_id, stamp)]
        if goal_id and goal_id not in self._records:
            self._remember_early_cancel(goal_id, stamp, now)
        self._last_cancel = max(self._last_cancel, stamp)
        return [r for r in touched if not r.early_cancel and self._try(r, "request_cancel", now)]

    def apply(self, record: GoalRecord, command: str, now: float, text: str | None = None) -> None:
        """Carry out a command of the program.

        Args:
            record: An entry of this list.
            command: accept, reject, cancel, succeed or abort.
            now: The clock.
            text: New text of the status; None keeps the old one.

        Raises:
            LocalProtocolError: The goal's state does not allow it.
        """
        before = record.status
        if not self._try(record, command, now):
            raise LocalProtocolError(
                f"goal {record.goal_id}: cannot {command} a goal that is {before.name}; "
                f"allowed now: {', '.join(c for s, c in _NEXT if s is before) or 'nothing, it has ended'}"
            )
        if text is not None:
            record.text = text

    def expire(self, now: float) -> None:
        """Remove expired entries, and the oldest ones beyond the limit."""
        ended = [record for record in self if record.expires is not None and not record.early_cancel]
        over = ended[: max(0, len(ended) - MAX_ENDED)]
        for record in [*over, *(r for r in self if r.expires is not None and r.expires <= now)]:
            self._records.pop(record.goal_id, None)

    def _try(self, record: GoalRecord, command: str, now: float) -> bool:
        after = next_status(record.status, command)
        if after is None:
            return False
        record.status = after
        if after.is_terminal:
            record.expires = now + KEEP_SECONDS
        return True

    def _remember_early_cancel(self, goal_id: str, stamp: int, now: float) -> None:
        early = [r for r in self._records.values() if r.early_cancel]
        # A flood of cancels must not grow the status array without bound.
        if len(early) >= MAX_EARLY_CANCELS:
            del self._records[early[0].goal_id]
        self._records[goal_id] = GoalRecord(
            goal_id, stamp, GoalStatus.RECALLING, early_cancel=True, expires=now + KEEP_SECONDS
        )
