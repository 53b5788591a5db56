"""The calling side of a service.

One deadline covers a whole call: lookup, connect, handshake, request, response. The provider's address is
cached between calls, since the lookup takes more than half the time of a one-shot call. If the connection
fails or another node answers, it is looked up again, which is safe because no request has been sent yet.
A sent request is never repeated, because service calls are not idempotent.

Source: wiki.ros.org/ROS/TCPROS, wiki.ros.org/Services; rospy impl/tcpros_service.py.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import Any

from rosproto.codec import Message, ServiceType, decode, encode
from rosproto.errors import (
    ConnectionLost,
    LocalProtocolError,
    Md5sumMismatch,
    RosError,
    RosTimeout,
    ServiceError,
)
from rosproto.logs import get_logger
from rosproto.node.context import Context
from rosproto.node.definitions.md5sum_mismatch import ServiceRevision, note_differences, revised_service
from rosproto.node.services import probe as service_probe
from rosproto.node.services.link import Cancellation, PreparedCall, ServiceLink
from rosproto.protocol.handshake import (
    HandshakeRefused,
    check_service_server_header,
    service_client_header,
)
from rosproto.sentence import led, say
from rosproto.transport.deadline import Deadline
from rosproto.transport.uri import format_address

logger = get_logger("rosproto.node")

MAX_GUESS_SECONDS = 3.0  # seconds for a handshake at a cached address


class _Refused(ServiceError):
    """The provider refused the connection, so no request was sent; a ServiceError to the caller."""


class ServiceClient:
    """Calls one service; any number of threads may call at the same time.

    A one-shot client (`persistent=False`) makes a connection per call and follows a provider that moves.
    A persistent one keeps its connection: a call takes a tenth of the time, and calls of several threads run
    one after the other. A connection that has ended before a request is sent is replaced.

    Attributes:
        name: Resolved service name.
        type_name: "package/Type".
        md5sum: md5sum of our definition.
        persistent: See above.
        lossless: A request with values for which the provider's revision has no field is an error
            (`ValuesLost`), and is not sent. False: such values are dropped. May be changed at any time.
    """

    def __init__(
        self,
        context: Context,
        name: str,
        service_class: type[ServiceType],
        *,
        persistent: bool = False,
        on_close: Callable[[ServiceClient], None],
    ) -> None:
        self.name = name
        self.type_name: str = service_class._type
        self.md5sum: str = service_class._md5sum
        self.persistent = persistent
        self.lossless = False
        self._context = context
        self._class = service_class
        self._request_class = service_class._request_class
        self._response_class = service_class._response_class
        self._header = service_client_header(
            service=name,
            md5sum=self.md5sum,
            callerid=context.name,
            type_name=self.type_name,
            persistent=persistent,
        )
        self._on_close = on_close
        self._revision: ServiceRevision | None = None
        self._address: tuple[str, int] | None = None
        self._lock = threading.Lock()
        self._turn = threading.Lock()  # one call at a time on the persistent link
        self._kept: ServiceLink | None = None
        self._open: set[ServiceLink] = set()
        self._stop = threading.Event()
        self._calls = self._errors = self._lookups = self._connects = 0

    def __repr__(self) -> str:
        kind = "persistent" if self.persistent else "one-shot"
        return (
            f"<ServiceClient {self.name} {self.type_name} {kind}{' closed' if self._stop.is_set() else ''}>"
        )

    def __enter__(self) -> ServiceClient:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()

    @property
    def address(self) -> tuple[str, int] | None:
        """Cached host and port of the provider; None if the next call looks it up."""
        return self._address

    def call(self, request: object = None, timeout: float | None = 10.0, **fields: object) -> Any:
        """Call the service and wait for its response.

        Args:
            request: A request message; leave it out and give its fields instead: `call(data=True)`.
            timeout: Seconds for everything together; None waits for ever.
            **fields: Fields of the request. One whose name is an argument here needs a request message.

        Returns:
            The response message.

        Raises:
            ServiceError: There is no provider, or the provider reported failure (`text` is its message).
            Md5sumMismatch: The provider has another definition of the type.
            ConnectionLost: The provider cannot be reached, or ended before it answered.
            RosTimeout: Time is up. A request that was sent (see the text) may still be carried out.
            MasterError: The lookup at the master failed.
        """
        return self._call(None, request, timeout, fields)

    def call_cancellable(
        self,
        cancellation: Cancellation,
        request: object = None,
        timeout: float | None = 10.0,
        **fields: object,
    ) -> Any:
        """As `call`; `cancellation.cancel()` in another thread ends it at once with ConnectionLost."""
        return self._call(cancellation, request, timeout, fields)

    def _call(
        self,
        cancellation: Cancellation | None,
        request: object,
        timeout: float | None,
        fields: Mapping[str, object],
    ) -> Message:
        deadline = Deadline(timeout)
        message = self._request(request, fields)
        body = encode(message)
        self._calls += 1
        try:
            exchange = self._call_kept if self.persistent else self._call_once
            link, answer = exchange(message, body, deadline, cancellation)
        except RosError as error:
            self._errors += 1
            if isinstance(error, RosTimeout):
                error.seconds = timeout
            raise
        return self._response(link, answer)

    def _response(self, link: ServiceLink, answer: bytes) -> Message:
        if link.revision is None:
            response = decode(self._response_class, answer)
        else:
            response = link.revision.response_to_ours(decode(link.revision.response_class, answer))
        response._connection_header = link.header
        return response

    def prepare(self, request: object = None, timeout: float | None = 10.0, **fields: object) -> PreparedCall:
        """Connect and encode a request in advance, so that sending it later does not wait.

        The call has its own connection, which is kept until the call or this client is closed, also for a
        one-shot client.

        Raises:
            CodecError: A value does not fit its field.
            ServiceError, ConnectionLost, RosTimeout: There is no provider, or it cannot be reached.
        """
        deadline = Deadline(timeout)
        message = self._request(request, fields)
        link = self._connect(deadline, {**self._header, "persistent": "1"})
        try:
            body = self._encoded(link, message)
            return PreparedCall(link, body, self._response, self._drop)
        except BaseException:
            self._drop(link)
            raise

    def _encoded(self, link: ServiceLink, request: Message) -> bytes:
        """Encode a request for the provider's revision."""
        if link.revision is None:
            return encode(request)
        if self.lossless:
            link.revision.request_to_theirs.require_lossless(request)
        return encode(link.revision.request_to_theirs(request))

    __call__ = call

    def _request(self, request: Any, fields: Mapping[str, object]) -> Message:
        if request is None:
            return self._request_class(**fields)
        if fields:
            raise TypeError(say("service {name}: give a request or its fields, not both", name=self.name))
        if getattr(request, "_type", None) != self._request_class._type:
            given = getattr(request, "_type", type(request).__name__)
            text = "service {name}: the request is a {given}, expected {expected}"
            raise TypeError(say(text, name=self.name, given=given, expected=self._request_class._type))
        message: Message = request
        return message

    def _call_once(
        self, request: Message, body: bytes, deadline: Deadline, cancellation: Cancellation | None
    ) -> tuple[ServiceLink, bytes]:
        link = self._connect(deadline)
        try:
            return link, self._exchange(link, request, body, deadline, cancellation)
        finally:
            self._drop(link)

    def _call_kept(
        self, request: Message, body: bytes, deadline: Deadline, cancellation: Cancellation | None
    ) -> tuple[ServiceLink, bytes]:
        if not self._turn.acquire(False):
            self._wait_for_turn(deadline)
        try:
            link = self._kept
            if link is not None and not link.usable:
                logger.debug("! service %s: %s closed the idle connection", self.name, link.peer)
                self._drop(link)
                link = self._kept = None
            if link is None:
                link = self._kept = self._connect(deadline)
            try:
                return link, self._exchange(link, request, body, deadline, cancellation)
            except ServiceError:
                raise  # the provider reported failure; the link is still in step
            except BaseException:
                self._kept = None
                self._drop(link)
                raise
        finally:
            self._turn.release()

    def _exchange(
        self,
        link: ServiceLink,
        request: Message,
        body: bytes,
        deadline: Deadline,
        cancellation: Cancellation | None,
    ) -> bytes:
        if link.revision is not None:
            body = self._encoded(link, request)
        if cancellation is None:
            return link.call(body, deadline)
        with cancellation.covering(link):
            return link.call(body, deadline)

    def _wait_for_turn(self, deadline: Deadline) -> None:
        remaining = deadline.remaining()
        if not self._turn.acquire(timeout=-1 if remaining is None else remaining):
            raise RosTimeout(
                f"service {self.name}: other threads' calls held the persistent connection all the time; the"
                " request was not sent. Use one client per thread where calls must not wait for each other",
                what=f"turn on the connection of service {self.name}",
            )

    def _connect(self, deadline: Deadline, header: Mapping[str, str] | None = None) -> ServiceLink:
        """A new link to the current provider; a cached address is discarded when it fails."""
        remembered = self._address
        if remembered is None:
            return self._open_link(self._look_up(deadline), deadline, header)
        remaining = deadline.remaining()
        # A computer that is gone does not answer: leave time for the other address.
        half = Deadline(MAX_GUESS_SECONDS if remaining is None else min(MAX_GUESS_SECONDS, remaining / 2))
        try:
            return self._open_link(remembered, half, header)
        except (ConnectionLost, RosTimeout, _Refused, Md5sumMismatch) as error:
            if self._stop.is_set():
                raise
            logger.debug("= service %s: %s, looking it up again", self.name, error)
            return self._open_link(self._look_up(deadline), deadline, header)

    def _look_up(self, deadline: Deadline) -> tuple[str, int]:
        self._lookups += 1
        return service_probe.lookup(self._context, self.name, deadline)

    def _open_link(
        self, address: tuple[str, int], deadline: Deadline, header: Mapping[str, str] | None = None
    ) -> ServiceLink:
        if self._stop.is_set():
            raise LocalProtocolError(led(say("service {name}", name=self.name), "this client is closed"))
        try:
            try:
                link = self._shake_hands(address, deadline, self._revision, header)
            except Md5sumMismatch as mismatch:
                link = self._shake_hands(address, deadline, self._revise(mismatch), header)
        except BaseException:
            if self._address == address:  # calls of other threads may have changed it
                self._address = None
            raise
        self._revision = link.revision
        self._address = address
        return link

    def _shake_hands(
        self,
        address: tuple[str, int],
        deadline: Deadline,
        revision: ServiceRevision | None,
        fields: Mapping[str, str] | None,
    ) -> ServiceLink:
        self._connects += 1
        header = dict(fields or self._header)
        if revision is not None:
            header["md5sum"] = revision.md5sum
        try:
            link = ServiceLink.open(
                address,
                header,
                service=self.name,
                limits=self._context.limits,
                deadline=deadline,
                hosts=self._context.hosts,
            )
        except HandshakeRefused as refusal:
            raise self._explained(refusal, address, deadline, header["md5sum"]) from None
        link.revision = revision
        self._keep_track(link)
        try:
            self._check(link.header, link.peer, header["md5sum"])
        except BaseException:
            self._drop(link)
            raise
        return link

    def _revise(self, mismatch: Md5sumMismatch) -> ServiceRevision | None:
        """The provider's revision; None if its md5sum is ours (the provider was replaced)."""
        if mismatch.remote_md5sum == self.md5sum:
            return None
        if mismatch.remote_type not in ("", self.type_name) or len(mismatch.remote_md5sum) != 32:
            raise mismatch
        revision = revised_service(self._context.definitions, self._class, mismatch.remote_md5sum, mismatch)
        note_differences(self._context.peer_log, self.name, mismatch.peer, revision.request_to_theirs)
        return revision

    def _check(self, header: dict[str, str], peer: str, md5sum: str) -> None:
        check_service_server_header(
            header, service=self.name, type_name=self.type_name, md5sum=md5sum, peer=peer
        )

    def _explained(
        self, refusal: HandshakeRefused, address: tuple[str, int], deadline: Deadline, md5sum: str
    ) -> RosError:
        """Explain an error header, which is only text: a wildcard probe shows whether the md5sums differ."""
        try:
            header = service_probe.probe(self._context, self.name, deadline, address=address)
            self._check(header, format_address(*address), md5sum)
        except Md5sumMismatch as mismatch:
            return mismatch
        except RosError:
            pass  # keep the provider's own message
        return _Refused(self.name, refusal.text)

    def _keep_track(self, link: ServiceLink) -> None:
        with self._lock:
            if not self._stop.is_set():
                self._open.add(link)
                return
        link.close()
        raise ConnectionLost(say("service {name}: this client was closed", name=self.name), peer=link.peer)

    def _drop(self, link: ServiceLink) -> None:
        with self._lock:
            self._open.discard(link)
        link.close()

    def wait(self, timeout: float | None = 10.0, *, stop: threading.Event | None = None) -> None:
        """Wait until a provider answers a probe.

        Args:
            timeout: Seconds; None waits for ever.
            stop: Ends the wait when set, in place of closing this client.

        Raises:
            RosTimeout: No provider answered in time; the text gives the reason.
            ConnectionLost: This client was closed, or `stop` was set.
        """
        service_probe.wait(self._context, self.name, timeout, stop=stop or self._stop)

    def stats(self) -> dict[str, int]:
        """Counters since the start: calls, errors, lookups, connects; and connections open now."""
        return {
            "calls": self._calls,
            "errors": self._errors,
            "lookups": self._lookups,
            "connects": self._connects,
            "connections": len(self._open),
        }

    def add_headers(self, fields: Mapping[str, str]) -> None:
        """Add fields to the connection header, from the next connection on."""
        self._header.update(fields)

    def abandon(self) -> None:
        """Mark as closed in a forked process, without taking locks of the parent's threads."""
        self._stop, self._kept, self._open = threading.Event(), None, set()
        self._stop.set()
        self._lock, self._turn = threading.Lock(), threading.Lock()

    def close(self) -> None:
        """Close all connections; calls in progress raise ConnectionLost at once. May be called again."""
        with self._lock:
            self._stop.set()
            links = list(self._open)
            self._open.clear()
        for link in links:
            link.close()
        self._on_close(self)
