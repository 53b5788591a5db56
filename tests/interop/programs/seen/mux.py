"""A command mux: topics from a parameter, priorities, callback_args, remapped on the command line."""

import sys
from functools import partial

import rospy
from geometry_msgs.msg import Twist
from std_msgs.msg import String

rospy.init_node("mux", argv=sys.argv)
rospy.set_param("~inputs", [{"name": "nav", "priority": 1}, {"name": "joy", "priority": 10}])
print(
    rospy.myargv()[1:],
    rospy.myargv(argv=["x", "a:=b", "_c:=1", "d"]),
    rospy.get_param("~speed"),
    rospy.resolve_name("out"),
)
active = [None]
selected = rospy.Publisher("selected", String, queue_size=5, latch=True)
out = rospy.Publisher("out", Twist, queue_size=5)
log = []


def on_input(name, priority, msg):
    if active[0] is None or priority >= active[0][1]:
        if active[0] is None or active[0][0] != name:
            active[0] = (name, priority)
            selected.publish(String(data=name))
        out.publish(msg)
        log.append((name, msg.linear.x))


subs = [
    rospy.Subscriber("in_" + entry["name"], Twist, partial(on_input, entry["name"], entry["priority"]))
    for entry in rospy.get_param("~inputs")
]
pubs = {name: rospy.Publisher("in_" + name, Twist, queue_size=5) for name in ("nav", "joy")}
heard = []
rospy.Subscriber(
    rospy.remap_name("out"), Twist, lambda m, args: heard.append((m.linear.x, args)), callback_args={"k": 1}
)
while not all(p.get_num_connections() for p in [*pubs.values(), out]):
    rospy.sleep(0.02)
through = []
for name in pubs:
    rospy.Subscriber("in_" + name, Twist, through.append)  # the last that is called
for i, (name, x) in enumerate((("nav", 1), ("joy", 2), ("nav", 3), ("joy", 4))):
    message = Twist()
    message.linear.x = x
    pubs[name].publish(message)
    while len(through) <= i or len(heard) < len(log):
        rospy.sleep(0.01)
print(log, heard, rospy.wait_for_message("selected", String, 20).data)
print([s.name for s in subs], out.name, out.resolved_name, [s.callback is not None for s in subs])
subs[0].unregister()
print(subs[0].callback, rospy.get_name(), rospy.get_namespace(), rospy.get_caller_id())
