"""All errors that rosproto raises on purpose.

A message says what happened, what was expected and what to do next. The facts are attributes as well, so no
program has to parse the text. Where a standard class fits, it is a second base, so that `except TimeoutError`
works as expected.
"""

from __future__ import annotations

from collections.abc import Mapping

from rosproto.sentence import led, say, shown
from rosproto.text import printable

__all__ = [
    "BagError",
    "CodecError",
    "ConnectionLost",
    "DefinitionError",
    "LocalProtocolError",
    "MasterError",
    "Md5sumMismatch",
    "ProtocolError",
    "RegistrationsRefused",
    "RemoteProtocolError",
    "RosError",
    "RosTimeout",
    "ServiceError",
    "TooLarge",
]


class RosError(Exception):
    """Base of every error raised by rosproto and woosh_pure.

    The text may quote a peer, a bag or a file; `str(error)` escapes control characters (see `rosproto.text`).
    Attributes and `args` hold the original text.

    Attributes:
        exit_code: Exit code of a command that ends with this error.
        peer: The other side, "" if there is none.
        why: The cause alone, without the operation that failed; "" if the text is as short.
    """

    exit_code = 1
    peer = ""
    why = ""

    def __str__(self) -> str:
        return shown(super().__str__(), keep="\n\t")

    def __reduce__(self) -> tuple[object, ...]:
        """Copy and pickle the finished error; the default would call the constructor with the text alone.

        (multiprocessing.Pool waits for ever when a worker's error cannot be unpickled.)
        """
        return _restored, (type(self), self.args), self.__dict__


class DefinitionError(RosError, ValueError):
    """A .msg, .srv or .action text is missing or invalid.

    Attributes:
        file: File or other origin of the text, None when unknown.
        line: Line number, from 1; None when the whole text is meant.
    """

    def __init__(self, message: str, *, file: str | None = None, line: int | None = None) -> None:
        where = "" if file is None else file if line is None else f"{file}:{line}"
        super().__init__(led(where, message) if where else message)
        self.file = file
        self.line = line


class CodecError(RosError, ValueError):
    """Bytes or a value do not match the definition.

    Attributes:
        type_name: Message type, as "package/Type".
        field_path: Path of the field inside it ("pose.pose.position.x"), "" when unknown.
        offset: Byte offset in the message where decoding failed; None when encoding.
    """

    def __init__(
        self, message: str, *, type_name: str = "", field_path: str = "", offset: int | None = None
    ) -> None:
        where = f"{type_name}.{field_path}" if field_path else type_name
        super().__init__(led(where, message) if where else message)
        self.type_name = type_name
        self.field_path = field_path
        self.offset = offset


class BagError(RosError):
    """A bag file cannot be read or written.

    Attributes:
        path: The file, None when the bag is a stream.
        offset: Byte offset in the file; None when the whole file is meant.
        reason: The message without path and offset.
    """

    def __init__(self, message: str, *, path: str | None = None, offset: int | None = None) -> None:
        text = message if offset is None else say("{text} (at byte {at})", text=say(message), at=offset)
        super().__init__(led(path, text) if path else text)
        self.path = path
        self.offset = offset
        self.reason = message


class ProtocolError(RosError):
    """One side of a connection broke the protocol."""


class LocalProtocolError(ProtocolError):
    """This side broke the protocol: fix the calling program."""


class RemoteProtocolError(ProtocolError):
    """The other side broke the protocol: that connection is dropped."""


class Md5sumMismatch(RemoteProtocolError):
    """Two sides of a link have different definitions of a type.

    Attributes:
        name: Topic or service.
        peer: Address or URI of the other side.
        type_name: Our type.
        md5sum: Our md5sum.
        remote_type: The other side's type; "" when it did not say.
        remote_md5sum: The other side's md5sum; "" when it did not say.
        message_definition: The other side's full definition text; "" when it did not send one.
    """

    def __init__(
        self,
        message: str,
        *,
        name: str = "",
        peer: str = "",
        type_name: str = "",
        md5sum: str = "",
        remote_type: str = "",
        remote_md5sum: str = "",
        message_definition: str = "",
    ) -> None:
        super().__init__(message)
        self.name = name
        self.peer = peer
        self.type_name = type_name
        self.md5sum = md5sum
        self.remote_type = remote_type
        self.remote_md5sum = remote_md5sum
        self.message_definition = message_definition


class TooLarge(RemoteProtocolError):
    """The other side announced more than a limit allows.

    Attributes:
        what: Name of the limit, a field of `rosproto.protocol.wire_limits.Limits`.
        size: The size announced.
        limit: The size allowed.
    """

    def __init__(self, what: str, size: int, limit: int) -> None:
        super().__init__(
            f"{what}: {size} announced, at most {limit} allowed; the peer is broken or hostile, "
            f"or raise Limits.{what}"
        )
        self.what = what
        self.size = size
        self.limit = limit


class MasterError(RosError):
    """The master, or a node's slave API, answered with an error.

    Attributes:
        method: XML-RPC method that was called.
        code: Status code of the reply: -1 caller's error, 0 failure; or an XML-RPC fault code.
        text: The text of the reply.
        uri: The server that replied.
    """

    def __init__(self, method: str, code: int, text: str, *, uri: str = "") -> None:
        super().__init__(f"{method} refused{' by ' + uri if uri else ''}: {printable(text)} (status {code})")
        self.method = method
        self.code = code
        self.text = text
        self.uri = uri


class RegistrationsRefused(MasterError):
    """The master refused some registrations of a batch (`Node.batch`); the others remain.

    Attributes:
        refused: ("publisher", "/topic") -> the error of that registration.
    """

    def __init__(self, refused: Mapping[tuple[str, str], RosError], *, among: int, uri: str = "") -> None:
        first = next(iter(refused.values()))
        super().__init__(
            getattr(first, "method", ""), getattr(first, "code", 0), getattr(first, "text", ""), uri=uri
        )
        reasons = "; ".join(f"{kind} {name}: {error}" for (kind, name), error in refused.items())
        self.args = (f"{len(refused)} of {among} registrations were refused by {uri}: {printable(reasons)}",)
        self.refused = dict(refused)


class ServiceError(RosError):
    """A service replied with an error instead of a response, or does not exist.

    Attributes:
        service: Resolved service name.
        text: The provider's error text.
    """

    def __init__(self, service: str, text: str) -> None:
        super().__init__(led(say("service {name}", name=service), shown(text)))
        self.service = service
        self.text = text


class ConnectionLost(RosError, ConnectionError):
    """A connection could not be made, or ended.

    Attributes:
        peer: "host:port" or URI of the other side.
        why: The cause, see `RosError`.
    """

    exit_code = 4

    def __init__(self, message: str, *, peer: str = "", why: str = "") -> None:
        super().__init__(message)
        self.peer = peer
        self.why = why


class RosTimeout(RosError, TimeoutError):
    """Something did not happen in time.

    Attributes:
        what: What was waited for.
        seconds: The time-out.
        peer: The peer that did not answer; "" if none was involved.
        why: The cause, see `RosError`.
    """

    def __init__(
        self, message: str, *, what: str = "", seconds: float | None = None, peer: str = "", why: str = ""
    ) -> None:
        super().__init__(message)
        self.what = what
        self.seconds = seconds
        self.peer = peer
        self.why = why


def _restored(cls: type[RosError], args: tuple[object, ...]) -> RosError:
    error = cls.__new__(cls, *args)
    error.args = args
    return error
