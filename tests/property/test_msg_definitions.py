"""Definitions drawn at random: what is written is read, sums follow the content, junk is a DefinitionError."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosproto.errors import DefinitionError
from rosproto.msg import (
    BUILTIN_TYPES,
    DefinitionLibrary,
    Field,
    FieldType,
    bundled,
    library_from_full_text,
    parse_action,
    parse_message,
    parse_service,
    split_full_text,
)

base_names = st.from_regex(r"[A-Za-z][A-Za-z0-9_]{0,8}", fullmatch=True)
builtins = st.sampled_from(sorted(BUILTIN_TYPES))
comments = st.sampled_from(["", " # words", "# a = b", "   ", "\r"])


@st.composite
def field_types(draw: st.DrawFn, bases: st.SearchStrategy[str]) -> FieldType:
    base = draw(bases)
    if draw(st.booleans()):
        return FieldType(base)
    return FieldType(base, True, draw(st.none() | st.integers(0, 9)))


@st.composite
def field_lists(draw: st.DrawFn, bases: st.SearchStrategy[str] = builtins) -> list[Field]:
    names = draw(st.lists(base_names, max_size=6, unique=True))
    return [Field(name, draw(field_types(bases))) for name in names]


@st.composite
def libraries(draw: st.DrawFn) -> dict[str, list[Field]]:
    """A few types, each using only those after it."""
    names = draw(st.lists(base_names.map("p/".__add__), min_size=1, max_size=5, unique=True))
    types: dict[str, list[Field]] = {}
    for name in reversed(names):
        bases = st.one_of(builtins, st.sampled_from(sorted(types))) if types else builtins
        types[name] = draw(field_lists(bases))
    return types


def text_of(fields: list[Field], comment: str = "") -> str:
    return "".join(f"{field.type} {field.name}{comment}\n" for field in fields)


@given(field_lists(), comments)
def test_fields_are_read_as_they_were_written(fields: list[Field], comment: str) -> None:
    """Comments and line ends change neither fields nor the md5sum."""
    spec = parse_message(text_of(fields, comment), "p/T")
    assert list(spec.fields) == fields
    plain, commented = DefinitionLibrary(), DefinitionLibrary()
    plain.add(parse_message(text_of(fields), "p/T"))
    commented.add(spec)
    assert plain.md5sum("p/T") == commented.md5sum("p/T")


@pytest.mark.whole
@given(libraries())
def test_a_full_text_carries_everything(types: dict[str, list[Field]]) -> None:
    """A receiver who knows nothing gets the same fields, md5sum and text."""
    library = DefinitionLibrary()
    for name, fields in types.items():
        library.add(parse_message(text_of(fields), name))
    for name in types:
        text = library.full_text(name)
        learned = library_from_full_text(name, text)
        assert learned.message(name).fields == library.message(name).fields
        assert learned.md5sum(name) == library.md5sum(name)
        assert learned.full_text(name) == text
        assert learned.dependencies(name) == library.dependencies(name)
        assert set(split_full_text(text, name)) == {name, *library.dependencies(name)}


@pytest.mark.slow
@pytest.mark.whole
@given(libraries(), st.data())
def test_the_md5sum_follows_the_names_of_fields_at_any_depth(
    types: dict[str, list[Field]], data: st.DataObject
) -> None:
    """Renaming one field changes the sum of all types that use it, and of no other."""
    changed = data.draw(st.sampled_from(sorted(types)))
    before, after = DefinitionLibrary(), DefinitionLibrary()
    for name, fields in types.items():
        before.add(parse_message(text_of(fields), name))
        renamed = [Field(f.name + "Z1234567890", f.type) for f in fields] if name == changed else fields
        after.add(parse_message(text_of(renamed), name))
    for name in types:
        uses = types[changed] and (name == changed or changed in before.dependencies(name))
        assert (before.md5sum(name) != after.md5sum(name)) == bool(uses)


WORDS = (
    "int8 string U p/U Header = # [] [3] [99999999] a b A 1 \t \r --- MSG:p/U MSG: \x00 \xff \udcff".split(
        " "
    )
)
SEPARATORS = [" ", "\n", "\n", "=" * 80, "\n" + "=" * 80 + "\nMSG: p/U\n"]
junk = st.lists(st.sampled_from(WORDS + SEPARATORS), max_size=30).map("".join)


@given(junk | st.text())
def test_any_text_is_a_definition_or_a_definition_error(text: str) -> None:
    """Nothing else comes out of a stranger's text, and an accepted one can be used."""
    for call in (parse_message, parse_service, parse_action):
        try:
            call(text, "p/T")
        except DefinitionError:
            pass
    try:
        library = library_from_full_text("p/T", text)
    except DefinitionError:
        return
    assert len(library.md5sum("p/T")) == 32
    for name in library.messages("p"):
        spec = library.message(name)
        assert all(
            part.name.isidentifier() and part.name.isascii() for part in (*spec.fields, *spec.constants)
        )


@given(st.text() | base_names.map("std_msgs/".__add__))
def test_any_name_is_found_or_a_definition_error(name: str) -> None:
    """Names come from the wire too."""
    for ask in (bundled().message, bundled().service, bundled().action):
        try:
            ask(name)
        except DefinitionError:
            pass
