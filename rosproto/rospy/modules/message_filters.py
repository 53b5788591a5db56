"""message_filters: Subscriber, Cache, TimeSynchronizer, ApproximateTimeSynchronizer."""

import itertools
import threading

import rospy

_HINT = "Use the 'allow_headerless' constructor option to auto-assign ROS time to headerless messages."


class SimpleFilter:
    """Base of the filters: calls callbacks with messages."""

    def __init__(self):
        self.callbacks = {}

    def registerCallback(self, cb, *args):
        """Call `cb(message, ..., *args)`; returns a handle for `disconnect`."""
        conn = len(self.callbacks)
        self.callbacks[conn] = (cb, args)
        return conn

    def signalMessage(self, *msg):
        """Call all callbacks."""
        for cb, args in list(self.callbacks.values()):
            cb(*(msg + args))


class Subscriber(SimpleFilter):
    """A topic as a filter; arguments as of rospy.Subscriber."""

    def __init__(self, *args, **kwargs):
        SimpleFilter.__init__(self)
        self.topic = args[0]
        kwargs["callback"] = self.callback
        self.sub = rospy.Subscriber(*args, **kwargs)

    def callback(self, msg):
        """A message arrived."""
        self.signalMessage(msg)

    def getTopic(self):
        """The topic's name."""
        return self.topic

    def unregister(self):
        """Unsubscribe."""
        self.sub.unregister()

    def __getattr__(self, key):
        return getattr(self.sub, key)


def _stamp(message, allow_headerless):
    if hasattr(getattr(message, "header", None), "stamp"):
        return message.header.stamp
    return rospy.Time.now() if allow_headerless else None


class Cache(SimpleFilter):
    """The last messages of a filter, by time."""

    def __init__(self, f, cache_size=1, allow_headerless=False):
        SimpleFilter.__init__(self)
        self.cache_size = cache_size
        self.allow_headerless = allow_headerless
        self.cache_msgs = []
        self.cache_times = []
        self.connectInput(f)

    def connectInput(self, f):
        """Take messages of that filter."""
        self.incoming_connection = f.registerCallback(self.add)

    def add(self, msg):
        """Take a message."""
        stamp = _stamp(msg, self.allow_headerless)
        if stamp is None:
            rospy.logwarn("Cannot use message filters with non-stamped messages. " + _HINT)
            return
        self.cache_times.append(stamp)
        self.cache_msgs.append(msg)
        if len(self.cache_times) > self.cache_size:
            del self.cache_times[0]
            del self.cache_msgs[0]
        self.signalMessage(msg)

    def getInterval(self, from_stamp, to_stamp):
        """Messages between two times."""
        assert from_stamp <= to_stamp
        pairs = zip(self.cache_times, self.cache_msgs)
        return [message for stamp, message in pairs if from_stamp <= stamp <= to_stamp]

    def getElemAfterTime(self, stamp):
        """The oldest one not before a time; None when there is none."""
        return next((m for t, m in zip(self.cache_times, self.cache_msgs) if t >= stamp), None)

    def getElemBeforeTime(self, stamp):
        """The newest one not after a time; None when there is none."""
        older = [m for t, m in zip(self.cache_times, self.cache_msgs) if t <= stamp]
        return older[-1] if older else None

    def getLatestTime(self):
        """Time of the newest; None when there is none."""
        return self.cache_times[-1] if self.cache_times else None

    getLastestTime = getLatestTime  # its first name

    def getOldestTime(self):
        """Time of the oldest; None when there is none."""
        return self.cache_times[0] if self.cache_times else None

    def getLast(self):
        """The newest; None when there is none."""
        return self.getElemAfterTime(self.getLastestTime()) if self.cache_times else None


class TimeSynchronizer(SimpleFilter):
    """Groups messages of several filters that have the same stamp."""

    def __init__(self, fs, queue_size, reset=False):
        SimpleFilter.__init__(self)
        self.queue_size = queue_size
        self.enable_reset = reset
        self.lock = threading.Lock()
        self.connectInput(fs)

    def connectInput(self, fs):
        """Take messages of those filters."""
        self.queues = [{} for _ in fs]
        self.latest_stamps = [rospy.Time(0) for _ in fs]
        self.input_connections = [
            f.registerCallback(self.add, queue, index)
            for index, (f, queue) in enumerate(zip(fs, self.queues))
        ]

    def add(self, msg, my_queue, my_queue_index=None):
        """Take a message."""
        with self.lock:
            settled = self._settled_after_jump(my_queue, my_queue_index)
            self._keep(my_queue, msg.header.stamp, msg)
            if settled:
                for stamp in sorted(set.intersection(*map(set, self.queues))):
                    self._signal([stamp] * len(self.queues))

    def _settled_after_jump(self, queue, index):
        """With `reset`, clear a queue when simulated time jumped back; True when all queues are settled."""
        if not self.enable_reset or rospy.rostime.is_wallclock():
            return True
        now = rospy.Time.now()
        if index is not None:
            if now < self.latest_stamps[index]:
                rospy.logdebug("Detected jump back in time. Clearing message filter queue")
                queue.clear()
            self.latest_stamps[index] = now
        return max(self.latest_stamps) == now

    def _keep(self, queue, stamp, message):
        queue[stamp] = message
        while len(queue) > self.queue_size:
            del queue[min(queue)]

    def _signal(self, stamps):
        self.signalMessage(*[queue.pop(stamp) for queue, stamp in zip(self.queues, stamps)])


class ApproximateTimeSynchronizer(TimeSynchronizer):
    """Groups messages of several filters whose stamps differ by less than `slop` seconds.

    When the clock jumps back, all kept messages are dropped, also the new one.
    """

    def __init__(self, fs, queue_size, slop, allow_headerless=False, reset=False):
        TimeSynchronizer.__init__(self, fs, queue_size, reset)
        self.slop = rospy.Duration.from_sec(slop)
        self.allow_headerless = allow_headerless
        self.last_added = rospy.Time()

    def add(self, msg, my_queue, my_queue_index=None):
        """Take a message."""
        stamp = _stamp(msg, self.allow_headerless)
        if stamp is None:
            rospy.logwarn(
                "Cannot use message filters with non-stamped messages. " + _HINT,
            )
            return
        with self.lock:
            settled = self._settled_after_jump(my_queue, my_queue_index)
            self._keep(my_queue, stamp, msg)
            now = rospy.Time.now()
            if now < self.last_added:
                rospy.loginfo("ApproximateTimeSynchronizer: Detected jump back in time. Clearing buffer.")
                for queue in self.queues:
                    queue.clear()
            self.last_added = now
            if settled:
                self._match(stamp, my_queue_index)

    def _match(self, stamp, index):
        """The combination nearest to the new message wins."""
        candidates = []
        for i, queue in enumerate(self.queues):
            near = [stamp] if i == index else [s for s in queue if abs(s - stamp) <= self.slop]
            if not near:
                return
            candidates.append(sorted(near, key=lambda s: abs(s - stamp)))
        for stamps in itertools.product(*candidates):
            if max(stamps) - min(stamps) < self.slop and all(s in q for s, q in zip(stamps, self.queues)):
                self._signal(stamps)
                return
