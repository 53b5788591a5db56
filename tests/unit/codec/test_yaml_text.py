"""Strings are written as PyYAML writes them; what is expected was printed by PyYAML 6.0."""

from __future__ import annotations

import random

import pytest

from rosproto.codec import define, strify_message
from rosproto.codec.text import double_quoted, list_item, quoted

WORDS = "word " * 20


@pytest.mark.parametrize(
    ("text", "written"),
    [
        ("", "''"),
        ("map", '"map"'),
        ('a"b\\c', '"a\\"b\\\\c"'),
        ("a\tb\0\x7f", '"a\\tb\\0\\x7F"'),
        ("é日😀\udcff", '"\\xE9\\u65E5\\U0001F600\\uDCFF"'),
        ("x" * 100, '"' + "x" * 100 + '"'),
        (WORDS, '"' + "word " * 16 + "word\\\n  \\ " + "word " * 2 + 'word "'),
        ("\n" * 45, '"' + "\\n" * 41 + "\\\n  " + "\\n" * 4 + '"'),
    ],
)
def test_fields(text: str, written: str) -> None:
    """Double-quoted; a line ends behind column 80, at a blank or an escape."""
    assert double_quoted(text) == written
    assert quoted(text) == written.replace("\\\n  \\ ", " ").replace("\\\n  ", "")


@pytest.mark.parametrize(
    ("text", "written"),
    [
        ("", "''"),
        ("joint_1", "joint_1"),
        ("it's", "it's"),
        ("a b", "a b"),
        ("-x", "-x"),
        ("a:b", "a:b"),
        ("true", "'true'"),
        ("null", "'null'"),
        ("1", "'1'"),
        ("0x1F", "'0x1F'"),
        ("1e5", "1e5"),
        ("1.0e+5", "'1.0e+5'"),
        ("12:30:45", "'12:30:45'"),
        ("2001-12-14", "'2001-12-14'"),
        ("=", "'='"),
        ("- x", "'- x'"),
        ("a: b", "'a: b'"),
        ("a #b", "'a #b'"),
        ("'a", "'''a'"),
        (" a ", "' a '"),
        (" ", "' '"),
        ("a\nb", "'a\n\n  b'"),
        ("a\n b", '"a\\n b"'),
        ("\tb", '"\\tb"'),
        ("é", '"\\xE9"'),
        (WORDS[:-1], "word " * 15 + "word\n  " + "word " * 3 + "word"),
        (WORDS, "'" + "word " * 15 + "word\n  " + "word " * 3 + "word '"),
    ],
)
def test_elements_of_lists(text: str, written: str) -> None:
    """Plain where that reads back as the same string."""
    assert list_item(text) == written


PIECES = [
    *r"""a true null 1 - -x x: : # it's " \ ... --- ? ! & * % @ ` [ ] { } , | > = << ~ 0x1F 017 1e5 1.5e+3 .5
    12:30:45 2001-12-14 2001-12-14t21:59:43.10-05:00 1_000 .inf .nan yes On hello base_link /a/b + -. _ long_word
    """.split(),
    *["\n", "\t", "é", "日", "😀", "\x85", "\u2028", "\ufeff", " ", "  ", "\x7f", "\0"],
]


@pytest.mark.parametrize("seed", range(4))
def test_whatever_there_is(seed: int) -> None:
    """As PyYAML, character by character."""
    yaml = pytest.importorskip("yaml")
    chance = random.Random(seed)
    for _ in range(400):
        text = chance.choice(["", " "]).join(chance.choices(PIECES, k=chance.choice([1, 1, 2, 3, 5, 30])))
        assert double_quoted(text) == yaml.dump(text, default_style='"').rstrip("\n")
        assert f"- {list_item(text)}" == yaml.dump([text]).rstrip("\n")


def test_lists_of_strings_in_a_message() -> None:
    """Each line is as far in as the list."""
    cls = define("a/Names", "N n\n" + "=" * 80 + "\nMSG: a/N\nstring[] names\nstring long")
    message = cls()
    message.n.names = ["joint_1", "", "a\nb"]
    message.n.long = WORDS
    assert strify_message(message) == (
        "n: \n  names: \n    - joint_1\n    - ''\n    - 'a\n    \n      b'\n"
        '  long: "' + "word " * 16 + "word\\\n  \\ " + "word " * 2 + 'word "'
    )
