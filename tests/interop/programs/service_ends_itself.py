"""Handlers that shut their own service down: in their thread, and by another one that they wait for."""

import threading

import rospy
from std_srvs.srv import Trigger, TriggerResponse

rospy.init_node("ends_itself", disable_rosout=True)


def itself(request):
    service.shutdown("own")
    return TriggerResponse(True, "bye")


def by_another(request):
    thread = threading.Thread(target=service.shutdown, args=("own",))
    thread.start()
    thread.join()
    return TriggerResponse(True, "by another")


for handler in (itself, by_another):
    for persistent in (False, True):
        service = rospy.Service("ends", Trigger, handler)
        proxy = rospy.ServiceProxy("ends", Trigger, persistent=persistent)
        print(proxy())
        proxy.close()
        try:
            print(rospy.ServiceProxy("ends", Trigger)())
        except rospy.ServiceException as error:
            print(error)
service = rospy.Service("ends", Trigger, lambda request: TriggerResponse(True, "again"))
print(rospy.ServiceProxy("ends", Trigger)())
