"""diagnostic_updater: a driver that tells how it is; what is published is printed, without the times."""

import itertools
import sys

import diagnostic_updater
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from diagnostic_updater import *  # noqa: F403
from sensor_msgs.msg import Range

rospy.init_node("driver")
seen = []
rospy.Subscriber("/diagnostics", DiagnosticArray, seen.append, queue_size=100)
updater = diagnostic_updater.Updater()
while not updater.publisher.get_num_connections():
    rospy.sleep(0.02)


def show(expected):
    """Print what came, when so many statuses are there."""
    for _ in range(200):
        if sum(len(m.status) for m in seen) >= expected:
            break
        rospy.sleep(0.02)
    for message in seen:
        assert message.header.stamp.to_sec() > 0
        for s in message.status:
            times = ("Duration of window (s)", "Actual frequency (Hz)", "Earliest timestamp delay:",
                     "Latest timestamp delay:")  # fmt: skip
            values = ["%s=%s" % (v.key, "T" if v.key in times else v.value) for v in s.values]
            print(type(s.level).__name__, s.level, s.name, "|", s.message, "|", s.hardware_id, values)
    print("--", len(seen))
    del seen[:]
    sys.stdout.flush()


class Battery(diagnostic_updater.DiagnosticTask):
    """A task of the user's own."""

    def __init__(self):
        diagnostic_updater.DiagnosticTask.__init__(self, "battery")
        self.charge = 80

    def run(self, stat):
        """Low charge is bad."""
        if self.charge < 20:
            stat.summary(diagnostic_updater.DiagnosticStatus.ERROR, "low")
        else:
            stat.summary(diagnostic_updater.DiagnosticStatus.OK, "good")
        stat.add("charge", self.charge)
        stat.add("volts", 23.5)
        return stat


def mood(stat):
    """A function as a task."""
    stat.summary(WARN, "moody")  # noqa: F405
    stat.mergeSummary(ERROR, "angry")  # noqa: F405
    stat.mergeSummary(OK, "never mind")  # noqa: F405
    stat.mergeSummary(diagnostic_updater.DiagnosticStatus(level=1, message="tired"))
    return stat


def silent(stat):
    """Returns its status without a summary."""
    return stat


battery = Battery()
updater.add(battery)
updater.add("mood", mood)
updater.add(diagnostic_updater.FunctionDiagnosticTask("silent", silent))
updater.add(diagnostic_updater.Heartbeat())
show(4)
updater.setHardwareID("none" if len(sys.argv) > 5 else "robot-7")
updater.force_update()
show(4)
battery.charge = 10
updater.verbose = True
updater.force_update()
show(4)
updater.broadcast(1, "calibrating")
show(4)
print(updater.removeByName("mood"), updater.removeByName("mood"), updater.removeByName("silent"))

both = diagnostic_updater.CompositeDiagnosticTask("both")
both.addTask(battery)
both.addTask(diagnostic_updater.Heartbeat())
both.addTask(diagnostic_updater.FunctionDiagnosticTask("again", mood))
updater.add(both)
updater.verbose = False
updater.force_update()
show(4)

bounds = {"min": 0.0005, "max": 10000}  # far from what a busy machine comes to
topic = diagnostic_updater.HeaderlessTopicDiagnostic(
    "scan", updater, diagnostic_updater.FrequencyStatusParam(bounds, 0.1, 2)
)
stamped = diagnostic_updater.TopicDiagnostic(
    "odom",
    updater,
    diagnostic_updater.FrequencyStatusParam({"min": 10000}),
    diagnostic_updater.TimeStampStatusParam(-0.5, 100),
)
publisher = diagnostic_updater.DiagnosedPublisher(
    rospy.Publisher("/range", Range, queue_size=5),
    updater,
    diagnostic_updater.FrequencyStatusParam({"min": 0, "max": 0}, 0.0, 1),
    diagnostic_updater.TimeStampStatusParam(),
)
show(3)
for name in ("battery", "both", "Heartbeat"):
    updater.removeByName(name)
rospy.sleep(0.1)
updater.force_update()
show(3)
for _ in range(3):
    topic.tick()
    stamped.tick(rospy.Time.now())
    publisher.publish(Range())
stamped.tick(1.5)
stamped.tick(rospy.Time.now() + rospy.Duration(3))
publisher.publish(Range())
rospy.sleep(0.05)
updater.force_update()
show(3)
message = Range()
message.header.stamp = rospy.Time.now()
publisher.publish(message)
publisher.publish(Range())
bounds["max"] = 0.0006
topic.tick()
stamped.tick(rospy.Time.now())
updater.force_update()
show(3)
topic.clear_window()
rospy.sleep(0.02)
updater.force_update()
show(3)

rospy.set_param("~diagnostic_period", 0.3)
other = diagnostic_updater.Updater()
other.add("fine", lambda stat: (stat.clearSummary(), stat)[1])
paces = [other.last_time]
while len(seen) < 4:
    other.update()
    if paces[-1] != other.last_time:
        paces.append(other.last_time)
    rospy.sleep(0.01)
print(
    "paced:",
    all(b - a >= rospy.Duration(0.3) for a, b in itertools.pairwise(paces[1:])),
    seen[3].status[0].message == "",
)
vector = diagnostic_updater.DiagnosticTaskVector()
vector.add("x", silent)
print([t.name for t in vector.tasks], diagnostic_updater.DiagnosticStatusWrapper(level=2, name="n"))
try:
    diagnostic_updater.FrequencyStatus({"min": 1})
except AttributeError as error:
    print(error)
