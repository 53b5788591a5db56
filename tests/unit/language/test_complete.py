"""Every sentence that the commands an owner types can print has its Chinese form; what is missing is listed.

To mend it, add a sentence and its translation to a file in woosh_pure/language/zh: the failure prints rows to fill
in, as `python -m tools.templates` does. What no person sees goes into its `NOT_FOR_PEOPLE`.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tools import templates
from tools.templates import NOT_FOR_PEOPLE, OWNERS, ROOT, TABLES, english_left, said_in
from woosh_pure.language.table import read_table

_FILLED = re.compile("%[a-z]")
pytestmark = pytest.mark.structure


def test_every_sentence_has_its_chinese_form() -> None:
    """An f-string has no template, so that nobody can look it up."""
    rows = [f"# {where} ({said.made})\n{said.template}\n" for where, said in templates.missing()]
    assert not rows, f"{len(rows)} sentences have no translation:\n\n" + "\n".join(rows)


def test_the_sources_are_read() -> None:
    """A check that finds nothing checks nothing."""
    all_said = [said for name in OWNERS for said in said_in(ROOT / name)]
    assert len(all_said) > 300
    assert {said.made for said in all_said} >= {"say", "text"}
    assert set(NOT_FOR_PEOPLE) <= {said.template for said in all_said}


@pytest.mark.slow
def test_what_has_no_chinese_is_listed(capsys: pytest.CaptureFixture[str]) -> None:
    """Shown in English; the number is for whoever reads the log of the check."""
    assert templates.main(["--check"]) == 0
    said = capsys.readouterr().out
    assert re.search(r"without Chinese: 0 of what owners see, \d+ others; rows unused: 0\n", said)
    print(said)


def test_a_name_has_one_format_in_a_sentence() -> None:
    """A translation could not say which."""
    assert templates.mixed() == []


def test_a_new_sentence_is_missed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = tmp_path / "room.py"
    source.write_text(
        '"""Words of a docstring are not a sentence."""\n'
        "def fail(name, out):\n"
        '    out.line("nobody has ever said this")\n'
        '    out.line(f"and {name} has never said that")\n'
        '    raise ValueError(say("{name} is new", name=name))\n'
    )
    monkeypatch.setattr(templates, "ROOT", tmp_path)
    monkeypatch.setattr(templates, "OWNERS", ["room.py"])
    assert [(where, said.template, said.made) for where, said in templates.missing()] == [
        ("room.py:3", "nobody has ever said this", "text"),
        ("room.py:4", "and {} has never said that", "f-string"),
        ("room.py:5", "{name} is new", "say"),
    ]


def test_every_row_is_said_by_somebody() -> None:
    """A row for what was reworded would be a translation that nobody sees any more."""
    assert templates.unsaid() == []


@pytest.mark.parametrize("path", TABLES, ids=lambda path: path.name)
def test_a_table_can_be_read_and_its_places_agree(path: Path) -> None:
    """Raises where a sentence has no translation, or another set of places."""
    rows = list(read_table(path.read_text("utf-8"), path.name))
    assert len(rows) > 10
    for row in rows:
        chinese = re.sub(r"\{\w+\}|`[^`]*`|[\w./:=()\[\]%°-]+", "", row.translated, flags=re.ASCII)
        assert _FILLED.findall(row.english) == _FILLED.findall(row.translated), row  # a line of the log
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
