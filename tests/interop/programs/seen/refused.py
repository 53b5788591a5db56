"""Other types under the same name: who is told what, and that the others go on."""

import logging.handlers

import rospy
from std_msgs.msg import Float32, Int32, String
from std_srvs.srv import SetBool, Trigger, TriggerResponse

rospy.init_node("refused")
refusals = logging.handlers.BufferingHandler(100)
refusals.setLevel(logging.WARNING)
logging.getLogger("rosout").addHandler(refusals)
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
print(rospy.wait_for_message("topic", String, 20).data)
try:
    rospy.Subscriber("topic", Float32, good.append)
except rospy.ROSException as e:
    print(type(e).__name__, e)
try:
    rospy.Publisher("other", String, queue_size=1)
    print("another type to publish than to subscribe to")
except rospy.ROSException as e:
    print(type(e).__name__, e)
while len(refusals.buffer) < 3:  # of SetBool by the service, of Float32 and of Int32 by the topics
    rospy.sleep(0.01)
print(good, bad)
