"""message_filters by random messages and clocks, without a node: `filters_random.py SEED CASES` prints all."""

import random
import sys

import message_filters
import rospy


class Stamp:
    def __init__(self, stamp):
        self.stamp = stamp


class Stamped:
    def __init__(self, number, stamp):
        self.number, self.header = number, Stamp(stamp)


class Headerless:
    def __init__(self, number):
        self.number = number


def synchronizer(filters):
    size, reset = draw.choice([1, 2, 5, 10]), draw.random() < 0.5
    kind = draw.choice(["exact", "approximate", "headerless"])
    print(kind, len(filters), size, reset)
    if kind == "exact":
        return message_filters.TimeSynchronizer(filters, size, reset=reset)
    slop, headerless = draw.choice([0.05, 0.1, 1.0, 3.0]), kind == "headerless"
    return message_filters.ApproximateTimeSynchronizer(filters, size, slop, headerless, reset)


def set_clock():
    global clock
    step = draw.choice([0, 0, 0.01, 0.1, 1, 1, -0.001, -0.1, -5])
    clock = max(1.0, clock + step)
    rospy.rostime._set_rostime(rospy.Time.from_sec(clock))


def case(steps):
    filters = [message_filters.SimpleFilter() for _ in range(draw.choice([1, 2, 2, 3]))]
    both = synchronizer(filters)
    both.registerCallback(lambda *messages: print("  together", [message.number for message in messages]))
    headerless = isinstance(both, message_filters.ApproximateTimeSynchronizer)
    set_clock()
    cache = message_filters.Cache(filters[0], draw.choice([1, 3]), allow_headerless=True)
    for number in range(steps):
        set_clock()
        if headerless and draw.random() < 0.1:
            message = Headerless(number)
        else:
            stamp = clock + draw.choice([0, 0, 0, -0.04, -0.1, -0.5, -1])
            message = Stamped(number, rospy.Time.from_sec(round(max(0.0, stamp), draw.choice([0, 1, 3]))))
        draw.choice(filters).signalMessage(message)
        print([sorted((str(stamp), m.number) for stamp, m in queue.items()) for queue in both.queues])
    print([message.number for message in cache.getInterval(rospy.Time(0), rospy.Time(100000))])


draw = random.Random(int(sys.argv[1]))
clock = 100.0
rospy.rostime.set_rostime_initialized(True)
for _ in range(int(sys.argv[2])):
    case(60)
