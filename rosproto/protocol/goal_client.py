"""One goal seen from the client: actionlib's communication state machine, without any I/O.

A goal is sent, then heard of on two topics that are not in step with each other: `status`, an array of all
goals of the server, 5 times a second and at every change; and `result`, once. The client follows the server's
goal through *communication states*:

    WAITING_FOR_GOAL_ACK    sent, the server has not mentioned it yet
    PENDING, ACTIVE         as the server says
    WAITING_FOR_CANCEL_ACK  a cancel was sent, the server has not reacted yet
    RECALLING, PREEMPTING   the server is cancelling it: before it was accepted, while it was active
    WAITING_FOR_RESULT      the server says it has ended, the result message is still on its way
    DONE                    the result is here, or the goal is lost

A status may be missed (the array is sent at intervals), so one status can imply several transitions: a goal
first heard of as PREEMPTED has been ACTIVE and PREEMPTING. Every state passed through is reported, in
order, because programs hang their reactions on a particular one.

The table has a row for each state and a column for each status. A cell is the path to take, one letter for
each state passed; `.` stays, `!` is something no correct server says in that state: it is counted and changes
nothing (not even the remembered status), since the likeliest source is a second server or a stale message.

Beyond the table:

* A result may come before any status. Its own status goes through the table first, then the goal is DONE.
* After DONE nothing moves the goal: late status and second results are ignored (pr2_common#139).
* A goal that the server's array no longer mentions is LOST (DONE with status LOST), except in
  WAITING_FOR_GOAL_ACK (the array may be older than the goal) and in WAITING_FOR_RESULT (the server forgets
  ended goals after 5 s, the result may still be under way). A restarted server shows itself this way.
* Only the server that mentioned the goal first, known by its caller id, is believed: an array of another
  node on the same topic does not mention the goal and would otherwise lose it.

Source: wiki.ros.org/actionlib/DetailedDescription ("Client Description"); where it is silent, rospy's and
roscpp's actionlib: the table agrees with rospy's, `cancel_sent` with roscpp's (rospy leaves DONE when a
cancel is sent late).
"""

from __future__ import annotations

from enum import IntEnum

from rosproto.protocol.goal_status import GoalStatus, read_table

__all__ = ["CommState", "GoalMachine", "GoalStatus", "transition_path"]


class CommState(IntEnum):
    """Communication state of a goal; numbers as in rospy's actionlib."""

    WAITING_FOR_GOAL_ACK = 0
    PENDING = 1
    ACTIVE = 2
    WAITING_FOR_RESULT = 3
    WAITING_FOR_CANCEL_ACK = 4
    RECALLING = 5
    PREEMPTING = 6
    DONE = 7


_LETTERS = {
    "P": CommState.PENDING,
    "A": CommState.ACTIVE,
    "R": CommState.WAITING_FOR_RESULT,
    "c": CommState.RECALLING,
    "p": CommState.PREEMPTING,
}

_TABLE = """
                       PENDING ACTIVE REJECTED RECALLING RECALLED PREEMPTING PREEMPTED SUCCEEDED ABORTED
WAITING_FOR_GOAL_ACK   P       A      PR       Pc        PR       Ap         ApR       AR        AR
PENDING                .       A      R        c         cR       Ap         ApR       AR        AR
ACTIVE                 !       .      !        !         !        p          pR        R         R
WAITING_FOR_CANCEL_ACK .       .      R        c         cR       p          pR        pR        pR
RECALLING              !       !      R        .         R        p          pR        pR        pR
PREEMPTING             !       !      !        !         !        .          R         R         R
WAITING_FOR_RESULT     !       .      .        !         .        !          .         .         .
DONE                   !       !      .        !         .        !          .         .         .
"""


_PATHS = {
    (CommState[state], GoalStatus[status]): None
    if cell == "!"
    else tuple(_LETTERS[c] for c in cell.strip("."))
    for state, status, cell in read_table(_TABLE)
}

_MAY_BE_UNMENTIONED = (CommState.WAITING_FOR_GOAL_ACK, CommState.WAITING_FOR_RESULT, CommState.DONE)
_CANCEL_HELPS = (
    CommState.WAITING_FOR_GOAL_ACK,
    CommState.PENDING,
    CommState.ACTIVE,
    CommState.WAITING_FOR_CANCEL_ACK,
)


def transition_path(state: CommState, status: GoalStatus) -> tuple[CommState, ...] | None:
    """The states passed when `status` is heard in `state`; empty to stay, None when the pair is illegal."""
    return _PATHS.get((state, status))


class GoalMachine:
    """State of one goal as its client knows it.

    Each method takes one thing that happened and returns the states passed because of it, in order. The
    caller does the talking and the locking.

    Attributes:
        goal_id: The id the goal was sent with.
        state: Where it is now.
        status: Latest status believed; PENDING before any.
        text: The server's text that came with it.
        server: Caller id of the server this goal belongs to; "" until one has mentioned it.
        result: Result message, None until it came.
        violations: How often a server said something illegal or unknown.
    """

    __slots__ = ("goal_id", "result", "server", "state", "status", "text", "violations")

    def __init__(self, goal_id: str) -> None:
        self.goal_id = goal_id
        self.state = CommState.WAITING_FOR_GOAL_ACK
        self.status = GoalStatus.PENDING
        self.text = ""
        self.server = ""
        self.result: object | None = None
        self.violations = 0

    @property
    def done(self) -> bool:
        """True when nothing will change any more."""
        return self.state is CommState.DONE

    def status_received(self, status: int, text: str, server: str = "") -> tuple[CommState, ...]:
        """A status array of `server` mentions this goal.

        Args:
            status: Number of a GoalStatus; an unknown one is counted as a violation.
            text: The server's words.
            server: Caller id of the array's sender; "" skips the check.
        """
        if self.done or not self._is_ours(server):
            return ()
        try:
            known = GoalStatus(status)
            path = transition_path(self.state, known)
        except ValueError:
            path = None
        if path is None:
            self.violations += 1
            return ()
        self.status, self.text = known, text
        return self._pass(path)

    def unmentioned(self, server: str = "") -> tuple[CommState, ...]:
        """A status array of `server` arrived that does not mention this goal."""
        if self.state in _MAY_BE_UNMENTIONED or (server and server != self.server):
            return ()
        return self.lose("the action server no longer knows this goal; it was restarted or dropped it")

    def result_received(
        self, result: object, status: int, text: str, server: str = ""
    ) -> tuple[CommState, ...]:
        """The result arrived. DONE follows whatever its status says; after DONE it is ignored."""
        if self.done or not self._is_ours(server):
            return ()
        passed = self.status_received(status, text, server)
        self.result = result
        if not (self.status.is_terminal and self.status == status):
            # The server ended the goal but gives no status that fits (an unknown one, or one that is not
            # terminal). What can be said for sure is that it is over; the words are kept.
            self.status = _nearest_terminal(status, self.state)
            self.text = text
        return passed + self._pass((CommState.DONE,))

    def cancel_sent(self) -> tuple[CommState, ...]:
        """A cancel of this goal went out; changes the state where the server's answer is awaited now."""
        if self.state not in _CANCEL_HELPS:
            return ()
        return self._pass((CommState.WAITING_FOR_CANCEL_ACK,))

    @property
    def cancel_helps(self) -> bool:
        """True while sending a cancel can make a difference (roscpp's ClientGoalHandle::cancel)."""
        return self.state in _CANCEL_HELPS

    def lose(self, why: str) -> tuple[CommState, ...]:
        """End the goal as LOST."""
        if self.done:
            return ()
        self.status, self.text = GoalStatus.LOST, why
        return self._pass((CommState.DONE,))

    def is_from(self, server: str) -> bool:
        """Whether a message of `server` may be about this goal: that is its server, or none is known yet."""
        return not server or not self.server or server == self.server

    def _is_ours(self, server: str) -> bool:
        if server and not self.server:
            self.server = server
        return not server or server == self.server

    def _pass(self, path: tuple[CommState, ...]) -> tuple[CommState, ...]:
        if path:
            self.state = path[-1]
        return path


def _nearest_terminal(status: int, state: CommState) -> GoalStatus:
    """A terminal status for a result whose own does not fit the state."""
    try:
        known = GoalStatus(status)
    except ValueError:
        return GoalStatus.LOST
    if known.is_terminal:
        return known  # illegal by the table (REJECTED of an active goal), but the server's last word
    return GoalStatus.PREEMPTED if state is CommState.PREEMPTING else GoalStatus.ABORTED
