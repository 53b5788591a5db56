"""One TCPROS connection of a service client: handshake, then requests and answers in turn.

Source: wiki.ros.org/ROS/TCPROS; rospy impl/tcpros_service.py and roscpp service_server_link.cpp where it is
silent. The caller's own thread sends and receives (a reader thread would cost one more wake-up per call), so
one link serves one call at a time; `ServiceClient` sees to that.
"""

from __future__ import annotations

import select
import socket
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from rosproto.codec import Message
from rosproto.errors import ConnectionLost, RemoteProtocolError, RosError, RosTimeout, ServiceError
from rosproto.node.definitions.md5sum_mismatch import ServiceRevision
from rosproto.protocol.framing import FrameDecoder, frame
from rosproto.protocol.handshake import HandshakeRefused
from rosproto.protocol.wire_limits import Limits
from rosproto.sentence import say
from rosproto.transport.deadline import Deadline
from rosproto.transport.robot_host_names import HostNames
from rosproto.transport.tcp import connect, interrupt, read_header, set_linger, write_header
from rosproto.transport.uri import format_address

FIRST_BUFFER_BYTES = 4 << 10  # enough for most answers
SEND_SECONDS = 0.05
BUFFER_STEP_BYTES = 256 << 10  # growth for a longer one: peers may announce a length and send nothing


class ServiceLink:
    """A connection whose handshake is done.

    Attributes:
        header: The provider's connection header.
        peer: "host:port".
        revision: The provider's revision of the service type; None when it has ours.
    """

    __slots__ = ("_answers", "_poll", "_service", "_sock", "header", "peer", "revision")

    def __init__(
        self, sock: socket.socket, header: dict[str, str], *, service: str, peer: str, limits: Limits
    ) -> None:
        self._sock = sock
        self._service = service
        self._answers = FrameDecoder(limits.message_bytes, room=FIRST_BUFFER_BYTES, step=BUFFER_STEP_BYTES)
        self._poll: Any = None  # a select.poll, which Windows lacks
        self.header = header
        self.peer = peer
        self.revision: ServiceRevision | None = None

    @classmethod
    def open(
        cls,
        address: tuple[str, int],
        fields: Mapping[str, str],
        *,
        service: str,
        limits: Limits,
        deadline: Deadline,
        hosts: HostNames | None = None,
    ) -> ServiceLink:
        """Connect and exchange headers; `hosts` resolves names that the system cannot.

        The request is not sent along with the header, although that would save a round trip: a rospy
        provider loses data that arrives together with the header (measured).

        Raises:
            HandshakeRefused: The provider answered with an error header.
            ConnectionLost: The connection was refused, or the provider closed it.
            RosTimeout: The deadline passed.
            RemoteProtocolError: The answer is not a connection header.
        """
        peer = format_address(*address)
        sock = connect(address[0], address[1], deadline, hosts=hosts)
        try:
            write_header(sock, fields, deadline)
            header = read_header(sock, limits, deadline)
            if "error" in header:
                raise HandshakeRefused(service, peer, header["error"])
        except BaseException:
            sock.close()
            raise
        return cls(sock, header, service=service, peer=peer, limits=limits)

    @property
    def usable(self) -> bool:
        """False if the provider closed the idle link or sent unexpected data: do not send a request."""
        return self._sock.fileno() >= 0 and not self._readable()

    def _readable(self) -> bool:
        if sys.platform == "win32" or not hasattr(select, "poll"):
            return bool(select.select([self._sock], [], [], 0)[0])
        if self._poll is None:
            self._poll = select.poll()
            self._poll.register(self._sock, select.POLLIN)
        return bool(self._poll.poll(0))

    def call(self, request: bytes | None, deadline: Deadline) -> bytes:
        """Send one encoded request, return the encoded response.

        After any error but ServiceError the link is out of step: close it.

        Args:
            request: None waits for the answer to the request that `post` has sent.
            deadline: For all of it.

        Raises:
            ServiceError: The provider reported failure; with its text. The link stays in step.
            ConnectionLost: The link ended; the request may or may not have been carried out.
            RosTimeout: No complete answer in time; the request may or may not have been carried out.
            TooLarge: The response is longer than `Limits.message_bytes`.
            RemoteProtocolError: More than one answer came.
        """
        try:
            self._sock.settimeout(deadline.for_socket())
            if request is not None:
                self._sock.sendall(frame(request))
            ok, body = self._read_answer(deadline)
        except BaseException as error:
            # The call has failed for the caller: the system must not retransmit the request for minutes and
            # deliver it late.
            set_linger(self._sock, False)
            if isinstance(error, RosError) or not isinstance(error, OSError):
                raise
            raise (self._late() if isinstance(error, TimeoutError) else self._lost(error)) from error
        if not ok:
            raise ServiceError(self._service, body.decode("utf-8", "backslashreplace"))
        return body

    def prepare(self) -> None:
        """Let a later `post` fail instead of waiting."""
        self._sock.settimeout(SEND_SECONDS)

    def post(self, request: bytes) -> None:
        """Send one encoded request without waiting for its answer; call `prepare` first, `call` afterwards.

        Raises:
            OSError: The link has ended.
        """
        self._sock.sendall(frame(request))

    def _read_answer(self, deadline: Deadline) -> tuple[bool, bytes]:
        """The ok byte and the frame after it."""
        answers, ok = self._answers, None
        while True:
            count = self._sock.recv_into(answers.space())
            if not count:
                raise self._lost(None)
            answers.received(count)
            ok = answers.take(1) if ok is None else ok
            if ok is not None and (body := answers.next_frame()) is not None:
                break
            self._sock.settimeout(deadline.for_socket())
        if answers.buffered:
            text = "service {name}: {peer} sent {count} bytes after its answer"
            raise RemoteProtocolError(say(text, name=self._service, peer=self.peer, count=answers.buffered))
        return ok != b"\0", body

    def _late(self) -> RosTimeout:
        text = "service {name}: {peer} did not answer in time; the request may still be carried out"
        what = f"answer of service {self._service}"
        return RosTimeout(say(text, name=self._service, peer=self.peer), what=what)

    def _lost(self, cause: OSError | None) -> ConnectionLost:
        why = f" ({cause})" if cause is not None and str(cause) else ""
        text = (
            "service {name}: {peer} closed the connection before it answered{why}; the request may "
            "or may not have been carried out"
        )
        return ConnectionLost(say(text, name=self._service, peer=self.peer, why=why), peer=self.peer)

    def close(self) -> None:
        """End the connection; a call waiting in another thread gets ConnectionLost at once."""
        interrupt(self._sock)
        self._sock.close()


class Cancellation:
    """Ends one call from another thread; used by `rosproto.aio`."""

    __slots__ = ("_link", "_lock", "cancelled")

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._link: ServiceLink | None = None
        self.cancelled = False

    def cancel(self) -> None:
        """End the call; an unsent request is not sent any more."""
        with self._lock:
            self.cancelled = True
            if self._link is not None:
                self._link.close()

    @contextmanager
    def covering(self, link: ServiceLink) -> Iterator[None]:
        """Have `cancel` close `link` while the context is active."""
        with self._lock:
            if self.cancelled:
                raise ConnectionLost("the call was cancelled before its request was sent", peer=link.peer)
            self._link = link
        try:
            yield
        finally:
            with self._lock:
                self._link = None


class PreparedCall:
    """A call that is encoded and connected in advance, made by `ServiceClient.prepare`. Close it after use.

    For calls that must work when no thread can be started, no file opened, or a signal handler has
    interrupted a frame that holds locks. `send` only writes bytes to a socket.

    Args:
        link: The connection, used only by this call.
        body: The request, encoded for the provider's revision.
        decode: Decodes the answer to the response.
        drop: Closes the connection.
    """

    def __init__(
        self,
        link: ServiceLink,
        body: bytes,
        decode: Callable[[ServiceLink, bytes], Message],
        drop: Callable[[ServiceLink], None],
    ) -> None:
        self._link = link
        self._body = body
        self._decode = decode
        self._drop = drop
        self._turn = threading.Lock()
        self._answer: Message | None = None
        self.sent = False
        link.prepare()

    @property
    def usable(self) -> bool:
        """Whether it can be sent: it was not sent before, and the connection is still open."""
        return not self.sent and self._link.usable

    def send(self) -> bool:
        """Write the request, once; False if the connection has ended.

        Does not wait, neither for a lock nor for the answer.
        """
        if self.sent:
            return True
        try:
            self._link.post(self._body)
        except (RosError, OSError):
            return False
        self.sent = True
        return True

    def answer(self, timeout: float) -> Any:
        """Wait for the response.

        Raises:
            ServiceError: The provider reported failure; with its text.
            ConnectionLost: Nothing was sent, or the provider ended the connection.
            RosTimeout: Not in time.
        """
        if not self.sent:
            raise ConnectionLost("nothing was sent on this connection")
        with self._turn:
            if self._answer is None:
                self._answer = self._decode(self._link, self._link.call(None, Deadline(timeout)))
            return self._answer

    def close(self) -> None:
        """End the connection."""
        self._drop(self._link)
