"""Other types under the same name: who is told what, and that the others go on."""

import rospy
from std_msgs.msg import Float32, Int32, String
from std_srvs.srv import SetBool, Trigger, TriggerResponse

rospy.init_node("refused")
text = rospy.Publisher("topic", String, queue_size=5, latch=True)
text.publish("%s 100% {x}")
good, bad = [], []
wrong = rospy.Subscriber("other", Int32, bad.append)
right = rospy.Subscriber("other", Float32, good.append) if False else None
rospy.Service("service", Trigger, lambda req: TriggerResponse(True, "fine"))
for kind in (SetBool, Trigger):
    try:
        print(rospy.ServiceProxy("service", kind)(*([True] if kind is SetBool else [])).message)
    except rospy.ServiceException as e:
        print(type(e).__name__, "md5sum" in str(e))
print(rospy.wait_for_message("topic", String, 5).data)
try:
    rospy.Subscriber("topic", Float32, good.append)
except rospy.ROSException as e:
    print(type(e).__name__, e)
try:
    rospy.Publisher("other", String, queue_size=1)
    print("another type to publish than to subscribe to")
except rospy.ROSException as e:
    print(type(e).__name__, e)
rospy.sleep(0.3)
print(good, bad)
