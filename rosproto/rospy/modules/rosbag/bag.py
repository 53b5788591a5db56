"""rosbag.Bag over rosproto's reader and writer, with rosbag's tuples and errors."""

import io
import os
import re
import sys
import time
from collections import namedtuple

import genpy
from rospy.rostime import Time

from rosproto.bag import BagReader, BagWriter, Connection, reindex

from ._errors import (
    ROSBagEncryptException,
    ROSBagEncryptNotSupportedException,
    ROSBagException,
    ROSBagFormatException,
    ROSBagUnindexedException,
    rosbag_errors,
)
from ._info import BagInfo, Compression

__all__ = [
    "Bag",
    "BagMessage",
    "BagMessageWithConnectionHeader",
    "Compression",
    "ROSBagEncryptException",
    "ROSBagEncryptNotSupportedException",
    "ROSBagException",
    "ROSBagFormatException",
    "ROSBagUnindexedException",
]


BagMessage = namedtuple("BagMessage", "topic message timestamp")
BagMessageWithConnectionHeader = namedtuple(
    "BagMessageWithConnectionHeader", "topic message timestamp connection_header"
)
_ALLOWED = (Compression.NONE, Compression.BZ2, Compression.LZ4)


def _check_compression(compression):
    if compression not in _ALLOWED:
        raise ValueError("compression must be one of: %s" % ", ".join(_ALLOWED))


def _check_threshold(threshold):
    if threshold < 0:
        raise ValueError("chunk_threshold must be greater than or equal to zero")


def _chunk_bytes(threshold):
    return max(1, threshold)


class Bag(BagInfo):
    """A bag file, opened for reading ("r"), writing ("w") or appending ("a")."""

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
        self._file, self._mode = f, mode
        self._filename = None if isinstance(f, io.IOBase) else f
        self._reader = self._writer = None
        self._connections = {}
        self._classes = {}
        self._closed = False
        self._version = 200
        if mode == "w" or (mode == "a" and self._is_new()):
            self._writer = self._writing()
            return
        self._version = self._read_version()
        if mode == "a" and self._version != 200:
            raise ROSBagException("bag version %d is unsupported for appending" % self._version)
        if self._version > 299:
            raise ROSBagException("unknown bag version %d" % self._version)
        self._reader = self._opened(allow_unindexed)
        if mode == "a" and self._reader.indexed:
            self._append()

    def _is_new(self):
        """True when there is no file to append to; an existing empty file is refused, as by rosbag."""
        return self._filename is not None and not os.path.exists(self._filename)

    def _read_version(self):
        """Hundred times the version in the first line.

        Raises:
            ROSBagException: There is none.
        """
        if self._filename is None:
            line = self._file.readline()
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
            return BagWriter(
                self._file, self._compression, _chunk_bytes(self._chunk_threshold), append=append
            )

    def _append(self):
        """Continue after the reader's last chunk."""
        self._connections = {one.topic: one for one in self._reader.connections.values()}
        self._reader.close()
        self._writer = self._writing(append=True)

    def _opened(self, allow_unindexed=True):
        with rosbag_errors():
            reader = BagReader(self._file)
        if not allow_unindexed and not reader.indexed:
            reader.close()
            raise ROSBagUnindexedException
        return reader

    def __iter__(self):
        return self.read_messages()

    def __enter__(self):
        return self

    def __exit__(self, exc_type, exc_value, traceback):
        self.close()

    # -- properties -----------------------------------------------------------------------------------------

    @property
    def options(self):
        """Compression and chunk threshold."""
        return {"compression": self._compression, "chunk_threshold": self._chunk_threshold}

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
        """ "r", "w" or "a"."""
        return self._mode

    @property
    def size(self):
        """Bytes of the file."""
        self._require_open()
        if self._writer is not None:
            return self._writer.size
        if self._filename is None:
            position = self._file.tell()
            try:
                return self._file.seek(0, os.SEEK_END)
            finally:
                self._file.seek(position)
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
                self._writer.set_chunks(compression, _chunk_bytes(threshold))
        self._compression, self._chunk_threshold = compression, threshold

    def _require_open(self):
        if self._closed:
            raise ValueError("I/O operation on closed bag")

    # -- reading --------------------------------------------------------------------------------------------

    def _readable(self):
        """A reader of everything in the file so far."""
        self._require_open()
        if self._writer is None:
            return self._reader
        with rosbag_errors():
            self._writer.flush()
            if self._reader is not None:
                self._reader.close()
            self._reader = BagReader(self._file)
        return self._reader

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
                cls = self._class(message.connection)
                if raw:
                    value = (message.type, message.data, message.md5sum, message.position, cls)
                else:
                    value = cls().deserialize(message.data)
                stamp = Time(stamp.secs, stamp.nsecs)
                if with_header:
                    header = self._header(message.connection)
                    yield BagMessageWithConnectionHeader(topic, value, stamp, header)
                else:
                    yield BagMessage(topic, value, stamp)

    @staticmethod
    def _header(connection):
        return {key: value.encode() for key, value in connection.header.items()}

    def _class(self, connection):
        """The class made from the bag's own definition."""
        key = connection.type, connection.md5sum
        found = self._classes.get(key)
        if found is None:
            from genpy.dynamic import generate_dynamic

            made = generate_dynamic(connection.type, connection.definition)
            found = self._classes[key] = made[connection.type]
        return found

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
            buffer = io.BytesIO()
            msg.serialize(buffer)
            data = buffer.getvalue()
        connection = self._connections.get(topic)
        if connection is None:
            connection = self._connections[topic] = self._connection(
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
            self._reader.close()
            with rosbag_errors():
                reindex(self._file)
                self._reader = BagReader(self._file)
            self._append()

    def close(self):
        """Close the file; a bag being written gets its table of contents."""
        if self._closed:
            return
        self._closed = True
        if self._writer is not None:
            with rosbag_errors():
                self._writer.close()
        if self._reader is not None:
            self._reader.close()
