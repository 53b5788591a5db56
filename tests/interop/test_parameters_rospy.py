"""Parameters with rospy and rosparam: types both ways, updates of cached values both ways."""

from __future__ import annotations

import json
import math
import threading

import pytest

from rosproto.node import Node, UnknownParameter
from tests.support import ros

VALUES = {
    "yes": True,
    "no": False,
    "one": 1,
    "zero": 0,
    "negative": -(1 << 31),
    "largest": (1 << 31) - 1,
    "tenth": 0.1,
    "whole": 2.0,
    "huge": 1.7976931348623157e308,
    "tiny": 5e-324,
    "text": "plain",
    "empty_text": "",
    "markup": "a<b>&\"c'",
    "spaces": "  two\nlines\t",
    "unicode": "Größe 底盘 🤖",
    "list": [1, 2.5, "x", True, [1, [2]]],
    "empty_list": [],
    "nested": {"a": {"b": {"c": [{"d": 1}]}}},
}

READ = """
import json, rospy, sys
rospy.init_node("reader", anonymous=True, disable_signals=True)
def typed(v):
    if isinstance(v, dict): return {k: typed(x) for k, x in v.items()}
    if isinstance(v, list): return ["list"] + [typed(x) for x in v]
    return [type(v).__name__, v]
print(json.dumps(typed(rospy.get_param("/values"))))
print(json.dumps([rospy.has_param("/values/nested/a"), rospy.has_param("/nope"), rospy.search_param("values")]))
"""
WRITE = """
import json, rospy, sys
rospy.init_node("writer", anonymous=True, disable_signals=True)
rospy.set_param("/values", json.loads(sys.argv[1]))
rospy.set_param("~private", 7)
rospy.delete_param("/values/zero")
"""
CACHED = """
import rospy, sys, time
rospy.init_node("cached", disable_signals=True)
print("first", rospy.get_param_cached("/live"), flush=True)
last = "1"
while True:
    now = str(rospy.get_param_cached("/live"))
    if now != last:
        print("now", now, flush=True)
        last = now
    time.sleep(0.01)
"""


def typed(value):
    if isinstance(value, dict):
        return {key: typed(item) for key, item in value.items()}
    if isinstance(value, list):
        return ["list", *map(typed, value)]
    return [type(value).__name__, value]


@pytest.mark.promise("A boolean is not an integer, also on")
def test_rospy_reads_what_we_set_with_its_types(any_master):
    with Node("/ours", master_uri=any_master) as node:
        node.params["/values"] = VALUES
        assert typed(node.params["/values"]) == typed(VALUES)
        lines = ros.run_rospy(READ, any_master).stdout.splitlines()
    assert json.loads(lines[0]) == json.loads(json.dumps(typed(VALUES)))
    assert json.loads(lines[1]) == [True, False, "/values"]


def test_we_read_what_rospy_sets_with_its_types(any_master):
    with Node("/ours", master_uri=any_master) as node:
        ros.run_rospy(WRITE, any_master, json.dumps(VALUES))
        expected = {key: value for key, value in VALUES.items() if key != "zero"}
        assert typed(node.params["/values"]) == typed(expected)
        with pytest.raises(UnknownParameter):
            node.params["/values/zero"]
        assert node.params["/values/nested/a/b/c"] == [{"d": 1}]
        assert any(name.endswith("/private") for name in node.params.names())
        assert node.params.search("values") == "/values"


def test_numbers_that_are_none_cross_between_us(any_master):
    with Node("/ours", master_uri=any_master) as node:
        node.params["/odd"] = [math.inf, -math.inf, math.nan]
        up, down, none = node.params["/odd"]
        assert (up, down) == (math.inf, -math.inf)
        assert math.isnan(none)


def test_a_cached_value_of_rospy_follows_what_we_set(any_master):
    with Node("/ours", master_uri=any_master) as node:
        node.params["/live"] = 1
        with ros.start_rospy(CACHED, any_master) as cached:
            cached.wait_for("^first 1")
            node.params["/live"] = 2
            cached.wait_for("^now 2")
            node.params["/live"] = "three"
            cached.wait_for("^now three")


def test_our_subscription_follows_what_rosparam_sets(any_master):
    changes: list[tuple[str, object]] = []
    changed = threading.Condition()

    def told(key, value):
        with changed:
            changes.append((key, value))
            changed.notify_all()

    def wait_for(change):
        with changed:
            assert changed.wait_for(lambda: change in changes, 10), changes

    with Node("/ours", master_uri=any_master) as node:
        subscription = node.params.subscribe("/live", told)
        ros.ros_tool(["rosparam", "set", "/live/speed", "2.5"], any_master)
        wait_for(("/live/speed", 2.5))
        ros.ros_tool(["rosparam", "set", "/live/name", "bot"], any_master)
        wait_for(("/live/name", "bot"))
        assert subscription.value == {"speed": 2.5, "name": "bot"}
        ros.ros_tool(["rosparam", "delete", "/live/speed"], any_master)
        wait_for(("/live/speed", None))
        assert subscription.value == {"name": "bot"}
        ros.ros_tool(["rosparam", "set", "/live", "{a: 1, b: [x, true]}"], any_master)
        wait_for(("/live/b", ["x", True]))  # rosparam sets every leaf of a dict by itself
        assert subscription.value == {"name": "bot", "a": 1, "b": ["x", True]}


def test_rosparam_works_on_what_we_set(any_master, tmp_path):
    with Node("/ours", master_uri=any_master) as node:
        node.params["/robot"] = {"speed": 0.5, "wheels": 2, "on": True, "names": ["a", "b"]}
        assert ros.ros_tool(["rosparam", "get", "/robot/speed"], any_master).stdout.strip() == "0.5"
        assert ros.ros_tool(["rosparam", "get", "/robot/on"], any_master).stdout.strip() == "true"
        listed = ros.ros_tool(["rosparam", "list"], any_master).stdout.split()
        assert {"/robot/speed", "/robot/wheels", "/robot/on", "/robot/names"} <= set(listed)
        assert listed == node.params.names()
        dump = tmp_path / "dump.yaml"
        ros.ros_tool(["rosparam", "dump", str(dump), "/robot"], any_master)
        ros.ros_tool(["rosparam", "load", str(dump), "/copy"], any_master)
        assert typed(node.params["/copy"]) == typed(node.params["/robot"])
