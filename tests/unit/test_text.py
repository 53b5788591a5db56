"""Foreign text is escaped for a terminal."""

from __future__ import annotations

import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosproto.text import cut, near_names, padded, printable, short, width, wrapped


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("/scan", "/scan"),
        ("到达 A1　°µ→é", "到达 A1　°µ→é"),
        ("\x1b]0;owned\x07", r"\x1b]0;owned\x07"),
        ("\x9b31m", r"\x9b31m"),
        ("a\r\nready: yes", r"a\r\nready: yes"),
        ("abc\u202ecba\u2066", r"abc\u202ecba\u2066"),
        ("a\u200bb\u2028c\ufeff\u00ad", r"a\u200bb\u2028c\ufeff\xad"),
        ("\U000e0041", r"\U000e0041"),
        ("\udc80", r"\udc80"),
        ("a\tb\x7f", r"a\tb\x7f"),
    ],
)
def test_what_acts_or_hides_is_escaped(text: str, shown: str) -> None:
    """ESC, BEL, C1, line ends, directions, zero widths, tags, lone surrogates; letters of all languages stay."""
    assert printable(text) == shown


def test_what_is_kept_is_kept() -> None:
    """A table has lines and tabs; nothing else gets through with them."""
    assert printable("a\n\tb\r\x1b", keep="\n\t") == "a\n\tb\\r\\x1b"


@given(st.text(st.characters(exclude_categories=())))
def test_no_control_character_is_left(text: str) -> None:
    """Of any text: no controls, formats, surrogates, line or paragraph separators."""
    assert not {unicodedata.category(c) for c in printable(text)} & {"Cc", "Cf", "Cs", "Zl", "Zp", "Co", "Cn"}
    assert printable(printable(text)) == printable(text)


def test_chinese_takes_two_columns() -> None:
    """Tables stand straight, and lines end before the edge, without half a character."""
    assert [width(text) for text in ("A1", "仓库", "e\u0301", "")] == [2, 4, 1, 0]
    assert padded("仓库", 6) == "仓库  "
    assert padded("long", 2) == "long"
    assert [cut("仓库1", columns) for columns in (5, 4, 3, 0)] == ["仓库1", "仓库", "仓", ""]
    assert cut("abc", -1) == ""


def test_a_chinese_text_is_broken_between_characters_but_not_before_punctuation() -> None:
    """A word stays whole; a bracket stays with what it opens."""
    assert wrapped("标记点（默认 A1），其次", 8) == ["标记点", "（默认", "A1），其", "次"]
    assert wrapped("仓库。前往 /map_server。", 6) == ["仓库。", "前往", "/map_server。"]
    assert wrapped("two words", 5) == ["two", "words"]
    assert wrapped("", 5) == [""]


def test_a_short_text_stays_and_a_long_one_says_that_it_was_cut() -> None:
    """The limit holds for the text with its dots."""
    assert short("x" * 60) == "x" * 60
    assert short("x" * 61) == "x" * 57 + "..."
    assert short("abcdef", 5) == "ab..."


def test_near_names_are_found_whatever_their_case_the_best_first() -> None:
    assert near_names("KITCHN", ["kitchen", "hall", "Kitchenette"]) == ["kitchen", "Kitchenette"]
    assert near_names("b9", ["B1", "A1"]) == []
    assert near_names("b9", ["B1", "A1"], cutoff=0.4) == ["B1"]
