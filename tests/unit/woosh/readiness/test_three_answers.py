"""Whether it would move: yes, no, or not known; and what was refused is remembered until it is shown to be over."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import pytest

from tests.unit.woosh.test_values import status
from woosh_pure.enums import RobotMode, RobotState
from woosh_pure.errors import MotionRefused
from woosh_pure.faults import Faults, decode_status_code
from woosh_pure.readiness.readiness_state import Refusals, assess, triggered_keys
from woosh_pure.reasons import Readiness, Ready, Reason, ReasonKey

STOP, RELEASED = 110201000013, 110201000000
MOTOR = 110301000013


def test_a_state_that_was_never_told_is_not_known():
    readiness = assess(None, [])
    assert readiness.answer is Ready.UNKNOWN
    assert not readiness
    assert not readiness.blocked
    assert [(r.key, r.blocking, r.doubt) for r in readiness.reasons] == [(ReasonKey.UNKNOWN, False, True)]


def test_the_robots_own_word_is_a_yes():
    assert assess(status(), []).answer is Ready.YES


@pytest.mark.parametrize("state", [RobotState.UNDEFINED, RobotState.UNINITIALISED])
def test_a_state_that_says_nothing_of_faults_is_no_yes(state):
    assert assess(status(robot_state=state), []).answer is Ready.UNKNOWN


def test_what_blocks_makes_a_no_of_what_is_not_known():
    assert assess(None, [decode_status_code(STOP)]).answer is Ready.NO


def test_a_broken_link_makes_what_was_told_uncertain():
    assert assess(status(), [], link_lost=True).answer is Ready.UNKNOWN
    assert assess(status(), [], silent=4.0).answer is Ready.UNKNOWN


def test_a_motion_that_arrived_shows_that_nothing_stopped_it():
    assert assess(None, [], has_moved=True).answer is Ready.YES


def test_a_key_is_told_and_not_taken_for_the_emergency_stop():
    """The definition says "chassis keys" and not which is which."""
    lines = [
        SimpleNamespace(module=1, id=3, status=1),
        SimpleNamespace(module=1, id=4, status=0),
        SimpleNamespace(module=2, id=5, status=1),
    ]
    keys = triggered_keys(SimpleNamespace(IOs=lines))
    assert keys == (3,)
    assert triggered_keys(None) == ()
    readiness = assess(status(), [], keys=keys)
    assert readiness.answer is Ready.YES
    assert "key 3 of the chassis" in readiness.sentence()
    assert readiness.reasons[0].key is ReasonKey.CHASSIS_KEY


def test_a_key_is_compared_as_the_text_it_was():
    assert ReasonKey.EMERGENCY_STOP == "emergency_stop"
    assert f"{ReasonKey.EMERGENCY_STOP}" == "emergency_stop"


@pytest.mark.parametrize(
    ("text", "state", "answer"),
    [
        ("goal of /move_base: no words", None, Ready.UNKNOWN),
        (f"status code {STOP}", None, Ready.NO),
        ("mark 'Z' is not known", RobotState.IDLE, Ready.YES),
        ("emergency stop", RobotState.FAULT, Ready.NO),
        ("no words", RobotState.UNDEFINED, Ready.UNKNOWN),
    ],
)
def test_what_was_refused_counts_by_what_was_told_with_it(text, state, answer):
    refusals = Refusals()
    refusals.note(text, 1.0, state)
    readiness = assess(status(), [], refusals=refusals.reasons())
    assert readiness.answer is answer
    assert not readiness.refuses  # the chassis may be asked again
    assert text in readiness.sentence()


def test_a_refusal_lasts_until_it_is_shown_to_be_over():
    refusals = Refusals()
    refusals.note(f"status code {STOP}", 5.0)
    refusals.end_before(5.0)  # told before
    refusals.receive(decode_status_code(110202000000))  # the end of something else
    assert refusals.reasons()
    refusals.receive(decode_status_code(RELEASED))
    assert not refusals.reasons()
    refusals.note("refused", 5.0)
    refusals.end_before(5.1)
    assert not refusals.reasons()
    refusals.note("refused", 5.0)
    refusals.end()
    assert not refusals.reasons()


def test_what_the_robot_tells_now_is_not_repeated_by_what_it_refused():
    refused = (Reason(ReasonKey.REFUSED, "refused"),)
    readiness = assess(status(robot_mode=RobotMode.MANUAL), [], refusals=refused)
    assert [r.key for r in readiness.reasons] == [ReasonKey.MANUAL_MODE]


def test_the_cause_comes_first_and_is_not_repeated_as_a_fault():
    """A pressed emergency stop also makes the state "fault": what is told first is the button, and only that."""
    stopped = status(robot_state=RobotState.FAULT, robot_mode=RobotMode.MANUAL)
    readiness = assess(stopped, [decode_status_code(MOTOR), decode_status_code(STOP)])
    keys = [r.key for r in readiness.reasons]
    assert keys == [ReasonKey.EMERGENCY_STOP, ReasonKey.MANUAL_MODE, ReasonKey.FAULT]
    assert str(decode_status_code(MOTOR)) == readiness.reasons[2].text
    alone = assess(status(robot_state=RobotState.FAULT), [])
    assert [(r.key, r.blocking) for r in alone.reasons] == [(ReasonKey.FAULT, True)]


def test_every_refusal_has_reasons():
    assert [r.key for r in MotionRefused("stop() was called").reasons] == [ReasonKey.CALL]
    blocked = assess(None, [decode_status_code(STOP)])
    assert MotionRefused("refused", readiness=blocked).reasons == blocked.reasons
    assert [r.key for r in MotionRefused("refused", readiness=Readiness()).reasons] == [ReasonKey.REFUSED]


@pytest.mark.parametrize(
    ("codes", "state", "present", "text"),
    [
        ((), None, None, "not known"),
        ((), RobotState.IDLE, False, "none"),
        ((), RobotState.UNINITIALISED, None, "not known"),
        ((), RobotState.FAULT, True, "the robot reports a fault"),
        ((), RobotState.WARNING, True, "the robot reports a warning"),
        ((STOP,), None, True, "110201000013"),
    ],
)
def test_no_faults_are_none_only_where_the_robot_says_so(codes, state, present, text):
    faults = Faults(map(decode_status_code, codes), state)
    assert faults.present is present
    assert text in faults.sentence()
    assert list(faults) == [decode_status_code(code) for code in codes]


def test_a_fit_robot_is_one_that_says_so():
    from woosh_pure.readiness.readiness_state import status_shows_fitness

    assert status_shows_fitness(status())
    assert not status_shows_fitness(replace(status(), robot_state=RobotState.FAULT))
    assert not status_shows_fitness(replace(status(), robot_mode=RobotMode.MANUAL))
