# ruff: noqa: UP031
"""Compares a tf2_py with Debian's over random trees: `tf2_oracle.py FOLDER CASES`; runs where tf2 is."""

import importlib.util
import math
import random
import sys
from pathlib import Path

import rospy
import tf2_py as real
from geometry_msgs.msg import TransformStamped


def load(folder):
    sys.path.append(str(Path(folder).parents[3]))  # last: what Debian has too is Debian's
    spec = importlib.util.spec_from_file_location(
        "compared_tf2", folder + "/__init__.py", submodule_search_locations=[folder]
    )
    module = sys.modules["compared_tf2"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


ours = load(sys.argv[1])
draw = random.Random(7)
compared = 0
differences = []


def rotation():
    q = [draw.gauss(0, 1) for _ in range(4)]
    length = math.sqrt(sum(part * part for part in q))
    return [part / length for part in q] if draw.random() < 0.95 else [0, 0, 0, 1]


def pose(names, base, case):
    message = TransformStamped()
    child = draw.randrange(1, len(names))
    parent = (child * 7 + case) % child if draw.random() < 0.9 else draw.randrange(len(names))
    message.child_frame_id = draw.choice(["", "", "", "/"]) + names[child]
    message.header.frame_id = names[parent]
    nsecs = draw.choice([0, 0, 500000000, draw.randrange(10**9)])
    message.header.stamp = rospy.Time(base + draw.randint(0, 14), nsecs)
    r, t = message.transform.rotation, message.transform.translation
    r.x, r.y, r.z, r.w = rotation()
    t.x, t.y, t.z = [draw.uniform(-5, 5) for _ in range(3)]
    return message


def answer(function, buffer):
    try:
        return str(function(buffer))
    except Exception as error:
        return "%s %s" % (type(error).__name__, error)


def compare(what, buffers, function):
    global compared
    compared += 1
    theirs, mine = (answer(function, buffer) for buffer in buffers)
    if theirs != mine:
        differences.append("%s\n  tf2:  %s\n  ours: %s" % (what, theirs, mine))


def ask(buffers, names, base):
    a, b, fixed = (draw.choice([*names, "unknown", "", "/f0"]) for _ in range(3))
    when = draw.choice([rospy.Time(0), rospy.Time(base + draw.randint(0, 14), draw.choice([0, 250000000]))])
    then = rospy.Time(base + draw.randint(0, 14), 0)
    compare(("lookup", a, b, when), buffers, lambda x: x.lookup_transform_core(a, b, when))
    compare(("can", a, b, when), buffers, lambda x: x.can_transform_core(a, b, when))
    compare(("common time", a, b), buffers, lambda x: x.get_latest_common_time(a, b))
    compare(("full", a, b, fixed), buffers, lambda x: x.lookup_transform_full_core(a, when, b, then, fixed))
    compare(("can full", a, b, fixed), buffers, lambda x: x.can_transform_full_core(a, when, b, then, fixed))


for case in range(int(sys.argv[2])):
    buffers = [module.BufferCore(rospy.Duration(10)) for module in (real, ours)]
    names = ["f%d" % i for i in range(draw.randint(2, 7))]
    base = draw.choice([0, 100, 1600000000])
    for i in range(draw.randint(1, 40)):
        message, static = pose(names, base, case), draw.random() < 0.1
        for buffer in buffers:
            (buffer.set_transform_static if static else buffer.set_transform)(message, "node %d" % (i % 3))
        if draw.random() < 0.3:  # what a lookup keeps for the next one must not outlive a change
            ask(buffers, names, base)
        if draw.random() < 0.02:
            for buffer in buffers:
                buffer.clear()
    for _ in range(25):
        ask(buffers, names, base)
    compare("yaml", buffers, lambda x: x.all_frames_as_yaml())
    compare("text", buffers, lambda x: x.all_frames_as_string())
    compare("names", buffers, lambda x: sorted(x._getFrameStrings()))
    if draw.random() < 0.3:
        for buffer in buffers:
            buffer.clear()
        ask(buffers, names, base)
        compare("yaml after clear", buffers, lambda x: x.all_frames_as_yaml())
print("\n".join(differences[:5]))
if differences:
    sys.exit("%d of %d differ" % (len(differences), compared))
print("all agree: %d" % compared)
