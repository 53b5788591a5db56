"""The order of shutdown hooks, and what is possible afterwards."""

import threading

import rospy

rospy.init_node("sd")
rospy.core.add_preshutdown_hook(
    lambda r: print("pre", r, rospy.is_shutdown(), rospy.core.is_shutdown_requested())
)
rospy.on_shutdown(lambda: print("c1", rospy.is_shutdown(), rospy.core.is_shutdown_requested()))


class H:
    def __call__(self):
        print("c2")


rospy.on_shutdown(H())


def bad():
    raise RuntimeError("bad hook")


rospy.on_shutdown(bad)


def needs(x):
    print("never")


rospy.on_shutdown(needs)
rospy.on_shutdown(lambda: print("c3"))


def later():
    rospy.sleep(0.3)
    rospy.signal_shutdown("my reason")


thread = threading.Thread(target=later)
thread.start()
rospy.spin()
thread.join()  # the hooks run there
print("after spin", rospy.is_shutdown())
rospy.signal_shutdown("again")
rospy.on_shutdown(lambda: print("late hook"))
for bad in [None, 5, "x"]:
    try:
        rospy.on_shutdown(bad)
    except Exception as e:
        print(type(e), e)
r = None
try:
    rospy.Rate(10).sleep()
    print("rate slept")
except rospy.ROSInterruptException as e:
    print(repr(e))
try:
    rospy.sleep(0.1)
    print("slept")
except rospy.ROSInterruptException as e:
    print(repr(e))
try:
    rospy.loginfo("log after")
except Exception as e:
    print(repr(e))
try:
    print(rospy.get_param("/rosdistro", "none"))
except Exception as e:
    print(repr(e))
