"""Callbacks that measure rate, delay and bandwidth."""

import math
import threading
import time

import rospy

MOST = 50000  # values kept without a given window


def _summary(values):
    """(mean, least, greatest, standard deviation)."""
    mean = sum(values) / len(values)
    deviation = math.sqrt(sum((value - mean) ** 2 for value in values) / len(values))
    return mean, min(values), max(values), deviation


class _Series:
    """The values of one topic, and when the first and last message came, seconds."""

    def __init__(self):
        self.values = []
        self.first, self.last, self.told = -1, 0, 0

    def take(self, now, value, window):
        """Note a message; the first one, and one from the past, start a new series without a value."""
        if self.first < 0 or self.first > now:
            self.first, self.values = now, []
        else:
            self.values.append(now - self.last if value is None else value)
        self.last = now
        if len(self.values) > window - 1:
            del self.values[0]

    def take_zero(self):
        """Simulated time has restarted."""
        if self.values:
            print("time has reset, resetting counters")
            self.values = []

    def summary(self):
        """As `_summary`; None when there is nothing new."""
        if not self.values or self.last == self.told:
            return None
        self.told = self.last
        return _summary(self.values)


class ROSTopicHz:
    """Rate: give `callback_hz` to Subscribers, with the topic as callback_args when there are several."""

    def __init__(self, window_size, filter_expr=None, use_wtime=False):
        self.lock = threading.Lock()
        self.filter_expr = filter_expr
        self.use_wtime = use_wtime
        self.window_size = window_size if window_size >= 0 else MOST
        self._topics = {}

    def _series(self, topic):
        return self._topics.setdefault(topic, _Series())

    def callback_hz(self, m, topic=None):
        """Count a message."""
        if self.filter_expr is not None and not self.filter_expr(m):
            return
        with self.lock:
            now = time.time() if self.use_wtime else rospy.get_rostime().to_sec()
            if now == 0:
                self._series(topic).take_zero()
            else:
                self._series(topic).take(now, None, self.window_size)

    def get_hz(self, topic=None):
        """(rate, least, greatest, deviation of the gaps in seconds, messages); None without a new message."""
        with self.lock:
            series = self._series(topic)
            found = series.summary()
            if found is None:
                return None
            mean, least, greatest, deviation = found
            return 1.0 / mean if mean > 0 else 0, least, greatest, deviation, len(series.values) + 1

    def get_times(self, topic=None):
        """The gaps between messages, seconds."""
        return self._series(topic).values

    def get_msg_tn(self, topic=None):
        """When the last one came, seconds."""
        return self._series(topic).last

    def print_hz(self, topics=(None,)):
        """Print it."""
        found = [(topic, self.get_hz(topic)) for topic in topics]
        found = [(topic, hz) for topic, hz in found if hz is not None]
        if not found:
            print("no new messages")
        elif len(topics) == 1:
            print("average rate: %.3f\n\tmin: %.3fs max: %.3fs std dev: %.5fs window: %s" % found[0][1])
        else:
            print(_table(found))


def _table(found):
    """A row per topic."""
    titles = ("topic", "rate", "min_delta", "max_delta", "std_dev", "window")
    rows = [(str(topic), *["%.4g" % value for value in hz[:4]], str(hz[4])) for topic, hz in found]
    widths = [max(map(len, column)) for column in zip(titles, *rows)]
    lines = ["   ".join(title.center(width) for title, width in zip(titles, widths))]
    lines.append("=" * (sum(widths) + 3 * (len(titles) - 1)))
    lines += ["   ".join(cell.ljust(width) for cell, width in zip(row, widths)) for row in rows]
    return "\n".join(lines) + "\n"


class ROSTopicDelay:
    """Delay between a message's stamp and its arrival: give `callback_delay` to a Subscriber."""

    def __init__(self, window_size):
        self.lock = threading.Lock()
        self.window_size = window_size if window_size >= 0 else MOST
        self._series = _Series()

    @property
    def delays(self):
        """Seconds."""
        return self._series.values

    def callback_delay(self, msg):
        """Count a message."""
        if not msg._has_header:
            rospy.logerr("msg does not have header")
            return
        with self.lock:
            now = rospy.get_rostime().to_sec()
            if now == 0:
                self._series.take_zero()
            else:
                self._series.take(now, now - msg.header.stamp.to_sec(), self.window_size)

    def get_delay(self):
        """(mean, least, greatest, deviation in seconds, messages); None without a new message."""
        with self.lock:
            found = self._series.summary()
            return None if found is None else (*found, len(self.delays) + 1)

    def print_delay(self):
        """Print it."""
        if not self.delays:
            return
        found = self.get_delay()
        text = "average delay: %.3f\n\tmin: %.3fs max: %.3fs std dev: %.5fs window: %s"
        print("no new messages" if found is None else text % found)


class ROSTopicBandwidth:
    """Bytes: give `callback` to a Subscriber of AnyMsg."""

    def __init__(self, window_size=100):
        self.lock = threading.Lock()
        self.window_size = window_size or 100
        self.sizes, self.times = [], []

    def callback(self, data):
        """Count a message."""
        with self.lock:
            self.times.append(time.time())
            self.sizes.append(len(data._buff))
            if len(self.times) > self.window_size:
                del self.times[0], self.sizes[0]

    def print_bw(self):
        """Print it."""
        with self.lock:
            count = len(self.times)
            if count < 2:
                return
            rate = sum(self.sizes) / (time.time() - self.times[0])
            values = rate, sum(self.sizes) / count, min(self.sizes), max(self.sizes)
        unit, scale = ("B", 1) if rate < 1e3 else ("KB", 1e3) if rate < 1e6 else ("MB", 1e6)
        texts = ["%.2f%s" % (value / scale, unit) for value in values]
        print("average: %s/s\n\tmean: %s min: %s max: %s window: %s" % (*texts, count))
