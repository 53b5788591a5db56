"""Callbacks that measure rate, delay and bandwidth."""

import threading
import time
from collections import defaultdict

import rospy

from rosproto import rates

MOST = 50000  # messages in the window if no size is given


class ROSTopicHz:
    """Rate; pass `callback_hz` to Subscribers, with the topic as callback_args for several topics."""

    def __init__(self, window_size, filter_expr=None, use_wtime=False):
        self.lock = threading.Lock()
        self.filter_expr = filter_expr
        self.use_wtime = use_wtime
        self.window_size = window_size if window_size >= 0 else MOST
        self._windows = defaultdict(lambda: rates.Window(self.window_size))

    def callback_hz(self, m, topic=None):
        """Count a message."""
        if self.filter_expr is not None and not self.filter_expr(m):
            return
        with self.lock:
            _add(self._windows[topic], time.time() if self.use_wtime else rospy.get_rostime().to_sec())

    def get_hz(self, topic=None):
        """(Hz; min, max, standard deviation of the gaps in s; messages); None without a new message."""
        with self.lock:
            found = self._windows[topic].news()
        return found and (found.rate, found.least, found.most, found.deviation, found.messages)

    def get_times(self, topic=None):
        """Gaps between messages in seconds."""
        return list(self._windows[topic].values)

    def get_msg_tn(self, topic=None):
        """Arrival time of the last message in seconds."""
        return self._windows[topic].last

    def print_hz(self, topics=(None,)):
        """Print the rate of each topic."""
        with self.lock:
            found = {topic: self._windows[topic].news() for topic in topics}
        print(rates.hz_text(*found.values()) if len(topics) == 1 else rates.hz_table(found))


def _add(window, now, delay=None):
    """Add a message; a time of 0 means that simulated time restarted."""
    if now:
        window.add(now, delay)
    elif window.values:
        print("time has reset, resetting counters")
        window.values.clear()


class ROSTopicDelay:
    """Delay between a message's stamp and its arrival; pass `callback_delay` to a Subscriber."""

    def __init__(self, window_size):
        self.lock = threading.Lock()
        self.window_size = window_size if window_size >= 0 else MOST
        self._window = rates.Window(self.window_size)

    @property
    def delays(self):
        """Delays in seconds."""
        return list(self._window.values)

    def callback_delay(self, msg):
        """Count a message."""
        if not msg._has_header:
            rospy.logerr("msg does not have header")
            return
        with self.lock:
            now = rospy.get_rostime().to_sec()
            _add(self._window, now, now - msg.header.stamp.to_sec())

    def get_delay(self):
        """(mean, min, max and standard deviation in s, messages); None without a new message."""
        with self.lock:
            found = self._window.news()
        return found and (found.mean, found.least, found.most, found.deviation, found.messages)

    def print_delay(self):
        """Print the delay."""
        with self.lock:
            if self._window.values:
                print(rates.delay_text(self._window.news()))


class ROSTopicBandwidth(rates.Bandwidth):
    """Bandwidth; pass `callback` to a Subscriber of AnyMsg."""

    def __init__(self, window_size=100):
        self.lock = threading.Lock()
        self.window_size = window_size or 100
        super().__init__(self.window_size)

    def callback(self, data):
        """Count a message."""
        with self.lock:
            self.add(time.time(), len(data._buff))

    def print_bw(self):
        """Print the bandwidth."""
        with self.lock:
            text = rates.bandwidth_text(self, time.time())
        if text is not None:
            print(text)
