"""A sentence is found in the table, and said with its facts; what is not there stays as it is."""

from __future__ import annotations

import io
import random
from enum import Enum

import pytest

from rosproto.errors import RosError
from rosproto.sentence import both, led, say
from rosproto.text import width
from woosh_pure.cli.output import Output
from woosh_pure.faults import all_codes, decode_status_code, with_words
from woosh_pure.language import LANGUAGES
from woosh_pure.language.table import Translation, Translator, read_table, translator_for
from woosh_pure.stopping.report import StopReport

TABLE = """
# a comment
arrived
已到达

{goal}: {kind} after {seconds} s
{goal}：{kind}，用时 {seconds} 秒

the robot stands still
机器人已停稳

mark {name}
标记点 {name}

cancelled {what}
已取消 {what}

the drive is over: {why}; nothing resumes
已结束：{why}；不会恢复

is it up?
它开机了吗？

ready
就绪

{first}; {second}
{first}；{second}

{first}, {second}
{first}、{second}

{head}: {tail}
{head}：{tail}
"""


class Kind(Enum):
    ARRIVED = "arrived"

    def __str__(self) -> str:
        return self.value


class Fault:
    """Knows its own translation, as the vendor's status codes do."""

    def __str__(self) -> str:
        return "a fault"

    def said(self, language: str) -> str:
        return f"故障 {language}"


@pytest.fixture
def words() -> Translator:
    return Translator(read_table(TABLE), "zh")


@pytest.mark.parametrize(
    ("sentence", "chinese"),
    [
        ("the robot stands still", "机器人已停稳"),
        (say("the robot stands still"), "机器人已停稳"),
        ("ready; the robot stands still", "就绪；机器人已停稳"),
        ("is it up?; ready", "它开机了吗？就绪"),
        ("ready: the robot stands still", "ready: the robot stands still"),  # nobody reads a text
        ("mark A1", "mark A1"),
        ("nobody knows this", "nobody knows this"),
        ("nobody knows this; ready", "nobody knows this; ready"),
        ("{goal} %s {0}", "{goal} %s {0}"),
        ("", ""),
        ("   ", "   "),
        (say("{goal}: {kind} after {seconds:.1f} s", goal=say("mark {name}", name="ready"), kind=Kind.ARRIVED, seconds=3.21),
         "标记点 ready：已到达，用时 3.2 秒"),
        (say("{goal}: {kind} after {seconds:.1f} s", goal="ready", kind="arrived", seconds=3.21),
         "ready：arrived，用时 3.2 秒"),  # data
        (say("cancelled {what}", what=[say("mark {name}", name="A1"), say("mark {name}", name="B1")]),
         "已取消标记点 A1、标记点 B1"),
        (say("cancelled {what}", what=["a", "b"]), "已取消 a, b"),
        (say("cancelled {what}", what=[]), "已取消 "),
        (say("mark {name}", name="仓库 东门"), "标记点仓库 东门"),  # the blank of the name stays
        (say("mark {name}", name=" 仓库"), "标记点  仓库"),
        (say("cancelled {what!r}", what="a"), "已取消 'a'"),
        (say("cancelled {what}", what=Fault()), "已取消故障 zh"),
        (both("the robot stands still", say("mark {name}", name="the; ready")), "机器人已停稳；标记点 the; ready"),
        (both("is it up?", "ready", "ready"), "它开机了吗？就绪；就绪"),
        (both("nobody knows this", "ready"), "nobody knows this；就绪"),
        (led(say("ready"), "is it up?"), "就绪：它开机了吗？"),
        (say("the drive is over: {why}; nothing resumes", why=RosError(both("ready", "is it up?"))),
         "已结束：就绪；它开机了吗？不会恢复"),
        (say("the drive is over: {why}; nothing resumes", why=RosError("is it up?")), "已结束：它开机了吗？不会恢复"),
        (say("nobody knows {this}", this="ready"), "nobody knows ready"),
        (say("cancelled {what}", what="{what} %s {0}"), "已取消 {what} %s {0}"),
    ],
)  # fmt: skip
def test_a_sentence_is_found_by_its_template(words: Translator, sentence: str, chinese: str) -> None:
    """Nobody reads its text: a name that looks like words, or has the marks of a sentence, stays as it is."""
    assert words.say(sentence) == chinese
    assert words.say(chinese) == chinese  # said once is said


def test_what_a_stop_has_done_is_said_by_its_parts() -> None:
    """A mark may have any name."""
    report = StopReport(True, [say("mark {name}", name="ready; {x}")], pending=["task 3"])
    assert report.sentence() == (
        "the robot stands still; cancelled mark ready; {x}; asked again until its end is seen: task 3"
    )
    said = report.sentence("zh")
    assert said == "机器人已停稳；已取消标记点“ready; {x}”；再次请求，直到看到它结束：task 3"


def test_columns_are_as_wide_in_each_language() -> None:
    """By the width of a terminal: a Chinese character takes two."""
    for language in LANGUAGES:
        stream = io.StringIO()
        out = Output(stream=stream, language=language)
        for name in ("battery", "ready"):
            out.line(out.cell(name, 12), "3.2 V", "the robot stands still")
        lines = stream.getvalue().splitlines()
        assert [width(line[: line.index("3.2 V")]) for line in lines] == [13, 13]
        assert all(line.endswith("机器人已停稳") is (language == "zh") for line in lines)


def test_a_coloured_word_is_said_in_its_colour(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = io.StringIO()
    monkeypatch.setattr("rosproto.cli.output.enable_escapes", lambda stream: True)
    out = Output(stream=stream, language="zh")
    out.line(say("{head}: {tail}", head=out.colour("ready", "green", 10), tail=say("the robot stands still")))
    assert stream.getvalue() == "\x1b[32m可以移动  \x1b[0m：机器人已停稳\n"


@pytest.mark.parametrize(
    ("table", "complaint"),
    [
        ("only English\n", "translation"),
        ("a {x} b\n甲 {y} 乙\n", "places"),
        ("a {x} b\n甲\n", "places"),
        ("one\n一\ntwo\n二\n", "4 lines"),
    ],
)
def test_a_wrong_table_is_an_error(table: str, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        list(read_table(table))


def test_status_codes_have_the_words_of_the_vendor() -> None:
    words = translator_for("zh")
    for code in random.Random(3).sample(list(all_codes()), 50):
        assert str(code) == f"{code.english} ({code.code})"
        assert words.say(str(code)) == f"{code.chinese}（{code.code}）"
        told = say(
            "{fault}; it was reported before the connection to its publisher broke: it may be over",
            fault=code,
        )
        assert words.say(told).startswith(f"{code.chinese}（{code.code}）；")
    assert words.say("something else (110201000013)") == "something else (110201000013)"


def test_what_a_chassis_says_of_a_code_has_the_words_of_the_vendor() -> None:
    said = translator_for("zh").say(with_words("status code 110201000013"))
    assert said == f"状态码 110201000013（{decode_status_code(110201000013).chinese}）"


def test_english_is_said_as_it_is() -> None:
    assert not translator_for("en")
    assert translator_for("en").say("the robot stands still") == "the robot stands still"
    assert bool(Translator([Translation("a", "b")]))
