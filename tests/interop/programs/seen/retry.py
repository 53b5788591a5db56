"""A client of a flaky service: wait, retry, persistent connections that break, errors told apart."""

import rospy
from rospy import ServiceException
from std_srvs.srv import Empty, EmptyResponse, SetBool, Trigger, TriggerResponse

rospy.init_node("retry")
calls = {"n": 0}


def flaky(req):
    calls["n"] += 1
    if calls["n"] % 3:
        raise rospy.ServiceException("not yet (%d)" % calls["n"])
    return TriggerResponse(True, "after %d" % calls["n"])


def broken(req):
    return None


def with_headers(req):
    header = req._connection_header
    return TriggerResponse(
        True,
        "%s %s %s"
        % (
            header["callerid"] == rospy.get_name(),
            header.get("persistent", "0"),
            header["service"].split("/")[-1],
        ),
    )


services = [
    rospy.Service("flaky", Trigger, flaky),
    rospy.Service("broken", Trigger, broken),
    rospy.Service("headers", Trigger, with_headers),
]
rospy.Service("nothing", Empty, lambda req: EmptyResponse())


def call_with_retry(name, kind, tries=5):
    proxy = rospy.ServiceProxy(name, kind)
    for attempt in range(tries):
        try:
            rospy.wait_for_service(name, timeout=2.0)
            return attempt, proxy()
        except ServiceException as e:
            print("call failed:", e)
        except rospy.ROSException as e:
            print("not there:", str(e).split("/")[0])
            return attempt, None
    return tries, None


print(call_with_retry("flaky", Trigger))
print(call_with_retry("broken", Trigger, 2))
print(call_with_retry("absent", Trigger))
print(repr(rospy.ServiceProxy("nothing", Empty)()), rospy.ServiceProxy("headers", Trigger)().message)
persistent = rospy.ServiceProxy("headers", Trigger, persistent=True)
print(persistent().message, persistent.call().message)
persistent.close()
try:
    rospy.ServiceProxy("headers", SetBool)(True)
except Exception as e:
    print(type(e).__name__, "md5sum" in str(e))
for wrong in (lambda: rospy.ServiceProxy("headers", Trigger)(1), lambda: rospy.ServiceProxy("headers", Trigger)(x=1),
              lambda: rospy.Service("flaky", Trigger, flaky), lambda: rospy.ServiceProxy("s", SetBool)("a", "b")):  # fmt: skip
    try:
        wrong()
    except Exception as e:
        print(type(e).__name__, str(e).replace(rospy.get_namespace(), "/")[:70])
services[0].shutdown("enough")
try:
    rospy.wait_for_service("flaky", timeout=0.3)
except rospy.ROSException as e:
    print("gone")
