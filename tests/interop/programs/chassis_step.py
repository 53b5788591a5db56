"""Step control as an action, with feedback."""

import actionlib
import rospy
from woosh_msgs.msg import StepControl, StepControlAction, StepControlGoal


def step(client, mode, value, speed):
    goal = StepControlGoal(mode=StepControlGoal.EXCUTE, useAvoid=False)
    item = StepControl()
    item.executeMode = mode
    item.data = value
    item.speed = speed
    goal.stepControl.append(item)
    client.send_goal(
        goal, feedback_cb=lambda f: seen.append(f.percent), active_cb=lambda: seen.append("active")
    )
    print(client.wait_for_result(rospy.Duration(60)), client.get_state(), client.get_result().result)


seen = []
rospy.init_node("stepper")
client = actionlib.SimpleActionClient("cmd_vel_control", StepControlAction)
client.wait_for_server()
step(client, StepControlGoal.STRAIGHT, 0.4, 0.3)
print(len(seen) > 1)  # rospy loses active_cb when the first status is faster than send_goal
step(client, StepControlGoal.ROTATE, 0.5, 0.5)
