"""The reference codec: slow and simple, one field after the other, as in wiki.ros.org/msg.

Tests compare the generated code with it. If generated code fails, this codec makes the error, with the path
of the field and the offset. Values are plain: a message is a dict by field name, an array a list, uint8[] and
char[] bytes, time and duration a (secs, nsecs) pair, a string a str (bytes that are not UTF-8 as surrogates).
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Any, NoReturn

from rosproto.codec.layout import RANGES_BY_CODE, FieldLayout, Layout
from rosproto.errors import CodecError

if TYPE_CHECKING:
    from typing_extensions import Buffer

LIGHT_SPARE = 1 << 18
LIGHT_PER_BYTE = 16
"""Maximum memory of elements of (nearly) no bytes in one message: LIGHT_SPARE bytes, plus LIGHT_PER_BYTE for
each byte of the message. (This codec, which decodes them, temporarily takes four times as much.)
"""


def decode_layout(layout: Layout, data: Buffer, start: int, end: int) -> dict[str, object]:
    """Decode exactly the bytes `data[start:end]`.

    Raises:
        CodecError: Bytes and definition disagree.
    """
    reader = _Reader(layout.spec.name, data, start, end)
    value = reader.message(layout, "")
    if reader.position != end:
        reader.fail(
            "",
            f"{end - reader.position} bytes are left after the last field at byte {reader.position - start}; "
            "the definition differs or the stream is out of sync",
        )
    return value


class _Reader:
    def __init__(self, type_name: str, data: Buffer, start: int, end: int) -> None:
        self.type_name = type_name
        self.data = memoryview(data)
        self.start = start
        self.position = start
        self.end = min(end, len(self.data))
        # A short message may have many elements of (nearly) no bytes: limit their memory.
        self.free_bytes = LIGHT_SPARE + LIGHT_PER_BYTE * (end - start)

    def fail(self, path: str, text: str) -> NoReturn:
        raise CodecError(text, type_name=self.type_name, field_path=path, offset=self.position - self.start)

    def take(self, size: int, path: str, what: str) -> memoryview:
        left = self.end - self.position
        if size > left:
            self.fail(
                path,
                f"{what} at byte {self.position - self.start}, but {left} bytes are left; "
                "the definition differs or the stream is out of sync",
            )
        taken = self.data[self.position : self.position + size]
        self.position += size
        return taken

    def count(self, path: str) -> int:
        (count,) = struct.unpack("<I", self.take(4, path, "a length of 4 bytes"))
        return int(count)

    def message(self, layout: Layout, prefix: str) -> dict[str, object]:
        return {field.name: self.field(field, prefix + field.name) for field in layout.fields}

    def field(self, field: FieldLayout, path: str) -> object:
        if not field.is_array:
            return self.one(field, path)
        if field.length is not None:
            count = field.length
        else:
            count = self.count(path)
            if count * field.size > self.end - self.position:
                self.position -= 4
                at, left = self.position - self.start, self.end - self.position - 4
                self.fail(
                    path,
                    f"length {count} at byte {at}, but {left} bytes are left; "
                    "the definition differs or the stream is out of sync",
                )
        if field.kind == "number":
            return self.numbers(field, count, path)
        self.spend(field, count, path)
        return [self.one(field, f"{path}[{index}]") for index in range(count)]

    def spend(self, field: FieldLayout, count: int, path: str) -> None:
        """Limit the memory of elements that take far more memory than bytes."""
        if field.layout is None or not field.layout.is_light:
            return
        self.free_bytes -= count * field.layout.weight
        if self.free_bytes < 0:
            self.fail(path, f"{count} elements of {field.base} that take (nearly) no bytes are refused")

    def numbers(self, field: FieldLayout, count: int, path: str) -> bytes | list[float]:
        taken = self.take(count * field.size, path, f"{count} elements of {field.base}")
        if field.code == "B":
            return bytes(taken)
        return list(struct.unpack(f"<{count}{field.code}", taken))

    def one(self, field: FieldLayout, path: str) -> object:
        if field.layout is not None:
            return self.message(field.layout, path + ".")
        if field.kind == "string":
            size = self.count(path)
            return bytes(self.take(size, path, f"a string of {size} bytes")).decode(
                "utf-8", "surrogateescape"
            )
        if field.kind == "time":
            return struct.unpack("<" + field.code, self.take(8, path, f"{field.base}, 8 bytes,"))
        return struct.unpack("<" + field.code, self.take(field.size, path, f"{field.base}"))[0]


def encode_layout(layout: Layout, value: object) -> bytes:
    """Encode a dict of fields.

    Raises:
        CodecError: A value does not fit its field.
    """
    parts: list[bytes] = []
    _Writer(layout.spec.name, parts).message(layout, value, "")
    return b"".join(parts)


class _Writer:
    def __init__(self, type_name: str, parts: list[bytes]) -> None:
        self.type_name = type_name
        self.parts = parts

    def fail(self, path: str, text: str) -> NoReturn:
        raise CodecError(text, type_name=self.type_name, field_path=path)

    def message(self, layout: Layout, value: object, prefix: str) -> None:
        if not isinstance(value, dict):
            self.fail(prefix.rstrip("."), f"a {layout.spec.name} is expected, not {_shown(value)}")
        for field in layout.fields:
            path = prefix + field.name
            if field.name not in value:
                self.fail(path, "has no value; give one, or create the message by its class")
            self.field(field, value[field.name], path)

    def field(self, field: FieldLayout, value: object, path: str) -> None:
        if not field.is_array:
            self.one(field, value, path)
            return
        if isinstance(value, (bytes, bytearray)):
            if field.code != "B":
                self.fail(path, f"a sequence is expected for {field.type_text}, not {_shown(value)}")
        elif not isinstance(value, (list, tuple)):
            self.fail(path, f"a sequence is expected for {field.type_text}, not {_shown(value)}")
        if field.length is None:
            if len(value) >= 1 << 32:
                self.fail(path, f"{len(value)} elements, at most 4294967295 fit")
            self.parts.append(struct.pack("<I", len(value)))
        elif len(value) != field.length:
            self.fail(path, f"{field.length} elements expected, not {len(value)}")
        if isinstance(value, (bytes, bytearray)):
            self.parts.append(bytes(value))
            return
        for index, item in enumerate(value):
            self.one(field, item, f"{path}[{index}]")

    def one(self, field: FieldLayout, value: object, path: str) -> None:
        if field.layout is not None:
            self.message(field.layout, value, path + ".")
        elif field.kind == "string":
            self.string(value, path)
        elif field.kind == "time":
            self.time(field, value, path)
        elif field.code in RANGES_BY_CODE:
            self.integer(field.base, field.code, value, path)
        else:
            self.real(field.base, field.code, value, path)

    def string(self, value: object, path: str) -> None:
        if isinstance(value, str):
            try:
                value = value.encode("utf-8", "surrogateescape")
            except UnicodeEncodeError as error:
                self.fail(path, f"{error.reason}: {value[error.start : error.end]!r} at {error.start}")
        if not isinstance(value, (bytes, bytearray)):
            self.fail(path, f"str expected, not {_shown(value)}")
        self.parts.append(struct.pack("<I", len(value)) + bytes(value))

    def time(self, field: FieldLayout, value: object, path: str) -> None:
        if not (isinstance(value, tuple) and len(value) == 2):
            name = field.base.capitalize()
            self.fail(
                path, f"a {name} is expected, not {_shown(value)}; {name}.from_sec(...) makes one of seconds"
            )
        for part, name, code in zip(value, ("secs", "nsecs"), field.code, strict=True):
            self.integer(field.base, code, part, f"{path}.{name}")

    def integer(self, base: str, code: str, value: Any, path: str) -> None:
        low, high = RANGES_BY_CODE[code]
        try:
            number = value.__index__()
        except (AttributeError, TypeError):
            self.fail(path, f"{base} expected ({_range_text(base, low, high)}), not {_shown(value)}")
        if not low <= number <= high:
            self.fail(path, f"{value} is out of range for {base} ({_range_text(base, low, high)})")
        self.parts.append(struct.pack("<" + ("B" if code == "?" else code), number))

    def real(self, base: str, code: str, value: object, path: str) -> None:
        if isinstance(value, (str, bytes)) or not (
            hasattr(value, "__float__") or hasattr(value, "__index__")
        ):
            self.fail(path, f"{base} expected, not {_shown(value)}")
        try:
            self.parts.append(struct.pack("<" + code, value))
        except (OverflowError, struct.error, TypeError, ValueError):
            most = "3.4028235e38" if code == "f" else "1.7976931348623157e308"
            self.fail(path, f"{_shown(value)} is out of range for {base} (up to {most} in magnitude)")


def _range_text(base: str, low: int, high: int) -> str:
    return "True or False" if base == "bool" else f"{low}..{high}"


def _shown(value: object) -> str:
    text = repr(value) if isinstance(value, (str, bytes, int, float, bool, type(None))) else ""
    return f"{type(value).__name__} {text[:60]}".rstrip() if value is not None else "None"
