"""In Python, `str()` is English; `sentence()` and `said()` are in the user's language."""

from __future__ import annotations

import math

import pytest

from rosproto.errors import ConnectionLost
from rosproto.sentence import say
from woosh_pure.errors import GoalFailed, MotionRefused
from woosh_pure.faults import Faults, decode_status_code
from woosh_pure.language import said
from woosh_pure.motion.steps import Step, check_steps
from woosh_pure.outcome import Outcome, OutcomeKind
from woosh_pure.reasons import Readiness, Reason, ReasonKey
from woosh_pure.stopping.report import StopReport

FAILED = Outcome(OutcomeKind.FAILED, say("drive to {mark}", mark="A1"), stopped=True, seconds=2.0)
BLOCKED = Readiness(
    (Reason(ReasonKey.NOT_LOCALISED, say("the robot does not know where it is; give it its position")),)
)
SPOKEN = [
    (FAILED, "机器人已停稳"),
    (GoalFailed(FAILED), "机器人已停稳"),
    (BLOCKED, "机器人不知道自己在哪里"),
    (Readiness(), "未发现妨碍移动的因素"),
    (MotionRefused(say("the text is empty; give the words to say")), "请给出要说的话"),
    (StopReport(standing=True), "机器人已停稳"),
    (Faults([decode_status_code(110201000013)]), "急停"),
]


@pytest.mark.parametrize(("thing", "chinese"), SPOKEN, ids=lambda value: type(value).__name__)
def test_a_sentence_is_in_the_language_that_is_asked_for(thing, chinese: str) -> None:
    assert chinese in thing.sentence("zh")
    assert thing.sentence(lang="en") == str(thing)
    assert str(thing).isascii()
    assert said(thing, "zh") == thing.sentence("zh")


def test_the_language_is_the_one_that_the_commands_choose(monkeypatch: pytest.MonkeyPatch) -> None:
    """LC_ALL, LC_MESSAGES, LANG; what stands in an exception or a log stays English."""
    for name in ("LC_ALL", "LC_MESSAGES", "LANG"):
        monkeypatch.delenv(name, raising=False)
    assert FAILED.sentence() == str(FAILED)
    monkeypatch.setenv("LANG", "zh_CN.UTF-8")
    assert FAILED.sentence() == FAILED.sentence("zh") != str(FAILED)
    assert f"{FAILED}" == str(FAILED)
    monkeypatch.setenv("LC_ALL", "en_US.UTF-8")
    assert FAILED.sentence() == str(FAILED)


def test_an_error_of_ros_is_said_too() -> None:
    """Errors of `rosproto` are sentences with the same table; what has no row stays English."""
    lost = ConnectionLost(
        say(
            "host name {host} cannot be resolved ({error}); add it to the hosts file or the name server, or let "
            "the other side announce a numeric address (ROS_IP or ROS_HOSTNAME there)",
            host="robot",
            error="unknown",
        )
    )
    assert said(KeyError("words"), "zh") == "words"
    chinese = said(lost, "zh")
    assert chinese.startswith("主机名 robot 无法解析")
    assert said(lost, "en") == str(lost)


def test_a_refusal_of_a_step_names_the_library_and_no_shell_command() -> None:
    """A command of a shell is advice for those who type it; a number that is not finite is shown as the step."""
    for distance, words in ((50.0, "更长的路程请用 go_to"), (math.nan, "直行 nan 米：每个数都必须是有限的")):
        with pytest.raises(ValueError) as caught:
            check_steps([Step.straight(distance)])
        assert words in said(caught.value, "zh")
        assert "woosh" not in said(caught.value, "zh")


def test_another_language_is_refused() -> None:
    with pytest.raises(ValueError, match="lang='fr': expected one of en, zh"):
        FAILED.sentence("fr")
