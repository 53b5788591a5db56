"""Tasks, and the Updater that runs them periodically and publishes their statuses."""

import threading

import rospy
from diagnostic_msgs.msg import DiagnosticArray

from ._diagnostic_status_wrapper import ERROR, OK, DiagnosticStatusWrapper


class DiagnosticTask:
    """Something with a name that fills a status; derive from it, or use FunctionDiagnosticTask."""

    def __init__(self, name):
        self.name = name

    def getName(self):
        """Its name."""
        return self.name

    def run(self, stat):
        """Fill a DiagnosticStatusWrapper and return it."""
        return stat


class FunctionDiagnosticTask(DiagnosticTask):
    """A task that is a function `fn(stat)`, which returns `stat`."""

    def __init__(self, name, fn):
        super().__init__(name)
        self.fn = fn

    def run(self, stat):
        """Call the function."""
        return self.fn(stat)


class CompositeDiagnosticTask(DiagnosticTask):
    """Several tasks that fill one status; their summaries are merged."""

    def __init__(self, name):
        super().__init__(name)
        self.tasks = []

    def addTask(self, t):
        """Add a task."""
        self.tasks.append(t)

    def run(self, stat):
        """Run each on the status as it was, then set the merged summary."""
        before, merged = DiagnosticStatusWrapper(), DiagnosticStatusWrapper()
        before.summary(stat)
        for task in self.tasks:
            stat.summary(before)
            stat = task.run(stat)
            merged.mergeSummary(stat)
        stat.summary(merged)
        return stat


_NO_HARDWARE = (
    "diagnostic_updater: No HW_ID was set. This is probably a bug. Please report it. For devices that do not "
    "have a HW_ID, set this value to 'none'. This warning only occurs once all diagnostics are OK so it is "
    "okay to wait until the device is open before calling setHardwareID."
)


def _status(name):
    status = DiagnosticStatusWrapper()
    status.name = name
    return status


class DiagnosticTaskVector:
    """A list of tasks."""

    class DiagnosticTaskInternal:
        """A name and a function."""

        def __init__(self, name, fn):
            self.name = name
            self.fn = fn

        def run(self, stat):
            """Call it on a status of that name."""
            stat.name = self.name
            return self.fn(stat)

    def __init__(self):
        self.tasks = []
        self.lock = threading.Lock()

    def addedTaskCallback(self, task):
        """Called when a task was added."""

    def add(self, *args):
        """Add a task: `add(task)`, or `add(name, function)`."""
        name, function = args if len(args) == 2 else (args[0].getName(), args[0].run)
        task = self.DiagnosticTaskInternal(name, function)
        with self.lock:
            self.tasks.append(task)
            self.addedTaskCallback(task)

    def removeByName(self, name):
        """Remove the first task of that name; True when there was one."""
        with self.lock:
            found = next((task for task in self.tasks if task.name == name), None)
            if found is not None:
                self.tasks.remove(found)
            return found is not None


class Updater(DiagnosticTaskVector):
    """Runs its tasks every `~diagnostic_period` seconds (1); call `update` more often than that."""

    def __init__(self):
        super().__init__()
        self.publisher = rospy.Publisher("/diagnostics", DiagnosticArray, queue_size=10)
        self.last_time = self.last_time_period_checked = rospy.Time.now()
        self.period = 1
        self.verbose = False
        self.hwid = ""
        self.warn_nohwid_done = False

    def setHardwareID(self, hwid):
        """Name of the device; "none" when there is none."""
        self.hwid = hwid

    def update(self):
        """Run the tasks and publish, if the period has passed."""
        now = rospy.Time.now()
        if now >= self.last_time_period_checked + rospy.Duration(0.25):
            self.period = rospy.get_param_cached("~diagnostic_period", 1)
            self.last_time_period_checked = now
        if rospy.Time.now() >= self.last_time + rospy.Duration(self.period):
            self.force_update()

    def force_update(self):
        """Run and publish now."""
        self.last_time = rospy.Time.now()
        found = []
        with self.lock:
            for task in self.tasks:
                status = _status(task.name)
                status.summary(ERROR, "No message was set")
                status.hardware_id = self.hwid
                task.run(status)
                found.append(status)
                if self.verbose and status.level:
                    rospy.logwarn(
                        "Non-zero diagnostic status. Name: '%s', status %i: '%s'"
                        % (status.name, status.level, status.message)
                    )
        if not self.hwid and not self.warn_nohwid_done and not any(status.level for status in found):
            rospy.logwarn(_NO_HARDWARE)
            self.warn_nohwid_done = True
        self.publish(found)

    def broadcast(self, lvl, msg):
        """Publish one level and message for all tasks, without running them."""
        found = [_status(task.name) for task in self.tasks]
        for status in found:
            status.summary(lvl, msg)
        self.publish(found)

    def publish(self, msg):
        """Publish a status or a list of them; the node's name is put before theirs."""
        found = msg if type(msg) is list else [msg]
        for status in found:
            status.name = rospy.get_name()[1:] + ": " + status.name
        message = DiagnosticArray(status=found)
        message.header.stamp = rospy.Time.now()
        self.publisher.publish(message)

    def addedTaskCallback(self, task):
        """Publish that it is starting up."""
        status = _status(task.name)
        status.summary(OK, "Node starting up")
        self.publish(status)
