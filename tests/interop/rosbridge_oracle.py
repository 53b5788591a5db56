"""The other side of test_rosbridge_values: rosbridge_suite's own conversions, under the Python that has rospy.

    rosbridge_oracle.py GENERATED_CLASSES ROSBRIDGE_LIBRARY_SRC QUESTIONS ANSWERS

Reads JSON lines {"do", ...} and writes for each what the original makes of it, or {"error": its class}.
What it would ask a master for (parameters, the clock) and a package path (classes) is given to it here; every
conversion is its own.
"""

from __future__ import annotations

import importlib
import io
import json
import sys
from typing import Any

NOW = (1234567890, 987654321)


def main(generated: str, library: str, source: str, target: str) -> None:
    sys.path[:0] = [generated, library]
    prepare()
    with open(source, encoding="utf-8") as lines, open(target, "w", encoding="utf-8") as out:
        for line in lines:
            out.write(json.dumps(answered(json.loads(line))) + "\n")


def prepare() -> None:
    import genpy
    import rospy
    from rosbridge_library.internal import message_conversion, ros_loader

    rospy.get_rostime = lambda: genpy.Time(*NOW)
    message_conversion.binary_encoder = message_conversion.standard_b64encode
    message_conversion.bson_only_mode = False
    ros_loader.get_message_instance = lambda name: class_of(name)()


def class_of(name: str) -> Any:
    package, _, base = name.partition("/")
    for kind in ("msg", "srv"):
        module = importlib.import_module(f"{package}.{kind}")
        if hasattr(module, base):
            return getattr(module, base)
    raise LookupError(name)


def answered(question: dict[str, Any]) -> dict[str, Any]:
    try:
        return globals()[f"do_{question['do']}"](question)
    except Exception as error:
        return {"error": f"{type(error).__name__}: {error}"}


def do_json(question: dict[str, Any]) -> dict[str, Any]:
    from rosbridge_library.internal.message_conversion import extract_values

    return {"values": extract_values(message_of(question))}


def do_cbor(question: dict[str, Any]) -> dict[str, Any]:
    from rosbridge_library.internal.cbor_conversion import extract_cbor_values
    from rosbridge_library.internal.outgoing_message import encode_cbor

    return {"cbor": encode_cbor(extract_cbor_values(message_of(question))).hex()}


def do_raw(question: dict[str, Any]) -> dict[str, Any]:
    from rosbridge_library.internal.outgoing_message import OutgoingMessage

    class Raw:
        _buff = bytes.fromhex(question["bytes"])

    message = OutgoingMessage(Raw()).get_cbor_raw({"op": "publish", "topic": question["topic"]})
    return {"cbor": message.hex()}


def do_populate(question: dict[str, Any]) -> dict[str, Any]:
    from rosbridge_library.internal.message_conversion import populate_instance

    message = class_of(question["type"])()
    populate_instance(question["values"], message)
    buffer = io.BytesIO()
    message.serialize(buffer)
    return {"bytes": buffer.getvalue().hex()}


def do_png(question: dict[str, Any]) -> dict[str, Any]:
    from PIL import Image
    from rosbridge_library.internal.pngcompression import decode, encode

    if not hasattr(Image.Image, "tostring"):  # Pillow once raised, for the original to try its new name
        Image.Image.tostring = not_implemented
    return {"png": encode(question["text"]), "text": decode(question["png"])}


def not_implemented(_image: Any) -> None:
    raise NotImplementedError


def message_of(question: dict[str, Any]) -> Any:
    message = class_of(question["type"])()
    message.deserialize(bytes.fromhex(question["bytes"]))
    return message


if __name__ == "__main__":
    main(*sys.argv[1:])
