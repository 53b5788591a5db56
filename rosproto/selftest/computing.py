"""Checks of what needs no network: definitions, the codec, bags.

`md5sums.txt` has a line for each package and kind, and in it each type with the first eight digits, which are
enough to find an accidental change. tests/interop/test_genmsg.py compares it with genmsg itself.
"""

from __future__ import annotations

import random
import struct
import tempfile
from collections.abc import Iterator
from importlib import resources
from pathlib import Path
from typing import Any

from rosproto.codec.layout import FieldLayout, Layout
from rosproto.errors import DefinitionError
from rosproto.selftest.checking import CheckFailed, expect
from rosproto.sentence import say


def known_md5sums() -> Iterator[tuple[str, str, str]]:
    """Yield (first digits of the md5sum, kind, name) of every message and service; kind is "msg" or "srv"."""
    table = resources.files(__package__).joinpath("md5sums.txt").read_text(encoding="ascii")
    for line in table.splitlines():
        package, kind, *types = line.split()
        for name, _, digits in (entry.partition("=") for entry in types):
            yield digits, kind, f"{package}/{name}"


def check_definitions() -> str:
    """Check each type of the table, and that no other types are bundled."""
    from rosproto.msg import bundled

    library = bundled()
    known = {(kind, name) for _, kind, name in known_md5sums()}
    there = {("msg", name) for package in library.packages() for name in library.messages(package)}
    there |= {("srv", name) for package in library.packages() for name in library.services(package)}
    wrong: list[str] = [
        say("{name} is not known to this check", name=name) for _, name in sorted(there - known)
    ]
    for digits, kind, name in known_md5sums():
        try:
            found = library.md5sum(name, kind=kind)
        except DefinitionError as error:
            wrong.append(str(error))
            continue
        if found[:8] != digits:
            has = "{name} has md5sum {found}, expected {wanted}"
            wrong.append(say(has, name=name, found=found, wanted=f"{digits}..."))
    if wrong:
        text = "{wrong} of {count} definitions are wrong; {first}"
        raise CheckFailed(say(text, wrong=len(wrong), count=len(known), first=wrong[0]))
    return say("{count} types have the md5sums of genmsg", count=len(known))


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
                wrong = "{name}: the codecs differ, first at byte {at} of {size}"
                raise CheckFailed(say(wrong, name=name, at=at, size=len(data)))
            if encode_layout(layout, decode_layout(layout, again, 0, len(again))) != data:
                raise CheckFailed(say("{name}: the reference codec cannot read what it wrote", name=name))
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


_MESSAGES = 500


def check_bags() -> str:
    """Check that topics, times and values are read as they were written, in order."""
    from rosproto.bag import BagReader, BagWriter
    from rosproto.codec import message_class

    String, Imu = message_class("std_msgs/String"), message_class("sensor_msgs/Imu")
    size = 0
    with tempfile.TemporaryDirectory(prefix="rosproto-selftest-") as folder:
        for compression in ("none", "bz2", "lz4"):
            path = Path(folder, f"{compression}.bag")
            with BagWriter(path, compression=compression) as writer:
                for number in range(_MESSAGES):
                    writer.write("/words", String(data=f"第 {number}"), 1000.0 + number)
                    imu = Imu()
                    imu.linear_acceleration.x = number / 8
                    writer.write("/imu", imu, 1000.5 + number)
            with BagReader(path) as reader:
                read = list(reader.read_messages())
            words = [(t.to_sec(), message.data) for topic, message, t in read if topic == "/words"]
            expect(f"{compression}: texts", words, [(1000.0 + n, f"第 {n}") for n in range(_MESSAGES)])
            numbers = [message.linear_acceleration.x for topic, message, _ in read if topic == "/imu"]
            expect(f"{compression}: numbers", numbers, [n / 8 for n in range(_MESSAGES)])
            size += path.stat().st_size
    return say(
        "{count} messages, without compression, with bz2 and with lz4; {size} kB",
        count=2 * _MESSAGES,
        size=size // 1000,
    )
