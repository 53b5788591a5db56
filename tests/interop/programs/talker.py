"""The tutorial's talker: ten times a second, a relative topic, an anonymous name."""

import rospy
from std_msgs.msg import String


def talker():
    pub = rospy.Publisher("chatter", String, queue_size=10)
    rospy.init_node("talker", anonymous=True)
    rate = rospy.Rate(20)
    while pub.get_num_connections() == 0 and not rospy.is_shutdown():
        rate.sleep()
    count = 0
    while not rospy.is_shutdown() and count < 5:
        text = "hello world %d" % count
        rospy.loginfo(text)
        pub.publish(text)
        count += 1
        rate.sleep()
    print("sent", count)
    while rospy.get_param("/heard/ear", 0) < 5:
        rospy.sleep(0.01)


if __name__ == "__main__":
    try:
        talker()
    except rospy.ROSInterruptException:
        pass
