"""The other side of test_genpy_codec: runs under the Python that has genpy, with generated classes.

Reads JSON lines {"type", "kind", "values", "bytes"}; for each writes {"bytes": what genpy makes of the values,
"values": what genpy reads from our bytes}. Values are those of `rosproto.codec.reference`, with floats and
bytes as hex strings in one-key objects, so that nothing is lost.
"""

from __future__ import annotations

import importlib
import io
import json
import struct
import sys
from typing import Any

import genpy


def main(generated: str, source: str, target: str) -> None:
    sys.path.insert(0, generated)
    with open(source, encoding="utf-8") as lines, open(target, "w", encoding="utf-8") as out:
        for line in lines:
            out.write(json.dumps(answer(json.loads(line))) + "\n")


def class_of(name: str) -> Any:
    package, _, base = name.partition("/")
    for kind in ("msg", "srv"):
        module = importlib.import_module(f"{package}.{kind}")
        if hasattr(module, base):
            return getattr(module, base)
    raise LookupError(name)


def answer(case: dict[str, Any]) -> dict[str, Any]:
    cls = class_of(case["type"])
    buffer = io.BytesIO()
    build(cls, case["values"]).serialize(buffer)
    decoded = cls().deserialize(bytes.fromhex(case["bytes"]))
    return {
        "bytes": buffer.getvalue().hex(),
        "values": plain(decoded),
        "md5sum": cls._md5sum,
        "text": str(decoded),
    }


def build(cls: Any, values: list[Any]) -> Any:
    message = cls()
    for name, type_name, value in zip(cls.__slots__, cls._slot_types, values, strict=False):
        setattr(message, name, build_field(type_name, value))
    return message


def build_field(type_name: str, value: Any) -> Any:
    if isinstance(value, dict) and "hex" in value:
        return bytes.fromhex(value["hex"])
    if type_name.endswith("]"):
        base = type_name[: type_name.index("[")]
        return [build_field(base, item) for item in value]
    if isinstance(value, dict):
        return struct.unpack("<d", bytes.fromhex(value["float"]))[0]
    if type_name in ("time", "duration"):
        stamp = (genpy.Time if type_name == "time" else genpy.Duration)()
        stamp.secs, stamp.nsecs = value
        return stamp
    if isinstance(value, list):
        return build(class_of(type_name), value)
    return value


def plain(value: Any) -> Any:
    if isinstance(value, genpy.Message):
        return [plain(getattr(value, name)) for name in value.__slots__]
    if isinstance(value, (genpy.Time, genpy.Duration)):
        # genpy canonises some times when decoding and forgets others: do it for all.
        return [value.secs + value.nsecs // 10**9, value.nsecs % 10**9]
    if isinstance(value, bytes):
        return {"hex": value.hex()}
    if isinstance(value, float):
        return {"float": struct.pack("<d", value).hex()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    return value


if __name__ == "__main__":
    main(*sys.argv[1:])
