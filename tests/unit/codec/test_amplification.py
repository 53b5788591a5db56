"""Elements that cost their sender nothing do not fill the memory of whoever decodes them."""

from __future__ import annotations

import struct

import pytest

from rosproto.codec import Message, decode, define
from rosproto.codec.layout import resolve
from rosproto.errors import CodecError
from rosproto.msg import bundled
from tests.support.memory import peak_of

pytestmark = pytest.mark.whole

SEPARATOR = "\n" + "=" * 80 + "\nMSG: a/E\n"
ELEMENTS = {
    "nothing": "",
    "a byte in an array": "uint8[1] x",
    "arrays of no length": "uint8 a\nfloat32[0] b\nfloat32[0] c",
    "many that are empty": "uint8 a\n" + "\n".join(f"N n{i}" for i in range(15)),
    "one byte": "uint8 a",
    "an empty text": "string s",
    "an empty array": "float32[] f",
    "a time": "time t",
}


def outcome(cls: type[Message], data: bytes) -> str:
    """Why it was refused; empty when it was decoded."""
    try:
        decode(cls, data)
    except CodecError as error:
        return str(error)
    return ""


@pytest.mark.promise("is decoded within about 150 times")
@pytest.mark.parametrize("value_style", ["numpy", "rospy"])
@pytest.mark.parametrize("element", ELEMENTS.values(), ids=ELEMENTS.keys())
@pytest.mark.parametrize("padding", [0, 200_000])
def test_a_message_takes_a_bounded_multiple_of_its_bytes(
    element: str, padding: int, value_style: str
) -> None:
    """Either it decodes within 150 bytes of memory for each of its own, or it is refused within them."""
    text = "E[] e\nuint8[] pad" + SEPARATOR + element + SEPARATOR.replace("a/E", "a/N")
    cls = define("a/Light", text, value_style=value_style)
    layout = resolve(cls._binding.library.message("a/E"), cls._binding.library)  # type: ignore[union-attr]
    count = 50_000 if layout.min_size < 4 else 20_000
    for number in (count, 200):  # first the many, then a few that pass
        data = struct.pack("<I", number) + bytes(number * layout.min_size) + struct.pack("<I", padding)
        data += bytes(padding)
        peak = peak_of(lambda data=data: outcome(cls, data))  # type: ignore[misc]
        refused = outcome(cls, data)
        assert not refused or ("are refused" in refused and number == count), "a few are always possible"
        assert peak < 2_000_000 + 150 * len(data)


@pytest.mark.promise("the bundled definitions stay far below that")
def test_no_bundled_message_is_near_the_limit() -> None:
    """What robots really send is decoded the quick way: no array of it has elements that count as light."""
    library = bundled()
    names = [
        name if "/" in name else f"{p}/{name}" for p in library.packages() for name in library.messages(p)
    ]
    layouts = [resolve(library.message(name), library) for name in names]
    assert len(layouts) > 300
    assert not [layout.spec.name for layout in layouts if layout.sparse]
    nested = {f.layout for layout in layouts for f in layout.fields if f.is_array and f.layout is not None}
    assert max(element.weight / element.min_size for element in nested) < 70
