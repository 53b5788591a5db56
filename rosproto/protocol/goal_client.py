"""The client's view of one goal: actionlib's communication state machine, without I/O.

After a goal is sent, two topics report on it, and they are not synchronised: `status`, an array of all goals
of the server, 5 times a second and at every change; and `result`, once. The client follows the goal through
*communication states*:

    WAITING_FOR_GOAL_ACK    sent, not yet in the server's status
    PENDING, ACTIVE         as the server reports
    WAITING_FOR_CANCEL_ACK  a cancel was sent, the server has not reacted yet
    RECALLING, PREEMPTING   the server is cancelling it: before it was accepted, while it was active
    WAITING_FOR_RESULT      the server reports that it has ended, the result message has not arrived
    DONE                    the result has arrived, or the goal is lost

A status may be missed (the array is sent at intervals), so one status can imply several transitions: a goal
first seen as PREEMPTED has been ACTIVE and PREEMPTING. Every state passed through is reported, in order,
because programs react to particular states.

The table has a row for each state and a column for each status. A cell is the path to take, one letter for
each state passed. `.` stays. `!` marks a status that no correct server sends in that state: it is ignored,
and the remembered status stays, since it most likely comes from a second server or an outdated message.

Beyond the table:

* A result may arrive before any status. Its status goes through the table first, then the goal is DONE.
* DONE is final: late status and second results are ignored (pr2_common#139).
* A goal missing from the server's array is LOST (DONE with status LOST), except in WAITING_FOR_GOAL_ACK (the
  array may be older than the goal) and in WAITING_FOR_RESULT (the server forgets ended goals after 5 s, and
  the result may still arrive). This is how a restarted server is noticed.
* Only the server that first reported the goal counts, identified by its caller id: another node's array on
  the same topic does not contain the goal and would otherwise make it LOST.

Source: wiki.ros.org/actionlib/DetailedDescription ("Client Description"); where it is silent, rospy's and
roscpp's actionlib: the table agrees with rospy's, `cancel_sent` with roscpp's (rospy leaves DONE when a
cancel is sent late).
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from rosproto.protocol.goal_status import GoalStatus, read_table


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
    """The states passed when `status` is received in `state`; empty to stay, None if the pair is illegal."""
    return _PATHS.get((state, status))


@dataclass(slots=True, eq=False)
class GoalMachine:
    """State of one goal as its client knows it.

    Each method takes one event and returns the states passed because of it, in order. The caller does the
    communication and the locking.

    Attributes:
        goal_id: The id the goal was sent with.
        state: Current state.
        status: Latest accepted status; PENDING before any.
        text: The server's text that came with it.
        server: Caller id of the server of this goal; "" until a server has reported it.
        result: Result message, None before it arrives.
    """

    goal_id: str
    state: CommState = CommState.WAITING_FOR_GOAL_ACK
    status: GoalStatus = GoalStatus.PENDING
    text: str = ""
    server: str = ""
    result: object | None = None

    @property
    def done(self) -> bool:
        """Whether the state is final."""
        return self.state is CommState.DONE

    def status_received(self, status: int, text: str, server: str = "") -> tuple[CommState, ...]:
        """A status array of `server` contains this goal.

        Args:
            status: Number of a GoalStatus; an unknown one is ignored.
            text: The server's text.
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
            return ()
        self.status, self.text = known, text
        return self._pass(path)

    def unmentioned(self, server: str = "") -> tuple[CommState, ...]:
        """A status array of `server` arrived without this goal."""
        if self.state in _MAY_BE_UNMENTIONED or (server and server != self.server):
            return ()
        return self.lose("the action server no longer knows this goal; it was restarted or dropped it")

    def result_received(
        self, result: object, status: int, text: str, server: str = ""
    ) -> tuple[CommState, ...]:
        """The result arrived. The goal becomes DONE whatever its status; after DONE it is ignored."""
        if self.done or not self._is_ours(server):
            return ()
        passed = self.status_received(status, text, server)
        self.result = result
        if not (self.status.is_terminal and self.status == status):
            # The result has no fitting status (unknown or not terminal). The goal has ended for certain; the
            # text is kept.
            self.status = _nearest_terminal(status, self.state)
            self.text = text
        return passed + self._pass((CommState.DONE,))

    def cancel_sent(self) -> tuple[CommState, ...]:
        """A cancel of this goal was sent; enter WAITING_FOR_CANCEL_ACK where the server's reaction is
        expected.
        """
        if not self.cancel_helps:
            return ()
        return self._pass((CommState.WAITING_FOR_CANCEL_ACK,))

    @property
    def cancel_helps(self) -> bool:
        """Whether a cancel can still have an effect (roscpp's ClientGoalHandle::cancel)."""
        return self.state in _CANCEL_HELPS

    def lose(self, why: str) -> tuple[CommState, ...]:
        """End the goal as LOST."""
        if self.done:
            return ()
        self.status, self.text = GoalStatus.LOST, why
        return self._pass((CommState.DONE,))

    def is_from(self, server: str) -> bool:
        """Whether a message of `server` may concern this goal: the server is the goal's, or none is known
        yet.
        """
        return not server or not self.server or server == self.server

    def _is_ours(self, server: str) -> bool:
        self.server = self.server or server
        return self.is_from(server)

    def _pass(self, path: tuple[CommState, ...]) -> tuple[CommState, ...]:
        if path:
            self.state = path[-1]
        return path


def _nearest_terminal(status: int, state: CommState) -> GoalStatus:
    """A terminal status for a result whose own status does not fit the state."""
    try:
        known = GoalStatus(status)
    except ValueError:
        return GoalStatus.LOST
    if known.is_terminal:
        return known  # illegal by the table (REJECTED of an active goal), but it is the server's final status
    return GoalStatus.PREEMPTED if state is CommState.PREEMPTING else GoalStatus.ABORTED
