"""Gamepad teleop: a class, a dead man's button, parameters for axes, a service that changes the mode."""

import rospy
from geometry_msgs.msg import Twist
from sensor_msgs.msg import Joy, JoyFeedback, JoyFeedbackArray
from std_srvs.srv import SetBool, SetBoolResponse


class JoyTeleop(object):
    def __init__(self):
        self.axis = rospy.get_param("~axis_linear", {"x": 1, "y": 0})
        self.scale = rospy.get_param("~scale_linear", 0.7)
        self.enable = rospy.get_param("~enable_button", 4)
        self.turbo = False
        self.sent_disable = False
        self.pub = rospy.Publisher("cmd_vel", Twist, queue_size=1, latch=True)
        self.feedback = rospy.Publisher("joy/set_feedback", JoyFeedbackArray, queue_size=1)
        self.srv = rospy.Service("~turbo", SetBool, self.on_turbo)
        self.sub = rospy.Subscriber("joy", Joy, self.on_joy, queue_size=10)

    def on_turbo(self, req):
        self.turbo = req.data
        return SetBoolResponse(success=True, message="turbo %s" % ("on" if req.data else "off"))

    def on_joy(self, joy):
        try:
            if joy.buttons[self.enable]:
                t = Twist()
                t.linear.x = joy.axes[self.axis["x"]] * self.scale * (2 if self.turbo else 1)
                t.linear.y = joy.axes[self.axis["y"]] * self.scale
                self.pub.publish(t)
                self.sent_disable = False
            elif not self.sent_disable:
                self.pub.publish(Twist())
                self.sent_disable = True
        except IndexError as e:
            rospy.logwarn("joystick has too few axes or buttons: %s", e)


if __name__ == "__main__":
    rospy.init_node("joy_teleop")
    teleop = JoyTeleop()
    seen = []
    rospy.Subscriber("cmd_vel", Twist, lambda m: seen.append((round(m.linear.x, 3), round(m.linear.y, 3))))
    handled = []
    rospy.Subscriber("joy", Joy, handled.append)  # the last that is called
    fake = rospy.Publisher("joy", Joy, queue_size=10)
    while not (fake.get_num_connections() and teleop.pub.get_num_connections()):
        rospy.sleep(0.02)
    turbo = rospy.ServiceProxy("~turbo", SetBool)
    for step in range(6):
        if step == 3:
            print(turbo(True).message, turbo(data=False).message, turbo(SetBool._request_class(True)).success)
        joy = Joy(axes=[0.5, -0.25, 0], buttons=[0, 0, 0, 0, int(step % 3 != 2)])
        if step == 5:
            joy.buttons = []
        fake.publish(joy)
        while len(handled) <= step or len(seen) < (1, 2, 3, 4, 5, 5)[step]:
            rospy.sleep(0.01)
    teleop.feedback.publish([JoyFeedback(type=JoyFeedback.TYPE_RUMBLE, id=0, intensity=0.5)])
    print(seen, teleop.sent_disable)
