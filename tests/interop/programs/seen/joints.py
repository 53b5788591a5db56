# ruff: noqa: B905, B023, RUF100
"""Joint states and trajectories: dictionaries by name, interpolation, missing fields, nested durations."""

import rospy
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

rospy.init_node("joints")
latest = {}


def on_state(msg):
    latest.update(dict(zip(msg.name, msg.position)))
    latest["count"] = latest.get("count", 0) + 1
    latest["effort"] = msg.effort


rospy.Subscriber("joint_states", JointState, on_state)
states = rospy.Publisher("joint_states", JointState, queue_size=10)
command = rospy.Publisher("command", JointTrajectory, queue_size=1, latch=True)
while not states.get_num_connections():
    rospy.sleep(0.02)
msg = JointState()
msg.name = ["wheel_left", "wheel_right", "lift"]
for i in range(3):
    msg.header.stamp = rospy.Time.now()
    msg.position = [0.1 * i, -0.1 * i, 2]
    msg.velocity = (1.0, 2.0, 3.0) if i else []
    msg.effort = []
    states.publish(msg)
    while latest.get("count", 0) <= i:
        rospy.sleep(0.01)
print(sorted((k, v) for k, v in latest.items()))
trajectory = JointTrajectory(joint_names=msg.name)
for i in range(3):
    trajectory.points.append(
        JointTrajectoryPoint(positions=[i, i * 2.0, i / 2], time_from_start=rospy.Duration(i * 0.5))
    )
trajectory.points[1].velocities = [0.0] * 3
command.publish(trajectory)
ear = rospy.Subscriber("command", JointTrajectory, lambda m: None)
got = rospy.wait_for_message("command", JointTrajectory, 20)


def at(t):
    for a, b in zip(got.points, got.points[1:]):
        t0, t1 = a.time_from_start.to_sec(), b.time_from_start.to_sec()
        if t0 <= t <= t1:
            s = (t - t0) / (t1 - t0)
            return [round(p + s * (q - p), 4) for p, q in zip(a.positions, b.positions)]
    return None


print(at(0.25), at(0.9), at(5), got.points[2].time_from_start, [len(p.velocities) for p in got.points])
print(got.joint_names, type(got.joint_names).__name__, type(got.points[0].positions).__name__)
for wrong in ({"positions": "text"}, {"positions": [None]}, {"time_from_start": 3}, {"velocities": 5.0}):
    try:
        trajectory.points = [JointTrajectoryPoint(**wrong)]
        command.publish(trajectory)
        print("sent", wrong)
    except Exception as e:
        print(type(e).__name__, str(e)[:60].split("(")[0])
