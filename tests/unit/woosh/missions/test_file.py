"""Mission files: what is refused, where the fault is, and that writing undoes reading."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import given, settings

from tests.support.mission_model import missions
from woosh_pure.missions import KINDS, STEP_KEYS, Mission, MissionError, parse, text_of
from woosh_pure.missions.file import MissionFiles
from woosh_pure.missions.mission import GUARDS

ROOT = Path(__file__).resolve().parents[4]
GOOD = """\
mission = 1
name = "Round"

[parameters]
target = "A1"

[guards]
battery_below = 20
charger = "C1"

# a comment
[[step]]
name = "there"
do = "go_to_mark"
mark = "$target"

[[step]]
do = "ask"
text = \"\"\"
Is it
loaded?\"\"\"
answers = { yes = "next", no = "there" }
timeout = 60
default = "no"

[[step]]
do = "repeat"
from = "there"
times = 3
"""


@pytest.mark.parametrize(
    ("right", "wrong", "line", "said"),
    [
        ('mission = 1', 'mission = 2', 1, "found 2; expected mission = 1"),
        ('name = "Round"', 'name = 7', 2, "found 7; expected a text in quotes"),
        ('name = "Round"\n', '', 1, "name: found nothing"),
        ('target = "A1"', 'target = 1979-05-27', 5, "expected a text, a number, true or false"),
        ('battery_below', 'batery_below', 8, "did you mean battery_below?"),
        ('battery_below = 20', 'battery_below = 120', 8, "expected a number from 0 to 100"),
        ('charger = "C1"', '', 7, "battery_below needs charger"),
        ('do = "go_to_mark"', 'do = "goto_mark"', 14, "did you mean go_to_mark?"),
        ('do = "go_to_mark"\n', '', 12, "found nothing; expected one of: go_to_mark"),
        ('mark = "$target"', '', 12, "mark: found nothing; expected the name of a mark"),
        ('mark = "$target"', 'mark = "$taget"', 15, "did you mean target?"),
        ('mark = "$target"', 'mark = 3', 15, "expected the name of a mark"),
        ('text = """', 'tex = """', 19, "did you mean text?"),
        ('no = "there" }', 'no = "ther" }', 22, "found 'ther'; expected one of: next, end, stop, there"),
        ('yes = "next", no = "there"', 'yes = "next"', 22, "two to five answers"),
        ('default = "no"', 'default = "maybe"', 24, "expected one of: yes, no"),
        ('default = "no"', 'default = "no"\ninputs = { maybe = 1 }', 25, "maybe is not known; expected one of: yes, no"),
        ('default = "no"', 'default = "no"\ninputs = { yes = 1.5 }', 25, "a whole number from 0 to 255"),
        ('default = "no"', 'default = "no"\ninputs = { yes = 1, no = 1 }', 25, "another input for each answer"),
        ('default = "no"', '', 17, "timeout and default belong together"),
        ('timeout = 60', 'timeout = true', 23, "expected a number from 0"),
        ('times = 3', 'times = 3.5', 29, "expected a whole number"),
        ('from = "there"', 'from = "here"', 28, "expected one of: next, end, stop, there"),
        ('do = "repeat"', 'do = "repeat"\nname = "there"', 28, "a name that no other step has"),
        ('[[step]]\nname', '[[step]\nname', 12, "not TOML"),
        ('times = 3', 'times = ', 29, "not TOML"),
        ('times = 3', 'times = 3\nwebhook = "http://a"', 30, "webhook is not known"),
    ],
)  # fmt: skip
def test_a_fault_is_named_with_its_line(right: str, wrong: str, line: int, said: str) -> None:
    """The line of the statement, what was found, and what is allowed."""
    assert right in GOOD
    with pytest.raises(MissionError) as caught:
        parse(GOOD.replace(right, wrong, 1), "a.mission.toml")
    assert said in str(caught.value)
    assert caught.value.line == line
    assert str(caught.value).startswith(f"a.mission.toml, line {line}, column ")


def test_a_file_is_read_and_written_in_the_same_form() -> None:
    """What was written is a mission with the same values, and a person can read it."""
    made = parse(GOOD)
    assert made.steps[1].value("answers") == {"yes": "next", "no": "there"}
    assert made.filled({})["target"] == "A1"
    text = text_of(made)
    assert parse(text) == made
    assert '[[step]]\nname = "there"\ndo = "go_to_mark"\nmark = "$target"\n' in text


@settings(max_examples=50, deadline=None)
@given(missions())
def test_writing_undoes_reading(made: Mission) -> None:
    """For any mission."""
    assert parse(text_of(made)) == made


def test_strange_texts_are_written_as_toml() -> None:
    """Quotation marks, line ends, control characters and answers that are no bare keys."""
    text = GOOD.replace('name = "Round"', r'name = "a \"b\" \\ \u007f \n\t é"').replace(
        'yes = "next"', '"ja, gern" = "next"'
    )
    assert parse(text_of(parse(text))) == parse(text)


def test_a_parameter_of_another_type_is_refused_where_it_is_used() -> None:
    """A file with a parameter that does not fit the key is faulty before it starts."""
    with pytest.raises(MissionError, match="mark: found 3") as caught:
        parse(GOOD.replace('target = "A1"', "target = 3"))
    assert caught.value.line == 15


def test_a_long_file_is_refused_in_time() -> None:
    """Neither the size of a file nor the search for a line is without a limit."""
    with pytest.raises(MissionError, match="more than 65536 bytes"):
        parse(GOOD + "#" * 70_000)
    steps = '[[step]]\ndo = "wait"\nseconds = 1\n' * 199
    with pytest.raises(MissionError) as caught:
        parse(f'mission = 1\nname = "long"\n{steps}[[step]]\ndo = "wait"\nseconds = -1\n')
    assert caught.value.line == 2 + 199 * 3 + 3
    with pytest.raises(MissionError, match="expected at most 200"):
        parse(f'mission = 1\nname = "long"\n{steps}{steps}')


def test_the_folder_of_missions_keeps_files_by_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A faulty one is not written, and a name leads nowhere else."""
    monkeypatch.setenv("WOOSH_CONFIG_DIR", str(tmp_path))
    files = MissionFiles()
    assert list(files.list()) == []
    good = parse(GOOD)
    assert files.save("Runde 1", good).file == "Runde 1"
    assert files.path("Runde 1").read_text() == text_of(good)
    files.save("b", good.data())
    with pytest.raises(MissionError):
        files.save("c", {"nonsense": 1})
    for name in ("../c", "a/b", "", ".c", "c\n"):
        with pytest.raises(MissionError, match="expected a name"):
            files.save(name, good)
    (files.files / "d.mission.toml").write_text("nonsense")
    found = {each.file: each.error for each in files.list()}
    assert list(found) == ["Runde 1", "b", "d"]
    assert "not TOML" in found["d"]
    files.remove("b")
    with pytest.raises(MissionError, match="no such file"):
        files.load("b")


@pytest.mark.parametrize("file", sorted((ROOT / "examples/missions").iterdir()), ids=lambda path: path.name)
def test_the_examples_are_missions(file: Path) -> None:
    """They are valid as they are."""
    assert MissionFiles().load(file).steps


@pytest.mark.parametrize("page", ["missions.md", "missions.zh-CN.md"])
def test_the_page_has_every_kind_and_key(page: str) -> None:
    """The tables of the documentation are those of the code."""
    rows = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in (ROOT / "docs" / page).read_text("utf-8").splitlines()
        if line.startswith("| `")
    ]
    told = {name: re.findall(r"`(\w+)`", row[1]) for row in rows for name in re.findall(r"`(\w+)`", row[0])}
    assert {name: sorted(told.get(name, [])) for name in KINDS} == {
        name: sorted(keys) for name, keys in KINDS.items()
    }
    keys = {
        key
        for row in rows
        if row[0].startswith(("`[guards", "`[[step"))
        for key in re.findall(r"`(\w+)`", row[1])
    }
    assert keys >= {*STEP_KEYS, *GUARDS, "do"}
