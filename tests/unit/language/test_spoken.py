"""In Python, `str()` is English; `sentence()` and `said()` are in the user's language."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from rosproto.coercion import as_float
from rosproto.errors import BagError, CodecError, ConnectionLost, DefinitionError, RosError, ServiceError
from rosproto.gateway import Access
from rosproto.msg.definition_files import folder_source
from rosproto.names import resolve
from rosproto.numeric.pngfile import decode_png
from rosproto.recording.recorder import _compiled
from rosproto.sentence import say
from tools import templates
from tools.templates import english_left
from woosh_pure import Chassis
from woosh_pure.errors import GoalFailed, MotionRefused
from woosh_pure.faults import Faults, decode_status_code
from woosh_pure.language import said
from woosh_pure.language.table import translator_for
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


ROSPROTO = [
    (BagError("already exists; choose another name", path="run.bag"), "run.bag: 已经存在"),
    (BagError("the file is empty", path="run.bag", offset=7), "文件是空的（第 7 字节处）"),
    (DefinitionError("is not a folder; expected a package, a folder of packages or a workspace", file="/x"), "/x: 不是文件夹"),
    (CodecError(say("{value} is not a valid {type}", value="'a'", type="float64"), field_path="x"), "不是有效的 float64"),
    (ServiceError("/static_map", "no answer"), "服务 /static_map"),
]  # fmt: skip


@pytest.mark.parametrize(("error", "chinese"), ROSPROTO, ids=lambda value: type(value).__name__)
def test_the_place_of_an_error_leaves_its_sentence_a_sentence(error: RosError, chinese: str) -> None:
    """File, field, byte and service stand in front of it or behind it."""
    assert chinese in said(error, "zh")
    assert said(error, "en") == str(error)


@pytest.mark.parametrize(
    ("wrong", "chinese"),
    [
        (lambda: resolve("a b", "/me"), "'a b' 不是 ROS 名称；应以 ASCII 字母"),
        (lambda: as_float("1"), "'1' 是字符串；应为数字"),
        (lambda: Access(write=["foo:/x"]), "没有 'foo' 这一类"),
        (lambda: folder_source("/nowhere/at/all"), "/nowhere/at/all: 不是文件夹"),
        (lambda: decode_png(b"GIF89a", 100), "不是 PNG 图像"),
        (lambda: _compiled("("), "不是正则表达式"),
    ],
)
def test_a_wrong_value_is_refused_in_chinese(wrong: Callable[[], object], chinese: str) -> None:
    with pytest.raises((ValueError, TypeError)) as caught:
        wrong()
    assert chinese in said(caught.value, "zh")


def test_the_hint_to_a_wrong_guess_is_said_in_chinese() -> None:
    """In English too, the text is that of Python, with the right call behind it."""
    chassis = Chassis("127.0.0.1:1")
    for guess, words in (
        (lambda: chassis.goto, "；请用 go_to_mark(name)，或 go_to(x, y, yaw)"),
        (lambda: chassis.battery(), "不能调用；请用 .wait(timeout=5)，或 .latest"),
        (lambda: chassis.battery.percent, "请用 wait(timeout=5).NAME，或 latest.NAME"),
        (lambda: chassis.go_to("A1"), "；请用 go_to(x, y, yaw)，单位米和弧度；标记点用"),
    ):
        with pytest.raises((AttributeError, TypeError)) as caught:
            guess()
        assert words in said(caught.value, "zh")
        assert str(caught.value).isascii()


@pytest.mark.parametrize(("guess", "right"), [("success", "arrived"), ("ok", "arrived")])
def test_the_hint_to_a_name_of_an_attribute_keeps_the_name(guess: str, right: str) -> None:
    """A word such as "arrived" is also a sentence of the table; what is typed is not translated."""
    with pytest.raises(AttributeError) as caught:
        getattr(FAILED, guess)
    assert said(caught.value, "zh").endswith(f"请用 {right}")


def test_every_hint_in_words_has_its_chinese() -> None:
    left = [
        right
        for right in templates.hinted()
        if not right.startswith(("woosh ", "rosproto ", "from "))
        and english_left(right)
        and not translator_for("zh").has(right)
    ]
    assert left == []


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
