"""Check the codec: it must produce the same bytes as the slow reference codec, for every message."""

from __future__ import annotations

import random
import struct
from typing import Any

from rosproto.codec.layout import FieldLayout, Layout
from rosproto.selftest.checking import CheckFailed
from rosproto.sentence import say

_TEXTS = ("", "map", "底盘", "a longer text, of more than sixteen bytes")


def check_codec() -> str:
    """Encode by the reference, decode and encode by the generated code, and compare."""
    from rosproto.codec import decode, encode, message_class
    from rosproto.codec.layout import resolve
    from rosproto.codec.reference import decode_layout, encode_layout
    from rosproto.msg import bundled

    library = bundled()
    values = random.Random(1)
    count = size = 0
    for package in library.packages():
        for name in library.messages(package):
            layout = resolve(library.message(name), library)
            data = encode_layout(layout, sample(layout, values))
            again = encode(decode(message_class(name), data))
            if again != data:
                at = next(
                    (i for i, pair in enumerate(zip(data, again, strict=False)) if pair[0] != pair[1]), 0
                )
                raise CheckFailed(
                    say(
                        "{name}: the codecs differ, first at byte {at} of {size}",
                        name=name,
                        at=at,
                        size=len(data),
                    )
                )
            if encode_layout(layout, decode_layout(layout, again, 0, len(again))) != data:
                raise CheckFailed(say("{name}: the reference codec does not read what it wrote", name=name))
            count, size = count + 1, size + len(data)
    return say(
        "{count} message types, {size} bytes, as the reference codec writes them", count=count, size=size
    )


def sample(layout: Layout, values: random.Random) -> dict[str, Any]:
    """Random values for a message, in the form that the reference codec takes."""
    return {field.name: _field(field, values) for field in layout.fields}


def _field(field: FieldLayout, values: random.Random) -> Any:
    if not field.is_array:
        return _one(field, values)
    length = values.randrange(4) if field.length is None else field.length
    if field.code == "B":
        return values.randbytes(length)
    return [_one(field, values) for _ in range(length)]


def _one(field: FieldLayout, values: random.Random) -> Any:
    from rosproto.codec.layout import RANGES_BY_CODE

    if field.layout is not None:
        return sample(field.layout, values)
    if field.kind == "string":
        return values.choice(_TEXTS)
    if field.kind == "time":
        return values.randint(*RANGES_BY_CODE[field.code[0]]), values.randrange(1_000_000_000)
    if field.code == "?":
        return values.random() < 0.5
    if field.code in RANGES_BY_CODE:
        return values.randint(*RANGES_BY_CODE[field.code])
    number = values.uniform(-1e9, 1e9)
    return struct.unpack("<f", struct.pack("<f", number))[0] if field.code == "f" else number
