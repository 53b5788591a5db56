"""A chassis made of rospy: every row of the table in CHASSIS_ROWS (JSON lists of name, type, flow).

It publishes each topic to read, prints what it hears, is called with and gets as goals, and says yes.
"""

import importlib
import json
import os
import sys
import threading

import actionlib
import rospy

lock = threading.Lock()


def find(type_name, kind="msg"):
    package, name = type_name.split("/")
    return getattr(importlib.import_module(package + "." + kind), name)


def tell(what, name, message):
    line = " ".join((what, name, " ".join(str(message).split())))
    with lock:  # topics have a thread each, and print() writes in pieces
        sys.stdout.write(line + "\n")
        sys.stdout.flush()


def some(type_name):
    """A message that makes sense of a type whose default does not."""
    message = find(type_name)()
    if type_name == "sensor_msgs/Image":
        message.height, message.width, message.step, message.encoding, message.data = (
            2,
            2,
            2,
            "mono8",
            b"\x01\x02\x03\x04",
        )
    elif type_name == "sensor_msgs/PointCloud2":
        field = find("sensor_msgs/PointField")
        message.fields = [field(n, 4 * i, 7, 1) for i, n in enumerate("xyz")]
        message.height, message.width, message.point_step, message.row_step, message.data = (
            1,
            1,
            12,
            12,
            bytes(12),
        )
    return message


def answer(request, name, kind):
    tell("called", name, request)
    response = find(kind + "Response", "srv")()
    if hasattr(response, "success"):
        response.success = True
    if kind == "nav_msgs/GetMap":
        info = response.map.info
        info.width, info.height, info.resolution, response.map.data = 2, 2, 0.5, [0, 100, -1, 0]
    if kind == "nav_msgs/GetPlan":
        response.plan.poses = [request.start, request.goal]
    if kind == "woosh_msgs/ExecTask":
        running = find("woosh_msgs/RobotStatus")(task_id=request.task_id, task_state=3, robot_state=4)
        publishers["/robot_status"][0].publish(running)
        running.task_state = 7
        publishers["/robot_status"][0].publish(running)
    return response


def serve(name, kind):
    def run(goal):
        tell("goal", name, goal)
        while not server.action_server.result_pub.get_num_connections():
            rospy.sleep(0.01)  # the client is connected; this side may not know it yet
        server.publish_feedback(find(kind + "Feedback")())
        result = find(kind + "Result")()
        if hasattr(result, "result"):
            result.result = getattr(result, "SUCCESS", 1)
        server.set_succeeded(result)

    server = actionlib.SimpleActionServer(name, find(kind + "Action"), run, auto_start=False)
    server.start()


rospy.init_node("ros_interface", disable_signals=True)
publishers = {}
for name, kind, flow in json.loads(os.environ["CHASSIS_ROWS"]):
    if flow == "read":
        publishers[name] = (rospy.Publisher(name, find(kind), queue_size=10), some(kind))
    elif flow == "write":
        rospy.Subscriber(name, find(kind), lambda message, name=name: tell("heard", name, message))
    elif flow == "call":
        rospy.Service(
            name, find(kind, "srv"), lambda request, name=name, kind=kind: answer(request, name, kind)
        )
    else:
        serve(name, kind)
print("up", flush=True)
try:
    while not rospy.is_shutdown():
        for name, (publisher, message) in publishers.items():
            if name != "/robot_status" or publisher.get_num_connections():
                publisher.publish(message)
        rospy.sleep(0.2)
finally:
    rospy.signal_shutdown("interrupted")  # which the threads of the actions wait for
