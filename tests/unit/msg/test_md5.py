"""md5sums are those of genmsg: the rules one by one, then every type that is known from elsewhere."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosproto.msg import DefinitionLibrary, bundled, parse_message, parse_service
from rosproto.msg.spec import md5_text, md5sum_of_texts


def md5sum(text: str, **used: str) -> str:
    library = DefinitionLibrary()
    for name, body in used.items():
        library.add(parse_message(body, f"p/{name}"))
    library.add(parse_message(text, "p/T"))
    return library.md5sum("p/T")


def hashed(text: str) -> str:
    return md5_text(parse_message(text, "p/T"), lambda name: f"<{name}>")


def test_the_empty_message() -> None:
    """d41d8cd9... is md5 of nothing."""
    assert md5sum("") == md5sum("# words\n\n") == "d41d8cd98f00b204e9800998ecf8427e"


@pytest.mark.promise("Constants come first, fields after them")
def test_constants_come_first_in_file_order() -> None:
    """Also when they are written after fields (wire.md, fact 39)."""
    assert hashed("int8 a\nint8 X=1\nint8 b\nint8 A=2\n") == "int8 X=1\nint8 A=2\nint8 a\nint8 b"


def test_comments_white_space_and_line_ends_do_not_matter() -> None:
    """Pitfall 46."""
    assert md5sum("int8  a   # b\r\n\r\n  int16 c") == md5sum("int8 a\nint16 c\n")


@pytest.mark.promise("Constants come first, fields after them")
def test_message_types_lose_their_array_suffix_and_builtin_types_keep_it() -> None:
    """`U[] u`, `U[3] u` and `U u` hash alike (wire.md, fact 39)."""
    sums = {md5sum(f"U{array} u", U="int8 a") for array in ("", "[]", "[3]", "[4]")}
    assert len(sums) == 1
    assert len({md5sum(f"int8{array} u") for array in ("", "[]", "[3]", "[4]", "[04]")}) == 5


def test_a_used_type_counts_by_its_md5sum() -> None:
    """Its package and name do not matter, its content does."""
    assert md5sum("U u", U="int8 a") == md5sum("V u", V="int8 a # same")
    assert md5sum("U u", U="int8 a") != md5sum("U u", U="int8 b")
    assert md5sum("U u", U="int8 a") == md5sum_of_texts(f"{md5sum('int8 a')} u")


@pytest.mark.promise("A text constant is everything behind the first")
def test_string_constants_keep_everything_behind_the_equals_sign() -> None:
    """The sum is genmsg's own (wire.md, fact 40)."""
    assert md5sum("string FOO=a # b") == "dbd5b370e0d325b714367f7037b8f8ec"
    assert hashed("string FOO=#abc  ") == "string FOO=#abc"
    assert hashed("string FOO=") == "string FOO="


@pytest.mark.promise("A text constant is everything behind the first")
def test_other_constants_keep_their_literal() -> None:
    """`True` is not `1`, `1.50` is not `1.5` (wire.md, fact 40)."""
    assert md5sum("bool B=True") != md5sum("bool B=1")
    assert md5sum("float32 X=1.50") != md5sum("float32 X=1.5")
    assert hashed("float32  X =  1.50  # half") == "float32 X=1.50"


def test_aliases_keep_their_name() -> None:
    """`byte b` is not `int8 b` though it is the same on the wire."""
    assert len({md5sum(f"{kind} b") for kind in ("byte", "int8", "char", "uint8")}) == 4


@pytest.mark.promise("A service's md5sum is that of both texts")
def test_a_service_hashes_request_and_response_without_a_separator() -> None:
    """Pitfall 52; std_srvs/SetBool is known from everywhere."""
    library = DefinitionLibrary()
    library.add(parse_service("bool data\n---\nbool success\nstring message", "x/Y"))
    assert library.md5sum("x/Y") == "09fb03525b03e7ea1fd3992bafd87e16"
    assert library.md5sum("x/Y") == md5sum_of_texts("bool data" + "bool success\nstring message")


def test_bytes_that_are_no_utf8_are_hashed_as_they_are() -> None:
    """A string constant may hold them."""
    assert md5sum_of_texts("string S=\udcff") == md5sum("string S=\udcff")


KNOWN = [
    line.split()
    for line in (Path(__file__).parent / "md5sums.txt").read_text().splitlines()
    if line and line[0] != "#"
]


def test_every_known_md5sum_is_ours() -> None:
    """All messages, services, requests and responses, and the seven messages of each action."""
    wrong = [
        f"{kind} {name}: {bundled().md5sum(name, kind=kind)}, expected {md5}"
        for kind, name, md5 in KNOWN
        if kind != "revision" and bundled().md5sum(name, kind=kind) != md5
    ]
    assert not wrong
    assert len(KNOWN) > 490


def test_every_bundled_type_is_known_from_elsewhere() -> None:
    """Nothing ships whose md5sum nobody has confirmed."""
    library = bundled()
    known = {(kind, name) for kind, name, _ in KNOWN}
    for package in library.packages():
        for name in library.messages(package):
            assert ("msg", name) in known
        for name in library.services(package):
            assert ("srv", name) in known


@pytest.mark.parametrize(("name", "md5"), [(name, md5) for kind, name, md5 in KNOWN if kind == "revision"])
def test_every_known_revision_is_found_by_its_md5sum(name: str, md5: str) -> None:
    """Once, with a note, and its library says the same of itself."""
    (revision,) = [found for found in bundled().revisions(name) if found.md5sum == md5]
    assert revision.library.md5sum(name) == md5
    assert revision.note
    assert revision.label
