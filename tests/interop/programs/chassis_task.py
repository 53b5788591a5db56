"""Send a chassis to a mark, watch /robot_status, change battery reading to a dict."""

import sys
import threading

import rospy
from woosh_msgs.msg import Battery, RobotStatus
from woosh_msgs.srv import ExecTask, ExecTaskRequest


class Runner:
    def __init__(self, mark):
        self.mark = mark
        self.states = []
        self.done = threading.Event()
        self.sub = rospy.Subscriber(
            "/robot_status", RobotStatus, self.on_status, queue_size=10, tcp_nodelay=True
        )
        self.task = rospy.ServiceProxy("/exec_task", ExecTask)

    def on_status(self, status):
        if status.task_id != 77:
            return
        if not self.states or self.states[-1] != status.task_state:
            self.states.append(status.task_state)
        if status.task_state in (7, 8, 9):
            self.done.set()

    def run(self):
        self.task.wait_for_service()
        request = ExecTaskRequest(task_exect=1, task_id=77, task_type=4, mark_no=self.mark)
        response = self.task(request)
        print(response.success, response.message)
        print(self.done.wait(60), self.states[-1] if self.states else None)


rospy.init_node("task_runner", anonymous=True)
battery = rospy.wait_for_message("/battery", Battery, timeout=20)
print(battery.batteryPercentage > 0, type(battery).__name__)
Runner(sys.argv[1]).run()
bad = rospy.ServiceProxy("exec_task", ExecTask)(task_exect=1, task_id=78, task_type=4, mark_no="no such mark")
print(bad.success)
try:
    rospy.ServiceProxy("/exec_task", ExecTask)(task_exect=1000)
except Exception as e:
    print(type(e).__module__, type(e).__name__, e)
