# ruff: noqa: F403, F405
"""What a service handler may return, raise, and how proxies may be called."""

import threading

import rospy
from std_srvs.srv import *
from std_srvs.srv import SetBool, SetBoolRequest, SetBoolResponse

rospy.init_node("svc")


def h_none(r):
    return None


def h_tuple(r):
    return (True, "t")


def h_list(r):
    return [False, "l"]


def h_dict(r):
    return {"success": True, "message": "d"}


def h_baddict(r):
    return {"succes": True}


def h_short(r):
    return (True,)


def h_long(r):
    return (True, "x", 3)


def h_str(r):
    return "just text"


def h_int(r):
    return 5


def h_exc(r):
    raise RuntimeError("boom")


def h_svcexc(r):
    raise rospy.ServiceException("refused")


def h_wrongtype(r):
    return SetBoolResponse(5, 7)


def h_otherclass(r):
    return TriggerResponse(True, "other")


def h_true(r):
    return True


def h_exit(r):
    import sys

    sys.exit(3)


def h_interrupt(r):
    raise rospy.ROSInterruptException("int")


def h_empty(r):
    return []


def h_emptyd(r):
    return {}


def h_unicode(r):
    return (True, "h\u00e9llo")


for n, f in sorted(globals().copy().items()):
    if n.startswith("h_"):
        rospy.Service(n, SetBool, f)
for n in [
    "h_none",
    "h_tuple",
    "h_list",
    "h_dict",
    "h_baddict",
    "h_short",
    "h_long",
    "h_str",
    "h_int",
    "h_exc",
    "h_svcexc",
    "h_wrongtype",
    "h_otherclass",
    "h_true",
    "h_interrupt",
    "h_empty",
    "h_emptyd",
    "h_unicode",
]:
    p = rospy.ServiceProxy(n, SetBool)
    try:
        r = p(True)
        print(n, type(r).__name__, repr(r.success), repr(r.message))
    except rospy.ServiceException as e:
        print(n, "EXC", e)
    except Exception as e:
        print(n, "OTHER", type(e), e)
p = rospy.ServiceProxy("h_tuple", SetBool)
for a, k in [
    ((1,), {}),
    ((True, False), {}),
    ((), {"data": True}),
    ((), {"dat": True}),
    ((SetBoolRequest(True),), {}),
    ((), {}),
    (("x",), {}),
    ((None,), {}),
    ((TriggerRequest(),), {}),
]:
    try:
        print(a, k, p(*a, **k))
    except Exception as e:
        print(a, k, type(e).__name__, e)
print(
    p.resolved_name,
    p.service_class.__name__,
    p.request_class.__name__,
    p.response_class.__name__,
    p.persistent,
)
try:
    rospy.Service("h_tuple", SetBool, h_none)
except rospy.ServiceException as e:
    print("dup", e)
s = rospy.Service("~later", Empty, lambda r: EmptyResponse())
print(s.resolved_name, s.service_class._type, s.type if hasattr(s, "type") else "", s.done)
print(rospy.ServiceProxy("~later", Empty)())
print(repr(rospy.ServiceProxy("~later", Empty)()))
s.shutdown("no reason")
try:
    rospy.ServiceProxy("~later", Empty)()
except rospy.ServiceException as e:
    print(e)
try:
    rospy.wait_for_service("~later", timeout=0.3)
except rospy.ROSException as e:
    print(type(e), e)
try:
    rospy.wait_for_service("nothing", 0.2)
except rospy.ROSException as e:
    print(type(e), e)
try:
    rospy.wait_for_service("nothing", rospy.Duration(0.2))
except rospy.ROSException as e:
    print(type(e), e)
try:
    rospy.ServiceProxy("nothing", Empty).wait_for_service(0.1)
except rospy.ROSException as e:
    print(type(e), e)
try:
    rospy.Service("", Empty, h_none)
except Exception as e:
    print(type(e), e)
try:
    rospy.ServiceProxy("x", EmptyRequest)
except Exception as e:
    print(type(e), e)
try:
    rospy.ServiceProxy(None, Empty)
except Exception as e:
    print(type(e), e)
try:
    rospy.Service("x", Empty, None)
except Exception as e:
    print(type(e), e)
