"""Every sentence that the commands an owner types can print has its Chinese form; what is missing is listed.

To mend it, add a sentence and its translation to a file in woosh_pure/language/zh: the failure prints rows to fill
in. A sentence that only programs see (an argument no command can give wrong) goes into `FOR_PROGRAMS`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from rosproto.transport.host_names import hosts_advice
from tests.support.sentences import english_left, sentences
from woosh_pure.language.table import read_table, words_for

ROOT = Path(__file__).resolve().parents[3]
TABLES = sorted((ROOT / "woosh_pure/language/zh").glob("*.txt"))
COMMANDS = "doctor status ready goto move rotate drive stop faults selftest connect".split()
SOURCES = [
    *(f"woosh_pure/cli/commands/{name}.py" for name in COMMANDS),
    *(f"woosh_pure/cli/{name}.py" for name in ("config", "connection", "entry", "readiness", "arguments")),
    *(f"woosh_pure/{name}.py" for name in (
        "connection/address", "connection/clients", "connection/connection", "doctor/definitions",
        "doctor/examination", "feed/feed", "feed/feeds", "motion/action_goal", "motion/goal", "motion/steps",
        "motion/task", "motion/task_tracker", "outcome", "readiness/assessment", "readiness/knowledge",
        "readiness/other_goals", "selftest", "stopping/other_clients", "stopping/report", "stopping/running",
        "stopping/stop", "velocity/drive", "connection/other_drivers", "velocity/shaper", "velocity/watch",
    )),
    *(f"rosproto/cli/{name}.py" for name in ("failure", "options", "parser")),
    *(f"rosproto/selftest/{name}.py" for name in ("bags", "checking", "codecs", "definitions", "nodes", "real_ros")),
    "rosproto/transport/address.py",
    "rosproto/transport/host_names.py",
    "rosproto/transport/os_errors.py",
]  # fmt: skip
"""What those commands are made of, as far as it says something."""
FOR_PROGRAMS = [
    r"this Chassis is closed; open a new one",
    r"this feed is closed, because its Chassis is",
    r"the node of this Chassis is closed",
    r"waiting for its next value in its own callback",
    r"every (number|value) must be (a )?finite",
    r"angle \S+ rad is more than one turn",
    r"for degrees say degrees=True",
    r"^step mode \S+ is not known",
    r"give a positive speed; the sign",
    r"^(feedback_timeout|seconds|since|valid_for)=",
    r"(m/s|rad/s) is more than the limit",
    r"^task type |^mark \S+: give its name as text|^a task needs a mark or poses|^direction \S+: expected load",
    r"expected a whole number of",
    r"^no field for ",
    r"^not connected yet$",
    r"^as the system says$",  # of a repr
    r"woosh: the robot is to stop",  # a reason told to another program
    r"^Drive a Woosh chassis, or the simulated one|^Stopping by this program is no emergency stop",  # of --help
    r"; end what runs there, or choose another --port|^no such address$|; give one of its own with",  # of servers
    r"^a longer text, of more than sixteen bytes$",
]
"""What no owner sees who types commands."""
PIECES = {
    " (sent on change only)": "not heard yet (sent on change only)",
    "does not answer": "10.0.0.7:11311 does not answer",
    "cannot be reached: ⟨1⟩": "10.0.0.7:11311 cannot be reached: timed out",
    "⟨1⟩ (⟨2⟩) ⟨3⟩ velocities, too, on ⟨4⟩": "/a (http://10.0.0.7:1/) can send velocities, too, on /cmd and /b",
    " (it is sent on change only)": "/b: nothing came within 2 s (it is sent on change only); 1 publishers are connected; "
    "check `woosh doctor`",
    "⟨1⟩: nothing came within ⟨2⟩ s⟨3⟩; ⟨4⟩; check `woosh doctor`": "/b: nothing came within 2 s; 1 publishers are "
    "connected; check `woosh doctor`",
    "⟨1⟩: no publisher within ⟨2⟩ s⟨3⟩, so the end of a task could not be seen; check `woosh doctor`": "/b: no publisher "
    "within 2 s, so the end of a task could not be seen; check `woosh doctor`",
    'give --resolve ⟨1⟩=⟨2⟩ (or ⟨3⟩=⟨4⟩=⟨5⟩, or resolve= in Python); for all programs: add the line "⟨6⟩ ⟨7⟩" to ⟨8⟩ '
    "(⟨9⟩)⟨10⟩; best is ROS_IP on that computer": hosts_advice("robot-7", "10.0.0.7", platform="linux"),
    " (ADDRESS is that of the computer that calls itself ⟨1⟩)": hosts_advice(
        "robot-7", None, platform="win32"
    ),
    ", with its own address in place of ⟨1⟩ if ⟨2⟩ is another computer than the master's": hosts_advice(
        "robot-7", "10.0.0.7", sure=False, platform="linux"
    ),
    "⟨1⟩ of ⟨2⟩ rows of its interface are": "3 of 40 rows of its interface are registered",
    "too many open files⟨1⟩; close some, or allow more with `ulimit -n 4096`": "too many open files in this program (or "
    "computer), which may have 1024; close some, or allow more with `ulimit -n 4096`",
    " in this program (or computer)": "too many open files in this program (or computer)",
    ", which may have ⟨1⟩": "too many open files in this program (or computer), which may have 1024",
    "⟨1⟩ has a goal of its own": "/a has a goal of its own under way on /move_base",
    "the robot has a task of another client, or of its own,": "the robot has a task of another client, or of its own, under "
    "way on /move_base",
    "⟨1⟩ under way on ⟨2⟩": "/a has a goal of its own under way on /move_base",
    "it was asked to end and has not": "/a (http://10.0.0.7:1/) sends velocities, too, on /b, it was asked to end and has not",
    "which only its end stops: ⟨1⟩": "/a (http://10.0.0.7:1/) sends velocities, too, on /b; it does not answer: if it has "
    "gone, `rosproto node cleanup` takes it off the master, which only its end stops: woosh stop --end-drivers",
}
"""Pieces of sentences, and a whole one that each becomes."""


def missing() -> Iterator[tuple[str, str]]:
    """(where, sentence) of what the table does not have."""
    words = words_for("zh")
    for name in SOURCES:
        for line, text in sentences(ROOT / name):
            if any(re.search(pattern, text) for pattern in FOR_PROGRAMS):
                continue
            if english_left(words.say(PIECES.get(text, text))):
                yield f"{name}:{line}", PIECES.get(text, text)


def test_every_sentence_has_its_chinese_form() -> None:
    rows = [f"# {where}\n{text}\n" for where, text in missing()]
    assert not rows, f"{len(rows)} sentences have no translation:\n\n" + "\n".join(rows)


def test_no_exception_is_left_over() -> None:
    """A pattern for what nobody says any more would hide what somebody says tomorrow."""
    texts = [text for name in SOURCES for _, text in sentences(ROOT / name)]
    assert [p for p in FOR_PROGRAMS if not any(re.search(p, text) for text in texts)] == []
    assert [piece for piece in PIECES if piece not in texts] == []


@pytest.mark.parametrize("path", TABLES, ids=lambda path: path.name)
def test_a_table_can_be_read_and_its_places_agree(path: Path) -> None:
    """Raises where a sentence has no translation, or another set of places."""
    rows = list(read_table(path.read_text("utf-8"), path.name))
    assert len(rows) > 10
    for row in rows:
        chinese = re.sub(r"\{\w+[+=]?\}|`[^`]*`|[\w./:=()\[\]%°-]+", "", row.translated, flags=re.ASCII)
        assert re.search("[一-鿿]", chinese) or not english_left(row.english), row


def test_no_sentence_is_there_twice() -> None:
    """With another translation the order of the files would decide."""
    seen: dict[str, str] = {}
    for path in TABLES:
        for row in read_table(path.read_text("utf-8"), path.name):
            assert row.english not in seen, f"{row.english!r} is in {seen.get(row.english)} and {path.name}"
            seen[row.english] = path.name


def test_the_look_for_english_sees_it() -> None:
    """A check that cannot fail checks nothing."""
    assert english_left("the robot stands still")
    assert english_left("机器人已停稳；look at the display of it")
    assert not english_left("请运行诊断 `woosh doctor --listen 3`，或看 http://10.0.0.7:11311/ the")
    assert not english_left("/odom_twist, /cmd_vel: 3.2 m/s at A1")


def test_the_terms_are_those_of_this_project() -> None:
    """停车 is parking, and the doctor is asked for a diagnosis."""
    text = "".join(path.read_text("utf-8") for path in TABLES)
    assert "停车" not in text
    for path in TABLES:
        for row in read_table(path.read_text("utf-8")):
            if re.search("(try|check) `woosh doctor`", row.english):
                assert "运行诊断 `woosh doctor`" in row.translated, row
