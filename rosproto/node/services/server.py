"""A service server: reads and answers the requests of each connection in order.

Source: wiki.ros.org/ROS/TCPROS (one byte "ok", then a length-prefixed response, or error text),
wiki.ros.org/Services; rospy impl/tcpros_service.py and roscpp service_client_link.cpp.
"""

from __future__ import annotations

import socket
import struct
import threading
from collections.abc import Callable, Mapping
from typing import Any

from rosproto.codec import Message, ServiceType, decode, encode
from rosproto.errors import (
    CodecError,
    ConnectionLost,
    Md5sumMismatch,
    RemoteProtocolError,
    RosTimeout,
    ServiceError,
)
from rosproto.logs import PeerLog, get_logger
from rosproto.node.context import Context
from rosproto.node.definitions.md5sum_mismatch import ServiceRevision, note_differences, revised_service
from rosproto.node.graph.listening import refuse
from rosproto.protocol.framing import FrameDecoder
from rosproto.protocol.handshake import ServiceRequest, check_service_client_header, service_server_header
from rosproto.protocol.wire_limits import Limits
from rosproto.transport.deadline import Deadline
from rosproto.transport.tcp import interrupt, write_header, write_steadily

MAX_ERROR_BYTES = 64 << 10  # bytes of error text


def response_from(returned: Any, response_class: type[Message]) -> Message:
    """Make the response message from the return value of a handler.

    Args:
        returned: An instance of the response; a dict of its fields; None, for a response without fields; the
            bare value, for a response of one field; a tuple or list of all fields in order, for several.
        response_class: Class of the response.

    Raises:
        TypeError: It is none of these, or None for a response with fields: usually a forgotten `return` (as
            in rospy).
    """
    if isinstance(returned, response_class) or getattr(returned, "_type", None) == response_class._type:
        response: Message = returned
        return response
    fields: list[str] = list(response_class.__slots__)
    if isinstance(returned, Mapping):
        return response_class(**returned)
    if returned is None and not fields:
        return response_class()
    if returned is not None and len(fields) == 1 and not hasattr(returned, "_type"):
        return response_class(**{fields[0]: returned})
    if isinstance(returned, (tuple, list)) and len(returned) == len(fields):
        return response_class(**dict(zip(fields, returned, strict=True)))
    raise TypeError(
        f"the handler returned {_shown(returned)}; expected {response_class._type} with"
        f" {', '.join(fields) or 'no fields'}, or a dict of these"
    )


def _shown(returned: object) -> str:
    if returned is None:
        return "None"
    if isinstance(returned, (tuple, list)):
        return f"a {type(returned).__name__} of {len(returned)} values"
    return str(getattr(returned, "_type", type(returned).__name__))


def encode_reply(response: Message) -> bytes:
    """The answer to a successful call: ok byte 1, length, response."""
    body = encode(response)
    return struct.pack("<BI", 1, len(body)) + body


def error_text(error: BaseException) -> str:
    """Error text for the caller: the text of a ServiceError, else class and message."""
    if isinstance(error, ServiceError):
        return error.text
    text = str(error)
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


def encode_error(text: str) -> bytes:
    """The answer to a failed call: ok byte 0, length, text in UTF-8 (at most `MAX_ERROR_BYTES` bytes)."""
    body = text.encode("utf-8", "surrogateescape" if _has_escaped_bytes(text) else "backslashreplace")
    body = body[:MAX_ERROR_BYTES]
    return struct.pack("<BI", 0, len(body)) + body


def _has_escaped_bytes(text: str) -> bool:
    """True if `text` contains surrogate-escaped bytes that were not UTF-8 and are sent unchanged."""
    surrogates = [letter for letter in text if "\ud800" <= letter <= "\udfff"]
    return bool(surrogates) and all("\udc80" <= letter <= "\udcff" for letter in surrogates)


logger = get_logger("rosproto.node")

FIRST_BUFFER_BYTES = 4 << 10  # enough for most requests
BUFFER_STEP_BYTES = 256 << 10  # growth for longer ones: a peer may announce a length and send nothing


class ServiceSession:
    """Serves one connection after the exchange of headers.

    Requests may be pipelined: they are answered one after the other. An idle connection has no time limit,
    but `stall_seconds` without progress within a request or an answer end it.

    Attributes:
        peer: "host:port" of the client.
        callerid: Its node name; "" if unknown.
    """

    def __init__(
        self,
        sock: socket.socket,
        answer: Callable[[bytes], bytes],
        *,
        peer: str,
        callerid: str = "",
        persistent: bool,
        limits: Limits,
        stall_seconds: float = 30.0,
        said: PeerLog | None = None,
    ) -> None:
        self._sock = sock
        self._answer = answer
        self._persistent = persistent
        self._stall_seconds = stall_seconds
        self._requests = FrameDecoder(limits.message_bytes, room=FIRST_BUFFER_BYTES, step=BUFFER_STEP_BYTES)
        self._said = said or PeerLog("rosproto.node")
        self._lock = threading.Lock()
        self._changed = threading.Condition(self._lock)
        self._busy = False
        self._ending = False
        self._thread = threading.current_thread()
        self.peer = peer
        self.callerid = callerid

    def run(self) -> None:
        """Serve until the client disconnects or violates the protocol, or `finish`; then close the socket.

        A disconnection is not logged: one-shot clients, probes and port scans cause many.
        """
        self._thread = threading.current_thread()
        try:
            self._sock.settimeout(self._stall_seconds)
            while (request := self._read_request()) is not None and self._begin():
                write_steadily(self._sock, self._answer(request))
                if not self._end() or not self._persistent:
                    break
        except RemoteProtocolError as error:
            self._said.warning("", "! service client %s %s: %s", self.callerid, self.peer, error)
        except OSError as error:
            logger.debug("! service client %s %s: %s", self.callerid, self.peer, error)
        finally:
            with self._lock:
                # Under the lock, and before close() frees the descriptor: the connection must be cut when
                # `join` returns.
                interrupt(self._sock)
                self._busy, self._ending = False, True
                self._changed.notify_all()
            self._sock.close()

    def _read_request(self) -> bytes | None:
        """The next request; None when the client closed the connection."""
        requests = self._requests
        while True:
            if requests.buffered and (request := requests.next_frame()) is not None:
                return request
            try:
                count = self._sock.recv_into(requests.space())
            except TimeoutError:
                if requests.buffered:
                    raise
                continue  # idle, not stalled
            if not count:
                return None
            requests.received(count)

    def _begin(self) -> bool:
        with self._lock:
            self._busy = not self._ending
            return self._busy

    def _end(self) -> bool:
        with self._lock:
            self._busy = False
            if self._ending:
                self._changed.notify_all()
            return not self._ending

    def finish(self) -> None:
        """Ask the session to end: at once when idle, after the answer when a request is being served."""
        with self._lock:
            self._ending = True
            if not self._busy:
                interrupt(self._sock)

    def join(self, timeout: float | None) -> bool:
        """Wait at most `timeout` seconds until the request in progress is answered; then cut the connection.

        Returns:
            False if the handler still runs; its thread stays (Python cannot end it), and its answer is lost.
        """
        done = self._thread is threading.current_thread()  # closed by its own handler
        if not done:
            with self._changed:
                done = self._changed.wait_for(lambda: not self._busy, timeout)
                interrupt(self._sock)
        return done


class ServiceServer:
    """Provides one service; made by `Node.service_server`.

    The handler is called with the request in the thread of that client's connection ("rosproto:..."), so
    calls of several clients run at the same time: protect shared data. It returns a response, a dict of its
    fields, a tuple or list of all fields in order, the bare value for a response of one field, or None for a
    response without fields. After an exception or another value the call fails: the caller gets the error
    text, the traceback is logged, and the connection stays open. Raise `ServiceError(server.name, "why")` to
    report failure without a traceback.

    Attributes:
        name: Resolved service name.
        type_name: "package/Type".
        md5sum: md5sum of our definition.
        on_refused: Called with the connection header of a refused client and the reason; None by default.
    """

    def __init__(
        self,
        context: Context,
        name: str,
        service_class: type[ServiceType],
        handler: Callable[[Message], object],
        *,
        on_close: Callable[[ServiceServer], None],
    ) -> None:
        self.name = name
        self.type_name: str = service_class._type
        self.md5sum: str = service_class._md5sum
        self._context = context
        self._class = service_class
        self._handler = handler
        self.on_refused: Callable[[Mapping[str, str], RemoteProtocolError], object] | None = None
        self._on_close = on_close
        self._request_class = service_class._request_class
        self._response_class = service_class._response_class
        self._lock = threading.Lock()
        self._sessions: set[ServiceSession] = set()
        self._closed = False
        self._calls = self._errors = self._connections = 0

    def __repr__(self) -> str:
        return f"<ServiceServer {self.name} {self.type_name}{' closed' if self._closed else ''}>"

    def __enter__(self) -> ServiceServer:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()

    def accept(self, sock: socket.socket, header: Mapping[str, str], peer: str) -> None:
        """Serve one connection whose header names this service; return when the connection ends.

        Called by the node in the connection's own thread. Probes, and clients that disconnect without a
        request, are not logged.

        Raises:
            Md5sumMismatch, RemoteProtocolError: The client was refused and got an error header.
        """
        try:
            asked, revision = self._understand(header, peer)
        except RemoteProtocolError as error:
            refuse(sock, str(error))
            if self.on_refused is not None:
                self.on_refused(header, error)
            raise
        try:
            write_header(sock, self._header(revision), Deadline(self._context.limits.handshake_seconds))
        except (ConnectionLost, RosTimeout):
            sock.close()  # rospy's wait_for_service closes without reading the answer
            return
        if asked.probe:
            sock.close()
        else:
            self._serve(sock, dict(header), peer, asked.persistent, revision)

    def _understand(
        self, header: Mapping[str, str], peer: str
    ) -> tuple[ServiceRequest, ServiceRevision | None]:
        """Check the client's header; return the request, and its revision of the service if not ours."""
        try:
            return check_service_client_header(
                header, service=self.name, type_name=self.type_name, md5sum=self.md5sum, peer=peer
            ), None
        except Md5sumMismatch as mismatch:
            if mismatch.remote_type not in ("", self.type_name):
                raise
            revision = revised_service(self._context.definitions, self._class, header["md5sum"], mismatch)
        asked = check_service_client_header(
            header, service=self.name, type_name=self.type_name, md5sum=revision.md5sum, peer=peer
        )
        if not asked.probe:
            note_differences(
                self._context.peer_log, self.name, asked.callerid or peer, revision.request_to_ours
            )
        return asked, revision

    def _header(self, revision: ServiceRevision | None = None) -> dict[str, str]:
        return service_server_header(
            service=self.name,
            type_name=self.type_name,
            md5sum=self.md5sum if revision is None else revision.md5sum,
            callerid=self._context.name,
            request_type=self._request_class._type,
            response_type=self._response_class._type,
        )

    def _serve(
        self,
        sock: socket.socket,
        header: dict[str, str],
        peer: str,
        persistent: bool,
        revision: ServiceRevision | None,
    ) -> None:
        session = ServiceSession(
            sock,
            lambda request: self._answer(request, header, revision),
            peer=peer,
            callerid=header.get("callerid", ""),
            persistent=persistent,
            limits=self._context.limits,
            said=self._context.peer_log,
        )
        with self._lock:
            if self._closed:
                sock.close()
                return
            self._sessions.add(session)
            self._connections += 1
        try:
            session.run()
        finally:
            with self._lock:
                self._sessions.discard(session)

    def _answer(self, data: bytes, header: dict[str, str], revision: ServiceRevision | None) -> bytes:
        """Encoded answer to one encoded request; never raises.

        Also catches `sys.exit()` in a handler, which would only end this thread, without an answer.
        """
        self._calls += 1
        try:
            request = self._request(data, revision)
        except CodecError as error:
            self._errors += 1
            caller = header.get("callerid", "")
            text = "! service %s: a request of %s is malformed: %s"
            self._context.peer_log.warning(self.name, text, self.name, caller, error)
            return encode_error(error_text(error))
        try:
            request._connection_header = header
            response = response_from(self._handler(request), self._response_class)
            return encode_reply(response if revision is None else revision.response_to_theirs(response))
        except BaseException as error:
            self._errors += 1
            self._report(error, header)
            return encode_error(error_text(error))

    def _request(self, data: bytes, revision: ServiceRevision | None) -> Message:
        """
        Raises:
            CodecError: The bytes are not a request of the service.
        """
        if revision is None:
            return decode(self._request_class, data)
        request: Message = revision.request_to_ours(decode(revision.request_class, data))
        return request

    def _report(self, error: BaseException, header: dict[str, str]) -> None:
        """Log a failed call, with a traceback unless it is a ServiceError."""
        caller = header.get("callerid", "")
        if isinstance(error, ServiceError):
            self._context.peer_log.info(self.name, "service %s told %s: %s", self.name, caller, error.text)
        else:
            text = "service %s: the call of %s failed"
            self._context.peer_log.error(self.name, text, self.name, caller, exc_info=error)

    def stats(self) -> dict[str, int]:
        """Counters since the start: calls, errors, accepted connections; and connections open now."""
        return {
            "calls": self._calls,
            "errors": self._errors,
            "accepted": self._connections,
            "connections": len(self._sessions),
        }

    def finish(self) -> None:
        """Begin to close: refuse connections, end idle ones, complete answers in progress. Does not wait."""
        with self._lock:
            self._closed = True
            sessions = list(self._sessions)
        for session in sessions:
            session.finish()

    def close(self, timeout: float = 2.0) -> None:
        """Unregister the service and end its connections. May be called again.

        Requests being served have `timeout` seconds in total to finish; then their connections are closed.
        """
        self.leave()
        self.join(Deadline(timeout))

    def leave(self) -> None:
        """As `close`, without waiting; requests being served are still answered, without a time limit."""
        self._on_close(self)
        self.finish()

    def join(self, deadline: Deadline) -> None:
        """Wait for the answers in progress; at the deadline, close their connections."""
        with self._lock:
            sessions = list(self._sessions)
        for session in sessions:
            if not session.join(deadline.remaining()):
                logger.warning(
                    "service %s: a call from %s is still running; its connection is closed",
                    self.name,
                    session.peer,
                )
