"""rosbag.Bag over rosproto's reader and writer, with rosbag's tuples, errors and summaries."""

import io
import os
import re
import sys
import time
from collections import namedtuple
from contextlib import contextmanager

import genpy
from genpy.message import encode_message
from roslib.names import canonicalize_name
from rospy.rostime import Time

from rosproto.bag import BagReader, BagWriter, Connection, reindex
from rosproto.bag.summary import facts, text, yaml, yaml_value
from rosproto.errors import BagError


class ROSBagException(Exception):
    """A bag cannot be used."""

    def __init__(self, value=None):
        self.value = value
        self.args = (value,)

    def __str__(self):
        return self.value


class ROSBagFormatException(ROSBagException):
    """It is not a bag, or it is damaged."""


class ROSBagUnindexedException(ROSBagException):
    """It has no table of contents."""

    def __init__(self, *args):
        super().__init__("Unindexed bag")


class ROSBagEncryptNotSupportedException(ROSBagException):
    """It is encrypted, and this layer cannot decrypt it."""


class ROSBagEncryptException(ROSBagException):
    """Encrypting or decrypting failed."""


@contextmanager
def rosbag_errors():
    """Raise rosbag's errors for rosproto's, or the operating system's own error if there is one."""
    try:
        yield
    except BagError as error:
        if isinstance(error.__cause__, OSError):
            raise error.__cause__ from None
        if error.reason.startswith("the bag is encrypted"):
            raise ROSBagEncryptNotSupportedException(str(error)) from error
        raise ROSBagFormatException(str(error)) from error


class Compression:
    """Compression methods of chunks."""

    NONE = "none"
    BZ2 = "bz2"
    LZ4 = "lz4"


BagMessage = namedtuple("BagMessage", "topic message timestamp")
BagMessageWithConnectionHeader = namedtuple(
    "BagMessageWithConnectionHeader", "topic message timestamp connection_header"
)
_TopicTuple = namedtuple("TopicTuple", "msg_type message_count connections frequency")
_TypesAndTopicsTuple = namedtuple("TypesAndTopicsTuple", "msg_types topics")
_CompressionTuple = namedtuple("CompressionTuple", "compression uncompressed compressed")
_OTHER_MD5SUM = (
    "WARNING: For type [%s] stored md5sum [%s] does not match message definition [%s].\n"
    '  Try: "rosrun rosbag fix_msg_defs.py old_bag new_bag."'
)
_INVALID_DEFINITION = (
    "WARNING: For type [%s] stored md5sum [%s] has invalid message definition: %s. "
    + "Its messages have no fields."
)
_ALLOWED = (Compression.NONE, Compression.BZ2, Compression.LZ4)


def _check_compression(compression):
    if compression not in _ALLOWED:
        raise ValueError("compression must be one of: %s" % ", ".join(_ALLOWED))


def _check_threshold(threshold):
    if threshold < 0:
        raise ValueError("chunk_threshold must be greater than or equal to zero")


class _ConnectionInfo:
    """A connection, as programs find it in `Bag._connections`."""

    def __init__(self, connection):
        self.id, self.topic, self.datatype = connection.id, connection.topic, connection.type
        self.md5sum, self.msg_def = connection.md5sum, connection.definition
        self.header = {key: value.encode() for key, value in connection.header.items()}


class _ChunkInfo:
    """A chunk, as programs find it in `Bag._chunks`."""

    def __init__(self, chunk):
        self.pos, self.connection_counts = chunk.pos, chunk.counts
        self.start_time, self.end_time = (Time(*divmod(ns, 10**9)) for ns in (chunk.start, chunk.end))


class _IndexEntry(namedtuple("_IndexEntry", "time chunk_pos offset")):
    """Where a message is; sorted by time."""

    @property
    def position(self):
        """For `Bag._read_message`."""
        return (self.chunk_pos, self.offset)


class Bag:
    """A bag file, opened for reading ("r"), writing ("w") or appending ("a").

    Programs use these private names of rosbag's: `_filename`, `_connections`, `_chunks`,
    `_connection_indexes`, `_get_connections`, `_get_entries`, `_read_message`, `_uncompressed_size`,
    `_get_yaml_info`. The others belong to rosbag's own way to read a file.
    """

    def __init__(
        self,
        f,
        mode="r",
        compression=Compression.NONE,
        chunk_threshold=768 * 1024,
        allow_unindexed=False,
        options=None,
        skip_index=False,
    ):
        if options is not None:
            if type(options) is not dict:
                raise ValueError("options must be of type dict")
            compression = options.get("compression", compression)
            chunk_threshold = options.get("chunk_threshold", chunk_threshold)
        _check_compression(compression)
        _check_threshold(chunk_threshold)
        if not f:
            raise ValueError("filename (or stream) is invalid")
        if mode not in ("r", "w", "a"):
            raise ValueError('mode "%s" is invalid' % mode)
        self._compression, self._chunk_threshold = compression, chunk_threshold
        self._given, self._mode = f, mode
        self._filename = None if isinstance(f, io.IOBase) else f
        self._source = self._writer = None
        self._outgoing = {}
        self._classes = {}
        self._closed = False
        self._version = 200
        # An existing empty file is refused, as by rosbag.
        if mode == "w" or (mode == "a" and self._filename is not None and not os.path.exists(self._filename)):
            self._writer = self._writing()
            return
        self._version = self._read_version()
        if mode == "a" and self._version != 200:
            raise ROSBagException("bag version %d is unsupported for appending" % self._version)
        if self._version > 299:
            raise ROSBagException("unknown bag version %d" % self._version)
        with rosbag_errors():
            self._source = BagReader(self._given)
        if not allow_unindexed and not self._source.indexed:
            self._source.close()
            raise ROSBagUnindexedException
        if mode == "a" and self._source.indexed:
            self._append()

    def _read_version(self):
        """Hundred times the version in the first line.

        Raises:
            ROSBagException: There is none.
        """
        if self._filename is None:
            line = self._given.readline()
        else:
            with open(self._filename, "rb") as file:
                line = file.readline(256)
        if not line:
            raise ROSBagException("empty file")
        found = re.match(rb"#ROS.* V(\d).(\d)", line)
        if found is None:
            raise ROSBagException("This does not appear to be a bag file")
        return 100 * int(found.group(1)) + int(found.group(2))

    def _writing(self, append=False):
        with rosbag_errors():
            return BagWriter(self._given, self._compression, max(1, self._chunk_threshold), append=append)

    def _append(self):
        """Continue after the reader's last chunk."""
        self._outgoing = {one.topic: one for one in self._source.connections.values()}
        self._source.close()
        self._writer = self._writing(append=True)

    def __getattr__(self, name):
        text = "rosbag.Bag has no attribute %r here" % name
        if name.startswith("_"):
            text += "; messages are read with read_messages, _get_entries and _read_message"
        raise AttributeError(text, name=name)

    def __iter__(self):
        return self.read_messages()

    def __enter__(self):
        return self

    def __exit__(self, exc_type, exc_value, traceback):
        self.close()

    # -- properties -----------------------------------------------------------------------------------------

    @property
    def filename(self):
        """Path, None for a stream."""
        return self._filename

    @property
    def version(self):
        """Version of the format: 200 for 2.0."""
        return self._version

    @property
    def mode(self):
        """One of "r", "w" and "a"."""
        return self._mode

    @property
    def options(self):
        """Compression and chunk threshold."""
        return {"compression": self._compression, "chunk_threshold": self._chunk_threshold}

    @property
    def size(self):
        """Bytes of the file."""
        self._require_open()
        if self._writer is not None:
            return self._writer.size
        if self._filename is None:
            position = self._given.tell()
            try:
                return self._given.seek(0, os.SEEK_END)
            finally:
                self._given.seek(position)
        return os.path.getsize(self._filename)

    @property
    def compression(self):
        """Compression of the chunks that are written from now on; setting it ends the open chunk."""
        return self._compression

    @compression.setter
    def compression(self, compression):
        _check_compression(compression)
        self._set_chunks(compression, self._chunk_threshold)

    @property
    def chunk_threshold(self):
        """Bytes after which a chunk is written; setting it ends the open chunk."""
        return self._chunk_threshold

    @chunk_threshold.setter
    def chunk_threshold(self, chunk_threshold):
        _check_threshold(chunk_threshold)
        self._set_chunks(self._compression, chunk_threshold)

    def _set_chunks(self, compression, threshold):
        self._require_open()
        if self._writer is not None:
            with rosbag_errors():
                self._writer.set_chunks(compression, max(1, threshold))
        self._compression, self._chunk_threshold = compression, threshold

    def _require_open(self):
        if self._closed:
            raise ValueError("I/O operation on closed bag")

    # -- reading --------------------------------------------------------------------------------------------

    def _readable(self):
        """A reader of everything in the file so far."""
        self._require_open()
        if self._writer is None:
            return self._source
        with rosbag_errors():
            self._writer.flush()
            if self._source is not None:
                self._source.close()
            self._source = BagReader(self._given)
        return self._source

    def read_messages(
        self,
        topics=None,
        start_time=None,
        end_time=None,
        connection_filter=None,
        raw=False,
        return_connection_header=False,
    ):
        """Messages as (topic, message, timestamp), by the time they were received."""
        reader = self._readable()
        return self._read(
            reader, topics, start_time, end_time, connection_filter, raw, return_connection_header
        )

    def _read(self, reader, topics, start_time, end_time, wanted, raw, with_header):
        if topics and not isinstance(topics, str):
            topics = list(topics)
        connections = None
        if wanted is not None:
            connections = [
                one
                for one in reader.connections.values()
                if wanted(one.topic, one.type, one.md5sum, one.definition, dict(one.header))
            ]
        with rosbag_errors():
            for topic, message, stamp in reader.read_messages(
                topics or None, start_time, end_time, raw=True, connections=connections
            ):
                yield self._as_tuple(topic, message, stamp, raw, with_header)

    def _as_tuple(self, topic, message, stamp, raw, with_header):
        cls = self._class(message.connection)
        if raw:
            value = (message.type, message.data, message.md5sum, message.position, cls)
        else:
            value = cls().deserialize(message.data)
        stamp = Time(stamp.secs, stamp.nsecs)
        if with_header:
            header = {key: value.encode() for key, value in message.connection.header.items()}
            return BagMessageWithConnectionHeader(topic, value, stamp, header)
        return BagMessage(topic, value, stamp)

    def _class(self, connection):
        """The class made from the bag's own definition; one without fields if that is not usable."""
        key = connection.type, connection.md5sum, connection.definition
        found = self._classes.get(key)
        if found is None:
            from genpy.dynamic import generate_dynamic

            try:
                made = generate_dynamic(connection.type, connection.definition)
                if made[connection.type]._md5sum != connection.md5sum:
                    print(_OTHER_MD5SUM % (*key[:2], made[connection.type]._md5sum), file=sys.stderr)
            except genpy.MessageException as error:
                made = generate_dynamic(connection.type, "")
                print(_INVALID_DEFINITION % (*key[:2], error), file=sys.stderr)
            found = self._classes[key] = made[connection.type]
        return found

    # -- private names that programs use --------------------------------------------------------------------

    @property
    def _connections(self):
        return {number: _ConnectionInfo(one) for number, one in self._readable().connections.items()}

    @property
    def _chunks(self):
        return [_ChunkInfo(chunk) for chunk in self._readable().chunks]

    @property
    def _uncompressed_size(self):
        return sum(one.plain_bytes for one in self._readable().compression().values()) or self.size

    def _get_connections(self, topics=None, connection_filter=None):
        """Connections of some topics, or that a filter accepts."""
        names = {canonicalize_name(name) for name in ([topics] if isinstance(topics, str) else topics or ())}
        for one in self._connections.values():
            if names and one.topic not in names and canonicalize_name(one.topic) not in names:
                continue
            if connection_filter is None or connection_filter(
                one.topic, one.datatype, one.md5sum, one.msg_def, one.header
            ):
                yield one

    def _get_entries(self, connections=None, start_time=None, end_time=None):
        """Where the messages are, by the time they were received."""
        return (entry for _, entry in self._located(connections, start_time, end_time))

    def _located(self, connections=None, start_time=None, end_time=None):
        reader = self._readable()
        wanted = None if connections is None else [reader.connections[one.id] for one in connections]
        with rosbag_errors():
            for _, message, stamp in reader.read_messages(
                None, start_time, end_time, raw="view", connections=wanted
            ):
                yield message.connection.id, _IndexEntry(Time(stamp.secs, stamp.nsecs), *message.position)

    @property
    def _connection_indexes(self):
        found = {}
        for number, entry in self._located():
            found.setdefault(number, []).append(entry)
        return found

    def _read_message(self, position, raw=False, return_connection_header=False):
        """The message at the position of an entry."""
        with rosbag_errors():
            topic, message, stamp = self._readable().message_from(position)
        return self._as_tuple(topic, message, stamp, raw, return_connection_header)

    def set_encryptor(self, encryptor=None, param=None):
        """Refuse encryption; everything else is no encryption, as in rosbag.

        Raises:
            ROSBagException: Chunks were written already.
            ROSBagEncryptNotSupportedException: Encryption was asked for.
        """
        if self._chunks:
            raise ROSBagException("Cannot set encryptor after chunks are written")
        if encryptor == "rosbag/AesCbcEncryptor":
            raise ROSBagEncryptNotSupportedException(
                "%s is not supported here: write the bag plain, and encrypt it where ROS is installed: "
                "rosbag encrypt" % encryptor
            )

    # -- facts ----------------------------------------------------------------------------------------------

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
            kinds = {}
            for one in sorted(reader.connections.values(), key=lambda one: one.type):
                kinds.setdefault(one.type, one.md5sum)  # of two definitions the first connection's
            wanted = set(reader.topics if topic_filters is None else topic_filters) & set(reader.topics)
            topics = {}
            for topic in sorted(wanted):
                known, rate = reader.topics[topic], reader.frequency(topic)
                connections, count = known.connections, known.message_count
                topics[topic] = _TopicTuple(connections[0].type, count, len(connections), rate)
        return _TypesAndTopicsTuple(kinds, topics)

    def get_compression_info(self):
        """The compression that most chunks have, and their sizes."""
        with self._reader_of_facts() as reader:
            found = reader.compression()
        if not found:
            return _CompressionTuple(Compression.NONE, 0, 0)
        main = max(found, key=lambda name: (found[name].chunks, name))
        every = found.values()
        return _CompressionTuple(main, sum(c.plain_bytes for c in every), sum(c.stored_bytes for c in every))

    def __str__(self):
        with rosbag_errors():
            return text(facts(self._readable(), freq=True))

    def _get_yaml_info(self, key=None):
        """Return the output of `rosbag info -y`, or one of its values; programs use this private method."""
        with rosbag_errors():
            found = facts(self._readable(), freq=True)
        if key is None:
            return yaml(found)
        try:
            return yaml_value(found, key)
        except KeyError:
            print('Error getting key "%s"' % key, file=sys.stderr)
            return None

    # -- writing --------------------------------------------------------------------------------------------

    def write(self, topic, msg, t=None, raw=False, connection_header=None):
        """Add a message, or (type, bytes, md5sum, class) with `raw`.

        Raises:
            ValueError: The bag is closed, or an argument makes no sense.
        """
        self._require_open()
        if not topic:
            raise ValueError("topic is invalid")
        if not msg:
            raise ValueError("msg is invalid")
        if self._mode == "r":
            raise io.UnsupportedOperation("write")
        if t is None:
            t = genpy.Time.from_sec(time.time())
        if raw:
            type_, data, md5sum, cls = self._unpacked(msg)
        else:
            cls = msg.__class__
            type_, md5sum = cls._type, cls._md5sum
            data = encode_message(msg)
        connection = self._outgoing.get(topic)
        if connection is None:
            connection = self._outgoing[topic] = self._connection(
                topic, type_, md5sum, cls, connection_header
            )
        self._mend()
        with rosbag_errors():
            self._writer.write_raw(connection, data, t)

    @staticmethod
    def _unpacked(msg):
        if len(msg) == 5:
            type_, data, md5sum, _, cls = msg
        elif len(msg) == 4:
            type_, data, md5sum, cls = msg
        else:
            raise ValueError("msg must be of length 4 or 5")
        if cls is None:
            cls = genpy.message.get_message_class(type_)
        if cls is None:
            raise ROSBagException(
                "cannot locate message class and no message class provided for [%s]" % type_
            )
        if cls._md5sum != md5sum:
            print(
                "WARNING: md5sum of loaded type [%s] does not match that specified" % type_, file=sys.stderr
            )
        return type_, data, md5sum, cls

    @staticmethod
    def _connection(topic, type_, md5sum, cls, header):
        fields = header or {"topic": topic, "type": type_, "md5sum": md5sum}
        fields = {key: value.decode() if isinstance(value, bytes) else value for key, value in fields.items()}
        definition = fields.pop("message_definition", cls._full_text)
        return Connection(0, topic, type_, md5sum, definition, fields)

    def flush(self):
        """Write the buffered messages, so that readers find them."""
        self._require_open()
        if self._writer is not None:
            with rosbag_errors():
                self._writer.flush()

    def reindex(self):
        """Give a bag opened with "a" and `allow_unindexed` its table of contents; yields chunk positions.

        Everything that can be read is kept, even of a chunk that is cut off. A bag opened with "r" is
        readable without this, and is not changed.

        Raises:
            ROSBagFormatException: It is damaged before its end; `rosproto bag fix` writes a new one.
        """
        self._require_open()
        return self._reindexed()

    def _reindexed(self):
        if self._mode == "a":
            self._mend()
        for chunk in self._readable().chunks:
            yield chunk.pos

    def _mend(self):
        """Write the table of contents of an unindexed bag that is to be continued."""
        if self._writer is None:
            self._source.close()
            with rosbag_errors():
                reindex(self._given)
                self._source = BagReader(self._given)
            self._append()

    def close(self):
        """Close the file; a bag being written gets its table of contents."""
        if self._closed:
            return
        self._closed = True
        if self._writer is not None:
            with rosbag_errors():
                self._writer.close()
        if self._source is not None:
            self._source.close()
