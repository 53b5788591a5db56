"""Keyboard teleop: bindings, speeds that grow and shrink, usage text, zero at the end."""

import sys

import rospy
from geometry_msgs.msg import Twist

USAGE = """
Moving around:
   u    i    o
q/z : faster / slower
"""
MOVES = {"i": (1, 0), "o": (1, -1), "u": (1, 1), ",": (-1, 0), "j": (0, 1), "l": (0, -1)}
SPEEDS = {"q": (1.1, 1.1), "z": (0.9, 0.9), "w": (1.1, 1), "e": (1, 1.1)}


def vels(speed, turn):
    return "currently:\tspeed %s\tturn %s " % (speed, turn)


keys = iter("iiquzeol,jxk" + sys.stdin.read(1) + "\x03")
rospy.init_node("teleop_twist_keyboard")
pub = rospy.Publisher("cmd_vel", Twist, queue_size=1)
seen = []
rospy.Subscriber("cmd_vel", Twist, lambda m: seen.append((round(m.linear.x, 4), round(m.angular.z, 4))))
speed, turn = rospy.get_param("~speed", 0.5), rospy.get_param("~turn", 1.0)
while not pub.get_num_connections():
    rospy.sleep(0.02)
x = th = status = 0
sent = 0
try:
    print(USAGE)
    print(vels(speed, turn))
    for key in keys:
        if key in MOVES:
            x, th = MOVES[key]
        elif key in SPEEDS:
            speed, turn = speed * SPEEDS[key][0], turn * SPEEDS[key][1]
            print(vels(speed, turn))
            if status == 14:
                print(USAGE)
            status = (status + 1) % 15
        else:
            x = th = 0
            if key == "\x03":
                break
        twist = Twist()
        twist.linear.x = x * speed
        twist.linear.y = twist.linear.z = 0
        twist.angular.x = twist.angular.y = 0
        twist.angular.z = th * turn
        pub.publish(twist)
        sent += 1
        while len(seen) < sent:  # a queue of one keeps the newest only
            rospy.sleep(0.005)
except Exception as e:
    print(e)
finally:
    twist = Twist()
    pub.publish(twist)
    sent += 1
while len(seen) < sent:
    rospy.sleep(0.02)
print(sent, seen)
