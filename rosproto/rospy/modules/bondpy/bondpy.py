"""bondpy.bondpy: Bond.

Source: bond_core 1.8 (bondpy.py and its state machine). One thread publishes and looks at the time limit,
where bondpy has a timer for each limit. The heartbeat's limit begins when the bond is formed, so that a peer
that ends after its first message is noticed; bondpy begins it with the second message.
"""

import threading
import time
import uuid

import rospy
from bond.msg import Constants, Status

# WAITING -> ALIVE when the other end is heard; -> DEAD when it says that it ends, or is silent for too long.
# A bond that is broken here is DYING until the other end confirms, at most for `disconnect_timeout`.
WAITING, ALIVE, DYING, DEAD = "SM.WaitingForSister", "SM.Alive", "SM.AwaitSisterDeath", "SM.Dead"


def _seconds(duration):
    return duration.to_sec() if isinstance(duration, rospy.Duration) else float(duration)


class Bond:
    """One end of a bond; `start` connects it.

    `on_formed()` and `on_broken()` are called in a thread of the library, without a lock.
    """

    def __init__(self, topic, id, on_broken=None, on_formed=None):
        self.topic, self.id = topic, id
        self.on_broken, self.on_formed = on_broken, on_formed
        self.instance_id = str(uuid.uuid4())
        self.sister_instance_id = None
        self.is_shutdown = False
        self.connect_timeout = Constants.DEFAULT_CONNECT_TIMEOUT
        self.heartbeat_timeout = Constants.DEFAULT_HEARTBEAT_TIMEOUT
        self.disconnect_timeout = Constants.DEFAULT_DISCONNECT_TIMEOUT
        self.heartbeat_period = Constants.DEFAULT_HEARTBEAT_PERIOD
        self.lock = threading.RLock()
        self.condition = threading.Condition(self.lock)
        self._state = WAITING
        self._deadline = None
        self._due = []  # callbacks, called when the lock is released
        self.sub = None
        self.pub = rospy.Publisher(topic, Status, queue_size=1)

    def start(self):
        """Connect to the other end."""
        self._expect_within(self.connect_timeout)
        self.sub = rospy.Subscriber(self.topic, Status, self._heard)
        threading.Thread(target=self._run, name="bond", daemon=True).start()

    def shutdown(self):
        """Break the bond and end."""
        if self.is_shutdown:
            return
        self.is_shutdown = True
        if self.sub is not None:
            self.sub.unregister()  # first, as in bondpy: an answer to the end is not heard
        self.break_bond()
        self.pub.unregister()

    def break_bond(self):
        """Break the bond; the other end is told."""
        with self.condition:
            if self._state == WAITING:
                self._die()
            elif self._state == ALIVE:
                self._state = DYING
                self._expect_within(self.disconnect_timeout)
                self.condition.notify_all()
            self._publish(False)
        self._call_back()

    def is_broken(self):
        """True when the bond was broken."""
        return self._state == DEAD

    def wait_until_formed(self, timeout=None):
        """Wait until the bond is formed, at most `timeout` (a Duration or seconds); True when it was."""
        return self._wait(lambda: self._state != WAITING, timeout)

    def wait_until_broken(self, timeout=None):
        """The same until it is broken."""
        return self._wait(self.is_broken, timeout)

    def set_formed_callback(self, on_formed):
        """Replace the callback."""
        self.on_formed = on_formed

    def set_broken_callback(self, on_broken):
        """Replace the callback."""
        self.on_broken = on_broken

    def __repr__(self):
        return "[Bond %s, Instance %s (%s)]" % (self.id, self.instance_id, self._state)

    def _wait(self, reached, timeout):
        end = time.monotonic() + _seconds(timeout) if timeout else None
        with self.condition:
            while not reached() and not rospy.is_shutdown():
                left = 0.1 if end is None else min(0.1, end - time.monotonic())
                if left <= 0:
                    break
                self.condition.wait(left)
            return reached()

    def _expect_within(self, duration):
        self._deadline = time.monotonic() + _seconds(duration)

    def _die(self):
        self._state = DEAD
        self._due.append(self.on_broken)
        self.condition.notify_all()

    def _heard(self, msg):
        if msg.id != self.id or msg.instance_id == self.instance_id:
            return
        with self.condition:
            self.sister_instance_id = self.sister_instance_id or msg.instance_id
            if msg.instance_id != self.sister_instance_id:
                rospy.logerr(
                    "More than two locations are trying to use a single bond (topic: %s, id: %s).  You "
                    "should only instantiate at most two bond instances for each (topic, id) pair.",
                    self.topic,
                    self.id,
                )
                return
            before = self._state
            if before == WAITING:
                self._state = ALIVE
                self._due.append(self.on_formed)
                self.condition.notify_all()
            if self._state == ALIVE and msg.active:
                self._expect_within(self.heartbeat_timeout)
            elif not msg.active and before != DEAD:
                self._die()
                if before != DYING:
                    self._publish(False)  # at once, so that the other end need not wait
        self._call_back()

    def _publish(self, active):
        if rospy.is_shutdown() or not rospy.core.is_initialized():
            return
        msg = Status(id=self.id, instance_id=self.instance_id, active=active)
        msg.header.stamp = rospy.Time.now()
        msg.heartbeat_timeout = _seconds(self.heartbeat_timeout)
        msg.heartbeat_period = _seconds(self.heartbeat_period)
        self.pub.publish(msg)

    def _run(self):
        while self._state != DEAD and not rospy.is_shutdown():
            with self.condition:
                if time.monotonic() >= self._deadline:
                    self._late()
                if self._state != DEAD and not self.is_shutdown:
                    dying = self._state == DYING
                    self._publish(not dying)
                    period = Constants.DEAD_PUBLISH_PERIOD if dying else _seconds(self.heartbeat_period)
                    self.condition.wait(max(0.0, min(period, self._deadline - time.monotonic())))
                elif self._state != DEAD:
                    self.condition.wait(max(0.0, self._deadline - time.monotonic()))
            self._call_back()

    def _late(self):
        """The other end was not heard in time."""
        if self._state == ALIVE and rospy.get_param(Constants.DISABLE_HEARTBEAT_TIMEOUT_PARAM, False):
            rospy.logwarn(
                "Heartbeat timeout is disabled.  Not breaking bond (topic: %s, id: %s)", self.topic, self.id
            )
            self._expect_within(self.heartbeat_timeout)
            return
        self._die()

    def _call_back(self):
        with self.lock:
            due, self._due = self._due, []
        for callback in due:
            if callback:
                callback()
