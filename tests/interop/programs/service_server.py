"""A server of several services: instances, dicts, lists, errors."""

import rospy
from std_srvs.srv import Empty, EmptyResponse, SetBool, SetBoolResponse, Trigger

rospy.init_node("server")


def switch(request):
    print("asked", request.data, flush=True)
    if request.data:
        return SetBoolResponse(True, "on")
    raise rospy.ServiceException("will not")


rospy.Service("switch", SetBool, switch)
rospy.Service("as_dict", SetBool, lambda r: {"success": r.data, "message": "dict"})
rospy.Service("as_list", SetBool, lambda r: [r.data, "list"])
rospy.Service("nothing", SetBool, lambda r: None)
rospy.Service("too_few", SetBool, lambda r: [True])
rospy.Service("wrong", SetBool, lambda r: (True, 5))
rospy.Service("fails", Trigger, lambda r: 1 / 0)
rospy.Service("~private", Empty, lambda r: EmptyResponse())
try:
    rospy.Service("switch", SetBool, switch)
except rospy.ServiceException as e:
    print(e)


def end(event):
    while not rospy.has_param("/called"):  # the answer has arrived
        rospy.sleep(0.01)
    rospy.signal_shutdown("asked")


quit_service = rospy.Service(
    "quit", Empty, lambda r: (rospy.Timer(rospy.Duration(0.01), end, oneshot=True), EmptyResponse())[1]
)
quit_service.spin()
print("over")
