"""While rooms move to `Sentence` one by one, a row is found by its template as by the text it makes."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rosproto.sentence import say
from woosh_pure.language.table import Row, read_table, words_for

ROOT = Path(__file__).resolve().parents[3]
PLACE = re.compile(r"\{(\w+)[+=]?\}")
ROWS = [
    row
    for path in sorted((ROOT / "woosh_pure/language/zh").glob("*.txt"))
    for row in read_table(path.read_text("utf-8"), path.name)
    if PLACE.search(row.english)
]


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.english[:60])
def test_a_row_is_found_by_its_template(row: Row) -> None:
    """With values that no pattern can take for words."""
    names = PLACE.findall(row.english)
    values = {name: f"/x{number}" for number, name in enumerate(names)}
    sentence = say(PLACE.sub(r"{\1}", row.english), **values)
    said = words_for("zh").say(sentence)
    assert said == PLACE.sub(lambda place: values[place[1]], row.translated)


def test_every_row_says_the_same_by_its_text() -> None:
    words, differ = words_for("zh"), []
    for row in ROWS:
        names = PLACE.findall(row.english)
        values = {name: f"/x{number}" for number, name in enumerate(names)}
        sentence = say(PLACE.sub(r"{\1}", row.english), **values)
        if words.say(sentence) != words.say("".join(sentence)):
            differ.append(row.english)
    assert differ == []
