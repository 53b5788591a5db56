"""A sentence is found in the table, and said with its facts; what is not there stays as it is."""

from __future__ import annotations

import random

import pytest

from rosproto.errors import RosError
from rosproto.sentence import both, led, say
from rosproto.text import width
from woosh_pure.faults.codes import all_codes
from woosh_pure.language.table import Row, Words, read_table, words_for
from woosh_pure.stopping.report import StopReport

TABLE = """
# a comment
arrived
已到达

{goal}: {kind} after {seconds} s
{goal}：{kind}，用时 {seconds} 秒

the robot stands still
机器人已停稳

mark {name=}
标记点 {name=}

cancelled {what}
已取消 {what}

the drive is over: {why+}; nothing resumes
已结束：{why}；不会恢复

is it up?
它开机了吗？

ready
就绪
"""


@pytest.fixture
def words() -> Words:
    return Words(read_table(TABLE))


@pytest.mark.parametrize(
    ("english", "chinese"),
    [
        ("the robot stands still", "机器人已停稳"),
        ("mark A1: arrived after 3.2 s", "标记点 A1：已到达，用时 3.2 秒"),
        ("mark A1: arrived after 3.2 s; the robot stands still", "标记点 A1：已到达，用时 3.2 秒；机器人已停稳"),
        ("mark ready", "标记点 ready"),  # somebody's name is nobody's word
        ("cancelled mark A1, mark B1", "已取消 标记点 A1、标记点 B1"),
        ("the drive is over: is it up?; the robot stands still; nothing resumes",
         "已结束：它开机了吗？机器人已停稳；不会恢复"),
        ("ready: the robot stands still", "就绪：机器人已停稳"),
        ("/odom: the robot stands still", "/odom: 机器人已停稳"),
        ("http://10.0.0.7:11311/: is it up?; is it up?", "http://10.0.0.7:11311/: 它开机了吗？它开机了吗？"),
        ("  mark A1 ...", "  标记点 A1 ..."),
        ("nobody knows this; the robot stands still", "nobody knows this；机器人已停稳"),
        ("nobody knows this", "nobody knows this"),
        ("the robot stands still\nready", "机器人已停稳\n就绪"),
        ("", ""),
        ("   ", "   "),
    ],
)  # fmt: skip
def test_sentences(words: Words, english: str, chinese: str) -> None:
    assert words.say(english) == chinese
    assert words.say(chinese) == chinese  # said once is said


@pytest.mark.parametrize(
    ("sentence", "chinese"),
    [
        (say("the robot stands still"), "机器人已停稳"),
        (say("{goal}: {kind} after {seconds:.1f} s", goal=say("mark {name}", name="ready"), kind="arrived", seconds=3.21),
         "标记点 ready：已到达，用时 3.2 秒"),
        (say("cancelled {what}", what=[say("mark {name}", name="A1"), say("mark {name}", name="B1")]),
         "已取消 标记点 A1、标记点 B1"),
        (both("the robot stands still", say("mark {name}", name="the; ready")), "机器人已停稳；标记点 the; ready"),
        (both("is it up?", "ready"), "它开机了吗？就绪"),
        (led("/odom", say("ready")), "/odom: 就绪"),
        (led(say("ready"), "is it up?"), "就绪：它开机了吗？"),
        (say("the drive is over: {why}; nothing resumes", why=RosError(both("ready", "is it up?"))),
         "已结束：就绪；它开机了吗？不会恢复"),
        (say("nobody knows {this}", this="ready"), "nobody knows ready"),
        (say("cancelled {what}", what="{what} %s {0}"), "已取消 {what} %s {0}"),
    ],
)  # fmt: skip
def test_a_sentence_is_found_by_its_template(words: Words, sentence: str, chinese: str) -> None:
    """Nobody reads its text: a name that looks like words, or has the marks of a sentence, stays as it is."""
    assert words.say(sentence) == chinese


def test_what_a_stop_has_done_is_said_by_its_parts() -> None:
    """A mark may have any name."""
    report = StopReport(True, [say("mark {name}", name="ready; {x}")], pending=["task 3"])
    assert report.sentence() == (
        "the robot stands still; cancelled mark ready; {x}; asked again until it is seen to end: task 3"
    )
    said = words_for("zh").say(report.sentence())
    assert said.startswith("机器人已停稳；已取消 ")
    assert "ready; {x}" in said
    assert "；再次请求，直到看到它结束：" in said


def test_columns_stay_where_they_were(words: Words) -> None:
    """By the width of a terminal: a Chinese character takes two."""
    for english in ("ready       3.2 V  the robot stands still", "ready    x", "ready  x"):
        said = words.say(english)
        for cell in ("3.2 V", "x"):
            if cell in english:
                assert width(said[: said.index(cell)]) == max(english.index(cell), 6)
    assert words.say("ready   ") == "就绪    "


def test_a_coloured_word_is_kept_in_its_colour(words: Words) -> None:
    assert words.say("\x1b[32m就绪\x1b[0m: the robot stands still") == "\x1b[32m就绪\x1b[0m: 机器人已停稳"


@pytest.mark.parametrize(
    ("table", "complaint"),
    [
        ("only English\n", "translation"),
        ("a {x} b\n甲 {y} 乙\n", "places"),
        ("a {x} b\n甲\n", "places"),
        ("a {x} {x}\n甲 {x}\n", "places"),
        ("one\n一\ntwo\n二\n", "4 lines"),
    ],
)
def test_a_wrong_table_is_an_error(table: str, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        list(read_table(table))


def test_status_codes_have_the_words_of_the_vendor() -> None:
    words = words_for("zh")
    for code in random.Random(3).sample(list(all_codes()), 50):
        assert words.say(str(code)) == f"{code.chinese}（{code.code}）"
    assert words.say("something else (110201000013)") == "something else (110201000013)"


def test_english_is_said_as_it_is() -> None:
    assert not words_for("en")
    assert words_for("en").say("the robot stands still") == "the robot stands still"
    assert bool(Words([Row("a", "b")]))


def test_any_text_is_said_in_bounded_time() -> None:
    """What comes from a peer may be long, and made to be hard to match."""
    words = words_for("zh")
    for text in ("the " * 3000, "; " * 2000, ": " * 300, "x: {a}; " * 200, "a  b" * 1000, "(" * 5000):
        assert isinstance(words.say(text), str)
