"""The providing side of a service.

Source: wiki.ros.org/ROS/TCPROS, wiki.ros.org/Services; rospy impl/tcpros_service.py.
"""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable, Mapping
from typing import Any

from rosproto.codec import decode
from rosproto.errors import ConnectionLost, Md5sumMismatch, RemoteProtocolError, RosTimeout, ServiceError
from rosproto.logs import get_logger
from rosproto.node.context import Context
from rosproto.node.graph.endpoints import refuse
from rosproto.node.revisions.revisions import ServiceRevision, note_differences, revised_service
from rosproto.node.services.reply import encode_error, encode_reply, error_text, response_from
from rosproto.node.services.session import ServiceSession
from rosproto.protocol.handshake import ServiceRequest, check_service_client_header, service_server_header
from rosproto.transport.deadline import Deadline
from rosproto.transport.tcpros_io import write_header

logger = get_logger("rosproto.node")


class ServiceServer:
    """Provides one service; made by `Node.service_server`.

    The handler is called with the request in the thread of that client's connection ("rosproto:..."), so
    several calls run at the same time when several clients call: guard what they share. It returns a
    response, a dict of its fields, a tuple or list of all fields in order, the bare value for a response of
    one field, or None for a response without fields. An exception in it, or another value, makes the call
    fail: the caller gets its text, the log the whole traceback, and the connection lives on. Raise
    `ServiceError(server.name, "why")` to say no in plain words, without a traceback.

    Attributes:
        name: Resolved service name.
        type_name: "package/Type".
        md5sum: Of our definition.
        on_refused: Called with the connection header of a client that does not fit, and why; None at first.
    """

    def __init__(
        self,
        context: Context,
        name: str,
        service_class: Any,
        handler: Callable[[Any], Any],
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
        """Serve one connection whose header names this service; returns when it is over.

        Called by the node in the connection's own thread. Probes, and clients that leave without a request,
        are served in silence.

        Raises:
            Md5sumMismatch, RemoteProtocolError: The client does not fit; it has been told so.
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
        """What the client wants, and its revision of the service when that is not ours."""
        try:
            return check_service_client_header(
                header, service=self.name, type_name=self.type_name, md5sum=self.md5sum, peer=peer
            ), None
        except Md5sumMismatch as mismatch:
            if mismatch.remote_type not in ("", self.type_name):
                raise
            revision = revised_service(self._context.revisions, self._class, header["md5sum"], mismatch)
        asked = check_service_client_header(
            header, service=self.name, type_name=self.type_name, md5sum=revision.md5sum, peer=peer
        )
        if not asked.probe:
            note_differences(self._context.said, self.name, asked.callerid or peer, revision.request_to_ours)
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
            said=self._context.said,
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
        """Bytes of the answer to one encoded request; never raises.

        A `sys.exit()` in a handler would end this thread only, and the caller would not learn why.
        """
        self._calls += 1
        try:
            if revision is None:
                request = decode(self._request_class, data)
            else:
                request = revision.request_to_ours(decode(revision.request_class, data))
            request._connection_header = header
            response = response_from(self._handler(request), self._response_class)
            return encode_reply(response if revision is None else revision.response_to_theirs(response))
        except BaseException as error:
            self._errors += 1
            self._report(error, header)
            return encode_error(error_text(error))

    def _report(self, error: BaseException, header: dict[str, str]) -> None:
        """A refusal in plain words is no defect; anything else gets its traceback."""
        caller = header.get("callerid", "")
        if isinstance(error, ServiceError):
            self._context.said.info(self.name, "service %s told %s: %s", self.name, caller, error.text)
        else:
            text = "service %s: the call of %s failed"
            self._context.said.error(self.name, text, self.name, caller, exc_info=error)

    def stats(self) -> dict[str, int]:
        """Counters since the start: calls, errors, accepted connections; and connections open now."""
        return {
            "calls": self._calls,
            "errors": self._errors,
            "accepted": self._connections,
            "connections": len(self._sessions),
        }

    def finish(self) -> None:
        """Begin to close: no new connections, idle ones end, answers in progress go out. Does not wait."""
        with self._lock:
            self._closed = True
            sessions = list(self._sessions)
        for session in sessions:
            session.finish()

    def close(self, timeout: float = 2.0) -> None:
        """Take the service off the master and end its connections. May be called again.

        Requests being served may finish within `timeout` seconds, shared by all of them; what hangs
        longer is cut off.
        """
        self.leave()
        self.join(Deadline(timeout))

    def leave(self) -> None:
        """As `close`, without waiting: requests being served are answered, however long that takes."""
        self._on_close(self)
        self.finish()

    def join(self, deadline: Deadline) -> None:
        """Wait for the answers in progress; cut off what is not done at the deadline."""
        with self._lock:
            sessions = list(self._sessions)
        for session in sessions:
            if not session.join(deadline.remaining()):
                logger.warning("service %s: a call of %s still runs; it is cut off", self.name, session.peer)
