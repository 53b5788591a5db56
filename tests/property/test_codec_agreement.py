"""The generated codec agrees with the slow, obvious one, for any definition and any value."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rosproto.codec import decode, decoder, encode, encode_generator, encode_parts, message_class
from rosproto.codec.binding import from_plain, to_plain
from rosproto.codec.decode_generator import decode_function
from rosproto.codec.encode_generator import encode_function
from rosproto.codec.reference import decode_layout, encode_layout
from rosproto.errors import CodecError
from tests.property.codec_strategies import cases, plain_values

COMMON = settings(deadline=None, max_examples=100, suppress_health_check=[HealthCheck.too_slow])
Case = tuple[Any, Any, dict[str, Any]]


def prepared(case: Case) -> tuple[Any, Any, bytes]:
    """The class, its binding and the bytes that are right."""
    library, spec, plain = case
    cls = message_class(spec, library)
    binding = cls._binding
    assert binding is not None
    return cls, binding, encode_layout(binding.layout, plain)


def values_of(message: Any) -> bytes:
    """All values, bit for bit."""
    layout = message._binding.layout
    return encode_layout(layout, to_plain(layout, message))


@COMMON
@given(cases())
def test_encoding_gives_the_bytes_of_the_reference(case: Case) -> None:
    """From arrays, and from lists and bytes; whole, and in parts."""
    _cls, binding, expected = prepared(case)
    message = from_plain(binding, case[2])
    assert encode(message) == expected
    assert b"".join(encode_parts(message)) == expected
    with_lists = from_plain(binding, case[2])
    for field in binding.layout.fields:
        if field.kind == "number" and field.is_array:
            setattr(with_lists, field.name, case[2][field.name])
    assert encode(with_lists) == expected
    assert b"".join(encode_parts(with_lists)) == expected
    rospy = message_class(case[1].name, binding.library, value_style="rospy")
    assert encode(decode(rospy, expected)) == expected


@COMMON
@given(cases())
def test_decoding_gives_the_values_back(case: Case) -> None:
    """From whole buffers of every kind and from slices of larger ones, in both value styles."""
    cls, binding, data = prepared(case)
    assert values_of(decode(cls, data)) == data
    assert values_of(decode(cls, bytearray(data))) == data
    assert values_of(decode(cls, memoryview(data))) == data
    within = b"\xff\xff" + data + b"\xff" * 9
    for buffer in (within, bytearray(within), memoryview(within)):
        assert values_of(decoder(cls)(buffer, 2, 2 + len(data))) == data
    rospy = message_class(case[1].name, binding.library, value_style="rospy")
    assert values_of(decode(rospy, data)) == data
    assert values_of(decoder(rospy)(bytearray(within), 2, 2 + len(data))) == data


@COMMON
@given(cases(), st.data())
def test_messages_after_one_another(case: Case, data: st.DataObject) -> None:
    """What is remembered of one message (sizes, texts) never shows in another."""
    cls, binding, first = prepared(case)
    others = data.draw(st.lists(plain_values(binding.layout), min_size=1, max_size=4))
    all_bytes = [first, *(encode_layout(binding.layout, plain) for plain in others)]
    fast = decoder(cls)
    for _ in range(3):
        right = data.draw(st.sampled_from(all_bytes))
        message = decode(cls, right)
        assert values_of(message) == right == values_of(fast(right, 0, len(right)))
        assert encode(message) == right


@COMMON
@given(cases())
def test_default_values_survive(case: Case) -> None:
    """A message made by its class can be sent, and comes back equal."""
    cls, _, _ = prepared(case)
    message = cls()
    assert decode(cls, encode(message)) == message


@COMMON
@given(cases())
def test_every_truncation_is_an_error(case: Case) -> None:
    """Missing and left-over bytes raise CodecError, with the type and an offset."""
    cls, _binding, data = prepared(case)
    for bad in [data[:end] for end in range(len(data))] + [data + b"\0", data + data[:1] + b"\0"]:
        with pytest.raises(CodecError) as caught:
            decode(cls, bad)
        assert caught.value.type_name == case[1].name
        assert caught.value.offset is not None
        with pytest.raises(CodecError):
            decoder(cls)(data + data, 0, len(bad) if len(bad) < len(data) else len(data) + 1)


@COMMON
@given(cases(), st.data())
def test_changed_bytes_give_the_same_as_the_reference(case: Case, data: st.DataObject) -> None:
    """Both decode the same values, or both refuse."""
    cls, binding, right = prepared(case)
    wrong = bytearray(right)
    for _ in range(data.draw(st.integers(1, 4))):
        if wrong:
            wrong[data.draw(st.integers(0, len(wrong) - 1))] = data.draw(
                st.sampled_from([0, 1, 2, 5, 127, 255])
            )
    try:
        expected: Any = encode_layout(binding.layout, decode_layout(binding.layout, wrong, 0, len(wrong)))
    except CodecError:
        expected = CodecError
    try:
        found: Any = values_of(decode(cls, bytes(wrong)))
    except CodecError:
        found = CodecError
    assert found == expected


@COMMON
@given(cases())
def test_the_fast_way_needs_no_help(case: Case) -> None:
    """Ordinary values never reach the reference codec that hides behind the generated one."""
    _cls, binding, data = prepared(case)
    if binding.layout.sparse:
        return

    def refuse(*args: Any) -> Any:
        raise AssertionError(f"fast path failed: {args[-1]!r}") from args[-1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(encode_generator, "FOURS_FROM", 2)  # arrays drawn here are short
        in_fours_encode = encode_function(binding.layout, binding.value_style, fail=refuse)
    general_decode = decode_function(
        binding.layout, binding.value_style, binding.maker, general=True, fail=refuse
    )
    general_encode = encode_function(binding.layout, binding.value_style, general=True, fail=refuse)
    message = general_decode(data, 0, len(data))
    assert general_encode(message) == data
    if "\\udc" in ascii(case[2]):
        return  # text that is not UTF-8 is what the general code is for
    fast_decode = decode_function(binding.layout, binding.value_style, binding.maker, fail=refuse)
    fast_encode = encode_function(binding.layout, binding.value_style, fail=refuse)
    assert fast_encode(fast_decode(data, 0, len(data))) == data
    assert in_fours_encode(fast_decode(data, 0, len(data))) == data
