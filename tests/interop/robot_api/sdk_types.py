"""Runs in the SDK's environment: parses bodies by its own message classes, and tells their fields.

stdin: JSON, a list of [type, body]. stdout: JSON, for each [problem, {field: number}]; the problem is "" without one.
"""

from __future__ import annotations

import importlib
import json
import pkgutil
import sys
from typing import Any

import woosh.proto
from google.protobuf import descriptor_pool
from google.protobuf.json_format import ParseDict
from google.protobuf.message_factory import MessageFactory


def judged(name: str, body: Any) -> tuple[str, dict[str, int]]:
    pool = descriptor_pool.Default()
    try:
        descriptor = pool.FindMessageTypeByName(name)
        ParseDict(body, MessageFactory(pool).GetPrototype(descriptor)())
    except Exception as problem:  # whatever makes its client drop the message
        return f"{type(problem).__name__}: {problem}", {}
    return "", {field.name: field.number for field in descriptor.fields}


for module in pkgutil.walk_packages(woosh.proto.__path__, "woosh.proto."):
    importlib.import_module(module.name)
print(json.dumps([judged(name, body) for name, body in json.load(sys.stdin)]))
