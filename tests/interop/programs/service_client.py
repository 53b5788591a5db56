"""Every way to call a service, and what goes wrong."""

import rospy
from std_srvs.srv import SetBool, SetBoolRequest, Trigger

rospy.wait_for_service("switch")
switch = rospy.ServiceProxy("switch", SetBool)
print(switch(True).message)
rospy.init_node("client")
switch.wait_for_service(timeout=2)
print(
    switch(data=False).success,
    switch(SetBoolRequest(True)).success,
    switch.call(SetBoolRequest(data=True)).message,
)
kept = rospy.ServiceProxy("switch", SetBool, persistent=True)
print([kept(bool(i % 2)).message for i in range(4)])
kept.close()
response = switch(True)
print(hasattr(response, "message"), str(response))
for call in (
    lambda: switch(True, 5),
    lambda: switch(nope=1),
    lambda: switch("text"),
    lambda: rospy.ServiceProxy("nobody", SetBool)(True),
    lambda: rospy.ServiceProxy("refuse", Trigger)(),
    lambda: rospy.ServiceProxy("switch", Trigger)(),
    lambda: rospy.wait_for_service("nobody", 0.3),
    lambda: rospy.wait_for_service("nobody", rospy.Duration(0.3)),
):
    try:
        print("no error", call())
    except Exception as e:
        text = str(e) if "md5" not in str(e) else "other md5sum"
        print(type(e).__module__, type(e).__name__, text)
