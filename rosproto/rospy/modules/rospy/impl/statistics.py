"""rospy.impl.statistics: the traffic of each subscriber link on /statistics, if /enable_statistics is set.

The first report of a link comes with its first message, later ones every second; the pace adapts to how many
messages a report covers (wiki.ros.org/Topics, "Topic statistics").
"""

import math

from rosgraph_msgs.msg import TopicStatistics

from .. import core, names, rostime

_UNWATCHED = ("/clock", "/statistics")


def of_subscriber(impl):
    """The statistics of a subscriber; None when they are off."""
    from rospy import client

    if impl.resolved_name in _UNWATCHED:
        return None
    try:
        wanted = client.get_param_cached("/enable_statistics", False)  # get_param calls the master each time
    except Exception:  # without a master, the subscriber works without statistics
        return None
    return SubscriberStatistics(impl) if wanted else None


class SubscriberStatistics:
    """The links of one subscriber."""

    def __init__(self, impl):
        from rospy import client

        self._impl = impl
        self._links = {}
        ask = client.get_param
        self.min_elements = ask("/statistics_window_min_elements", 10)
        self.max_elements = ask("/statistics_window_max_elements", 100)
        self.min_window = ask("/statistics_window_min_size", 4)
        self.max_window = ask("/statistics_window_max_size", 64)

    def note(self, message):
        """Count a message."""
        publisher = (message._connection_header or {}).get("callerid", "unknown")
        try:
            link = self._links.get(publisher)
            if link is None:
                link = self._links[publisher] = _Link(self._impl.resolved_name, publisher)
            link.note(message, self)
        except Exception as error:
            core.logerr("Unexpected error during statistics measurement: %s", str(error))

    def received(self, publisher):
        """Bytes received from a publisher."""
        return sum(link.bytes for link in self._impl.handle.stats() if link.peer == publisher)

    def close(self):
        """Stop publishing statistics."""
        for link in self._links.values():
            link.publisher.unregister()
        self._links.clear()


class _Link:
    def __init__(self, topic, publisher):
        from rospy import topics

        self._topic = topic
        self._from = publisher
        self.publisher = topics.Publisher("/statistics", TopicStatistics, queue_size=10)
        self._sent = rostime.Time(0)
        self._per_second = 1.0
        self._bytes = 0
        self._seq = 0
        self._begin(rostime.Time.now())

    def _begin(self, now):
        self._since = now
        self._arrivals = []
        self._ages = []
        self._lost = 0

    def note(self, message, owner):
        now = rostime.Time.now()
        self._arrivals.append(now)
        if getattr(message, "_has_header", False):
            self._ages.append(now - message.header.stamp)
            self._lost += message.header.seq != self._seq + 1
            self._seq = message.header.seq
        if self._sent + rostime.Duration(1.0 / self._per_second) < now:
            self._sent = now
            self._report(now, owner)

    def _report(self, now, owner):
        received = owner.received(self._from)
        message = TopicStatistics(topic=self._topic, node_pub=self._from, node_sub=names.get_name())
        message.window_start, message.window_stop = self._since, now
        message.delivered_msgs, message.dropped_msgs = len(self._arrivals), self._lost
        message.traffic = received - self._bytes
        _summarize(message, "stamp_age", self._ages)
        _summarize(message, "period", [b - a for a, b in zip(self._arrivals, self._arrivals[1:])])
        self.publisher.publish(message)
        window = 1.0 / self._per_second
        if len(self._arrivals) > owner.max_elements and window / 2 >= owner.min_window:
            self._per_second *= 2
        if len(self._arrivals) < owner.min_elements and window * 2 <= owner.max_window:
            self._per_second /= 2
        self._bytes = received
        self._begin(now)


def _summarize(message, prefix, durations):
    if not durations:
        return
    values = [duration.to_sec() for duration in durations]
    mean = sum(values) / len(values)
    deviation = math.sqrt(sum((value - mean) ** 2 for value in values) / len(values))
    setattr(message, prefix + "_mean", rostime.Duration(mean))
    setattr(message, prefix + "_stddev", rostime.Duration(deviation))
    setattr(message, prefix + "_max", rostime.Duration(max(values)))


SubscriberStatisticsLogger = SubscriberStatistics  # as rospy calls it
