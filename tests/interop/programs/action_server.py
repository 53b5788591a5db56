"""SimpleActionServer with an execute callback."""

import actionlib
import rospy
from actionlib.msg import TestAction, TestFeedback, TestResult


class Counter:
    def __init__(self):
        self.server = actionlib.SimpleActionServer(
            "count", TestAction, execute_cb=self.execute, auto_start=False
        )
        self.server.start()

    def execute(self, goal):
        while not self.server.action_server.result_pub.get_num_connections():
            rospy.sleep(0.01)  # the client is connected; this side may not know it yet
        for i in range(abs(goal.goal)):
            if self.server.is_preempt_requested() or rospy.is_shutdown():
                rospy.loginfo("preempted")
                self.server.set_preempted(TestResult(result=i * 0 - 1), "asked to stop")
                return
            self.server.publish_feedback(TestFeedback(feedback=i))
            rospy.sleep(0.05)
        if goal.goal == 7:
            raise ValueError("seven")
        if goal.goal < 0:
            self.server.set_aborted(TestResult(result=goal.goal), "negative")
        else:
            self.server.set_succeeded(TestResult(result=goal.goal * 2), "counted")


rospy.init_node("action_server")
counter = Counter()
print("ready", flush=True)
rospy.spin()
print("over")
