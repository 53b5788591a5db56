"""Options beside ROS's own arguments: argparse over myargv, private parameters that win, a required one missing."""

import argparse
import sys

import rospy
from std_msgs.msg import String


def main(argv):
    parser = argparse.ArgumentParser(prog="options", description=__doc__)
    parser.add_argument("port")
    parser.add_argument("-r", "--rate", type=float, default=10.0)
    parser.add_argument("--frame-id", default="base")
    parser.add_argument("--flag", action="store_true")
    args = parser.parse_args(argv)
    rospy.init_node("options", anonymous=True, disable_signals=False)
    rate = rospy.get_param("~rate", args.rate)
    frame = rospy.get_param("~frame_id", args.frame_id)
    print(
        args,
        rate,
        type(rate).__name__,
        frame,
        rospy.get_param("~list"),
        rospy.get_param("~text"),
        rospy.get_param("~yes"),
    )
    print(rospy.search_param("rate") is not None, rospy.search_param("no_such_thing"))
    pub = rospy.Publisher("chatter", String, queue_size=1)
    print(pub.name, rospy.resolve_name("~x").startswith(rospy.get_name()), rospy.get_param("/no/such", None))
    try:
        rospy.get_param("~required")
    except KeyError as e:
        rospy.logfatal("parameter %s is required", str(e).split("/")[-1])
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(rospy.myargv(argv=sys.argv)[1:]))
