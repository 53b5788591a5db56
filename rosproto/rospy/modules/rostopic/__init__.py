"""rostopic's functions for programs: types, peers, rates and bandwidth of topics, fields of messages."""

import sys
import threading
import time
from collections import defaultdict

import rosgraph
import rospy
from genpy.message import (
    MessageException,
    fill_message_args,
    get_message_class,
    get_printable_message_args,
    strify_message,
)

from rosproto import rates

MAX_WINDOW_MESSAGES = 50000  # messages in the window if no size is given
_PARTS = ("start", "stop", "step")


class ROSTopicException(Exception):
    """A topic or its type cannot be used."""


class ROSTopicIOException(ROSTopicException):
    """The master cannot be reached."""


def _types():
    try:
        return rosgraph.Master("/rostopic").getTopicTypes()
    except OSError:
        raise ROSTopicIOException("Unable to communicate with master!") from None


def get_topic_type(topic, blocking=False):
    """(type, topic, function) of a topic, or of a field appended to its name; Nones if unknown.

    The function extracts the field from a message; None without a field.
    """
    found = _get_topic_type(topic)
    if blocking and found[0] is None:
        sys.stderr.write("WARNING: topic [%s] does not appear to be published yet\n" % topic)
        while found[0] is None and not rospy.is_shutdown():
            time.sleep(0.1)
            found = _get_topic_type(topic)
    return found


def _get_topic_type(topic):
    known = dict(_types())
    name = topic if topic in known else None
    if name is None:
        # Longest name first; skip topics whose messages do not have the field.
        below = sorted((one for one in known if topic.startswith(one + "/")), reverse=True)
        name = next((one for one in below if _has_field(known[one], topic[len(one) + 1 :])), None)
    if name is None or known[name] == "*":
        return None, None, None
    return known[name], name, msgevalgen(topic[len(name) :])


def _has_field(type_, path):
    """True if messages of a type have the field (up to the first bracket), or the type is unknown."""
    found = get_message_class(type_)
    message = found() if found else None
    for name in path.rstrip("/").partition("[")[0].split("/"):
        if message is None or not name:
            break
        if not hasattr(message, name):
            return False
        message = getattr(message, name)
    return True


def get_topic_class(topic, blocking=False):
    """(class, topic, None) of a topic; Nones if unknown."""
    type_, name, function = get_topic_type(topic, blocking)
    if type_ is None:
        return None, None, None
    found = get_message_class(type_)
    if not found:
        raise ROSTopicException("Cannot load message class for [%s]. Are your messages built?" % type_)
    return found, name, function


def find_by_type(topic_type):
    """Names of the topics of a type."""
    return [name for name, type_ in _types() if type_ == topic_type]


def get_topic_list(master=None):
    """Return ([(topic, type, [publishers])], [(topic, type, [subscribers])])."""
    master = master or rosgraph.Master("/rostopic")
    try:
        publishers, subscribers, _ = master.getSystemState()
        types = dict(master.getTopicTypes())
    except OSError:
        raise ROSTopicIOException("Unable to communicate with master!") from None
    return tuple(
        [(topic, types.get(topic, "unknown type"), nodes) for topic, nodes in table]
        for table in (publishers, subscribers)
    )


def get_api(master, caller_id):
    """URI of a node, or a text for an unknown node."""
    try:
        return master.lookupNode(caller_id)
    except rosgraph.MasterError:
        return "unknown address %s" % caller_id
    except OSError:
        raise ROSTopicIOException("Unable to communicate with master!") from None


def get_info_text(topic):
    """Output of `rostopic info`: type, publishers and subscribers."""
    master = rosgraph.Master("/rostopic")
    tables = [[row for row in table if row[0] == topic] for table in get_topic_list(master)]
    if not any(tables):
        raise ROSTopicException("Unknown topic %s" % topic)
    text = "Type: %s\n\n" % next(row[1] for table in tables for row in table)
    for title, table in zip(("Publishers", "Subscribers"), tables):
        nodes = [node for row in table for node in row[2]]
        text += "%s: %s\n" % (title, "" if nodes else "None")
        text += "".join(" * %s (%s)\n" % (node, get_api(master, node)) for node in nodes) + "\n"
    return text


def create_publisher(topic_name, topic_type, latch, disable_rostime=True):
    """(publisher, class) for a type name; starts the node /rostopic_... if this process has no node."""
    try:
        found = get_message_class(topic_type)
    except ValueError:
        raise ROSTopicException("invalid topic type: %s" % topic_type) from None
    if found is None:
        raise ROSTopicException(
            "invalid message type: %s.\nIf this is a valid message type, give its folder by --msg-path"
            % topic_type
        )
    rospy.init_node("rostopic", anonymous=True, disable_rosout=True, disable_rostime=disable_rostime)
    name = rosgraph.names.script_resolve_name("rostopic", topic_name)
    return rospy.Publisher(name, found, latch=latch, queue_size=100), found


ONCE_SECONDS = 3.0  # how long a message published once stays


def publish_message(
    pub, msg_class, pub_args, rate=None, once=False, verbose=False, substitute_keywords=False
):
    """Publish a list of values: latched (until the node ends, or only said to be with `once`), or at a rate.

    "now" and "auto" mean the present time and a header of it.
    """
    message = msg_class()
    _fill(message, pub_args)
    try:
        if rate is None:
            what = "publishing and latching [%s]" % message if verbose else "publishing and latching message"
            how = " for %s seconds" % ONCE_SECONDS if once else ". Press ctrl-C to terminate"
            print(what + how)
            pub.publish(message)
            if not once:
                rospy.spin()
            return
        pause = rospy.Rate(_hertz(rate))
        while not rospy.is_shutdown():
            if substitute_keywords:
                _fill(message, pub_args)
            if verbose:
                print("publishing %s" % message)
            pub.publish(message)
            pause.sleep()
    except rospy.ROSSerializationException as error:
        raise ROSTopicException(
            "Unable to publish message. One of the fields has an incorrect type:\n  %s" % error
        ) from None


def _fill(message, arguments):
    now = rospy.get_rostime()
    try:
        fill_message_args(message, arguments, keys={"now": now, "auto": rospy.Header(stamp=now)})
    except MessageException as error:
        raise ROSTopicException(
            "%s\n\nArgs are: [%s]" % (error, get_printable_message_args(message))
        ) from None


def _hertz(rate):
    try:
        return float(rate)
    except ValueError:
        raise ROSTopicException("Rate must be a number") from None


def wait_for_subscriber(pub, timeout):
    """Wait until a publisher has a subscriber, at most `timeout` seconds."""
    end = time.monotonic() + timeout
    while not pub.get_num_connections() and time.monotonic() < end:
        time.sleep(0.01)


class CallbackEcho:
    """Prints messages as `rostopic echo`; pass `callback` to a Subscriber, with {"topic": NAME}.

    Printing for plots (`plot=True`) is not supported.
    """

    def __init__(
        self,
        topic,
        msg_eval,
        plot=False,
        filter_fn=None,
        echo_clear=False,
        echo_all_topics=False,
        offset_time=False,
        count=None,
        field_filter_fn=None,
        fixed_numeric_width=None,
        value_transform_fn=None,
    ):
        if plot:
            raise NotImplementedError("plot=True is not supported: use `rosproto topic echo --csv`")
        self.topic = topic.removesuffix("/") if topic else topic
        self.msg_eval, self.filter_fn, self.echo_all_topics = msg_eval, filter_fn, echo_all_topics
        self.offset_time, self.max_count, self.count, self.done = offset_time, count, 0, False
        self.field_filter, self.fixed_numeric_width = field_filter_fn, fixed_numeric_width
        self.value_transform = value_transform_fn
        self.prefix, self.suffix = "\033[2J\033[;H" if echo_clear else "", "\n---"

    def callback(self, data, callback_args, current_time=None):
        """Print a message; sets `done` after `count` messages, or when stdout is closed."""
        topic = callback_args["topic"]
        if self.done or (self.filter_fn is not None and not self.filter_fn(data)):
            return
        wanted = self.msg_eval
        if topic != self.topic and self.topic.startswith(topic + "/"):
            wanted = msgevalgen(self.topic[len(topic) :])
        elif topic != self.topic and not self.echo_all_topics:
            return
        value = data if wanted is None else wanted(data)
        if value is not None:
            self._print(value, callback_args.get("type_information"), current_time)

    def _print(self, value, type_, current_time):
        if self.value_transform is not None:
            value = self.value_transform(value, type_)
        if type_ and type_.startswith("uint8["):
            value = list(value)
        text = strify_message(
            value,
            time_offset=rospy.get_rostime() if self.offset_time else None,
            current_time=current_time,
            field_filter=self.field_filter,
            fixed_numeric_width=self.fixed_numeric_width,
        )
        try:
            sys.stdout.write(self.prefix + text + self.suffix + "\n")
            sys.stdout.flush()
        except OSError:
            self.done = True
        self.count += 1
        self.done = self.done or (self.max_count is not None and self.count >= self.max_count)


# -- fields of messages --------------------------------------------------------------------------------------


def msgevalgen(pattern):
    """Return a function that extracts a part of a message; None for an empty or malformed pattern.

    The function returns None for a missing field or element. Errors are reported on stderr.
    """
    steps = []
    for part in (part for part in pattern.split("/") if part):
        name, bracket, rest = part.partition("[")
        if not bracket:
            steps.append((name, None))
            continue
        if not rest.endswith("]"):
            _tell("missing closing ']' in slice spec '%s'" % part)
            return None
        try:
            steps.append((name, _index(rest[:-1])))
        except ValueError as error:
            _tell("field '%s' has invalid slice argument '%s': %s" % (name, rest[:-1], error))
            return None
    return (lambda message: _walk(message, steps, pattern)) if steps else None


def _walk(value, steps, pattern):
    for number, (name, index) in enumerate(steps, 1):
        try:
            value = getattr(value, name)
        except AttributeError:
            _tell("no field named %s in %s" % (name, pattern))
            return None
        if index is None:
            continue
        try:
            value = value.__getitem__(index)
        except IndexError as error:
            _tell("%s: %s" % (error, pattern))
            return None
        if isinstance(value, list):  # of messages: the rest of the pattern applies to each
            return [_walk(one, steps[number:], pattern) for one in value]
    return value


def _index(text):
    """The Python index or slice between brackets.

    Raises:
        ValueError: The text is neither an index nor a slice.
    """
    if not text:
        raise ValueError("empty array index")
    if ":" not in text:
        return _integer(text, "array index step")
    parts = text.split(":")
    bounds = [
        _integer(part, "slice " + name) if part else None for part, name in zip(parts, _PARTS)
    ]  # the first malformed one is reported
    if len(parts) > len(_PARTS):
        raise ValueError("too many slice arguments")
    return slice(*bounds)


def _integer(text, what):
    try:
        return int(text)
    except ValueError:
        raise ValueError("non-integer %s '%s'" % (what, text)) from None


def _tell(text):
    print(text, file=sys.stderr)


# -- rates --------------------------------------------------------------------------------------------------


class ROSTopicHz:
    """Rate; pass `callback_hz` to Subscribers, with the topic as callback_args for several topics."""

    def __init__(self, window_size, filter_expr=None, use_wtime=False):
        self.lock = threading.Lock()
        self.filter_expr = filter_expr
        self.use_wtime = use_wtime
        self.window_size = window_size if window_size >= 0 else MAX_WINDOW_MESSAGES
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
        return found and (found.rate, found.minimum, found.maximum, found.deviation, found.messages)

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
        self.window_size = window_size if window_size >= 0 else MAX_WINDOW_MESSAGES
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
        return found and (found.mean, found.minimum, found.maximum, found.deviation, found.messages)

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
