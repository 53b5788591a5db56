"""Facts about a bag: counts, times, types, and the text and YAML of `rosbag info`."""

import itertools
import sys
from collections import namedtuple
from contextlib import contextmanager

import genpy

from rosproto.bag import BagReader

from ._errors import ROSBagException, rosbag_errors

_TopicTuple = namedtuple("TopicTuple", "msg_type message_count connections frequency")
_TypesAndTopicsTuple = namedtuple("TypesAndTopicsTuple", "msg_types topics")
_CompressionTuple = namedtuple("CompressionTuple", "compression uncompressed compressed")


class Compression:
    """Compression methods of chunks."""

    NONE = "none"
    BZ2 = "bz2"
    LZ4 = "lz4"


class BagInfo:
    """The part of a Bag that answers questions, also when it is closed; Bag has these."""

    _closed: bool
    _filename: "str | None"

    def _readable(self) -> BagReader:
        raise NotImplementedError

    @contextmanager
    def _reader_of_facts(self):
        """Return a reader of the bag, which is opened again if it is closed."""
        with rosbag_errors():
            if self._closed and self._filename is not None:
                with BagReader(self._filename) as reader:
                    yield reader
            else:
                yield self._readable()

    def get_message_count(self, topic_filters=None):
        """Return the number of messages."""
        if topic_filters is None:
            with self._reader_of_facts() as reader:
                return reader.message_count
        info = self.get_type_and_topic_info(topic_filters)
        return sum(topic.message_count for topic in info.topics.values())

    def get_start_time(self):
        """Seconds of the first message."""
        return self._stamp("start_time")

    def get_end_time(self):
        """Seconds of the last message."""
        return self._stamp("end_time")

    def _stamp(self, which):
        with self._reader_of_facts() as reader:
            stamp = getattr(reader, which)
        if stamp is None:
            raise ROSBagException("Bag contains no message")
        return genpy.Time(stamp.secs, stamp.nsecs).to_sec()

    def get_type_and_topic_info(self, topic_filters=None):
        """(types and their md5sums, topics with type, message count, connections, median frequency)."""
        if topic_filters is not None and not isinstance(topic_filters, list):
            topic_filters = [topic_filters]
        with self._reader_of_facts() as reader:
            kinds = sorted(reader.connections.values(), key=lambda one: one.type)
            wanted = set(reader.topics if topic_filters is None else topic_filters) & set(reader.topics)
            topics = {topic: self._topic_tuple(reader, topic) for topic in sorted(wanted)}
        return _TypesAndTopicsTuple({one.type: one.md5sum for one in kinds}, topics)

    def _topic_tuple(self, reader, topic):
        known = reader.topics[topic]
        connections = known.connections
        frequency = self._frequency(reader, topic)
        return _TopicTuple(connections[0].type, known.message_count, len(connections), frequency)

    @staticmethod
    def _frequency(reader, topic):
        stamps = [genpy.Time(*divmod(int(t), 10**9)).to_sec() for t in reader.times(topic)]
        periods = sorted(b - a for a, b in itertools.pairwise(stamps))
        if not periods:
            return None
        half = len(periods) // 2
        median = periods[half] if len(periods) % 2 else float(periods[half] + periods[half - 1]) / 2
        return 1.0 / median if median > 0.0 else None

    def get_compression_info(self):
        """The compression that most chunks have, and their sizes."""
        with self._reader_of_facts() as reader:
            found = reader.compression()
        if not found:
            return _CompressionTuple(Compression.NONE, 0, 0)
        main = max(found, key=lambda name: found[name].chunks)
        every = found.values()
        return _CompressionTuple(main, sum(c.plain_bytes for c in every), sum(c.stored_bytes for c in every))

    def __str__(self):
        from rosproto.bag.summary import facts, text

        with rosbag_errors():
            return text(facts(self._readable(), freq=True))

    def _get_yaml_info(self, key=None):
        """Return the output of `rosbag info -y`, or one of its values; programs use this private method."""
        from rosproto.bag.summary import facts, yaml, yaml_value

        with rosbag_errors():
            found = facts(self._readable(), freq=True)
        if key is None:
            return yaml(found)
        try:
            return yaml_value(found, key)
        except KeyError:
            print('Error getting key "%s"' % key, file=sys.stderr)
            return None
