"""The layers of the project, from the ground up, and where their tests are (tests/test_layers.py watches)."""

from __future__ import annotations

LAYERS = [
    "rosproto.deprecation",
    "rosproto.extras",
    "rosproto.text",
    "rosproto.json_values",
    "rosproto.json_fields",
    "rosproto.json_text",
    "rosproto.sentence",
    "rosproto.errors",
    "rosproto.files",
    "rosproto.profile",
    "rosproto.bounded_cache",
    "rosproto.logs",
    "rosproto.version",
    "rosproto.startup",
    "rosproto.typed_values",
    "rosproto.coercion",
    "rosproto.quaternion",
    "rosproto.rates",
    "rosproto.worker_pool",
    "rosproto.names",
    "rosproto.time",
    "rosproto.msg",
    "rosproto.codec",
    "rosproto.numeric",
    "msgdefs",
    "rosproto.protocol",
    "rosproto.bag",
    "rosproto.transport",
    "rosproto.admission",
    "rosproto.master",
    "rosproto.node",
    "rosproto.rosout_aggregator",
    "rosproto.action",
    "rosproto.tf",
    "rosproto.recording",
    "rosproto.watchdog",
    "rosproto.aio",
    "rosproto.gateway",
    "rosproto.selftest",
    "rosproto.rospy",
    "rosproto.cli",
    "rosproto",
    "woosh_pure",
]
"""From the ground up. The package `rosproto` itself is the public API: only woosh_pure may import it."""

PURE = [
    "rosproto.msg",
    "rosproto.text",
    "rosproto.json_values",
    "rosproto.json_fields",
    "rosproto.sentence",
    "rosproto.errors",
    "rosproto.typed_values",
    "rosproto.coercion",
    "rosproto.quaternion",
    "rosproto.rates",
    "rosproto.names",
    "rosproto.time",
    "rosproto.codec",
    "rosproto.protocol",
    "rosproto.admission",
]
"""Values in, values out: no sockets, threads or clocks."""

TESTS_OF = {
    "woosh_pure/cli": "tests/unit/woosh_cli",
    "woosh_pure/language": "tests/unit/language",
    "woosh_pure": "tests/unit/woosh",
    "tools": "tests/unit/tools",
}
"""Test folders with another name below tests/unit."""
