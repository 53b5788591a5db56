"""Every error this library raises on purpose.

A message says what happened, what was expected and what to do next; the facts
are attributes too, so a program never has to parse the text. Each class has a
second base from the standard library where one says the same thing, so that
`except TimeoutError` and friends work as a Python programmer expects.
"""

from __future__ import annotations

from collections.abc import Mapping

from rosproto.sentence import led, shown
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

    Its text may quote a peer, a bag or a file; `str(error)` is fit for a terminal and a log all the same, see
    `rosproto.text`. Attributes, and `args`, hold what came.

    Attributes:
        exit_code: Of a command that ends by this error.
        peer: The other side, "" where there is none.
        why: What happened there, without who asked for what; "" when the text itself is as short.
    """

    exit_code = 1
    peer = ""
    why = ""

    def __str__(self) -> str:
        return shown(super().__str__(), keep="\n\t")

    def __reduce__(self) -> tuple[object, ...]:
        """Copies and pickles of the finished error; without this they would be made of its text alone.

        (A worker whose error cannot be unpickled makes multiprocessing.Pool wait for ever.)
        """
        return _restored, (type(self), self.args), self.__dict__


class DefinitionError(RosError, ValueError):
    """A .msg, .srv or .action text is missing or wrong.

    Attributes:
        file: File or other origin of the text, None when unknown.
        line: Line number, from 1; None when the whole text is meant.
    """

    def __init__(self, message: str, *, file: str | None = None, line: int | None = None) -> None:
        where = "" if file is None else file if line is None else f"{file}:{line}"
        super().__init__(f"{where}: {message}" if where else message)
        self.file = file
        self.line = line


class CodecError(RosError, ValueError):
    """Bytes and definition, or value and definition, disagree.

    Attributes:
        type_name: Message type, as "package/Type".
        field_path: Path of the field inside it ("pose.pose.position.x"), "" when unknown.
        offset: Byte offset in the message where decoding failed; None when encoding.
    """

    def __init__(
        self, message: str, *, type_name: str = "", field_path: str = "", offset: int | None = None
    ) -> None:
        where = f"{type_name}.{field_path}" if field_path else type_name
        super().__init__(f"{where}: {message}" if where else message)
        self.type_name = type_name
        self.field_path = field_path
        self.offset = offset


class BagError(RosError):
    """A bag file cannot be read or written.

    Attributes:
        path: The file, None when the bag is a stream.
        offset: Byte offset in the file; None when the whole file is meant.
        reason: What is wrong, without these two.
    """

    def __init__(self, message: str, *, path: str | None = None, offset: int | None = None) -> None:
        at = "" if offset is None else f" (at byte {offset})"
        super().__init__(f"{path}: {message}{at}" if path else f"{message}{at}")
        self.path = path
        self.offset = offset
        self.reason = message


class ProtocolError(RosError):
    """One side of a connection broke the protocol."""


class LocalProtocolError(ProtocolError):
    """This side did something illegal: the calling program must be fixed."""


class RemoteProtocolError(ProtocolError):
    """The other side did something illegal: that one connection is dropped."""


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
        size: What was announced.
        limit: What is allowed.
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
    """The master (or a node's slave API) answered "no".

    Attributes:
        method: XML-RPC method that was called.
        code: Status code of the reply: -1 caller's error, 0 failure; or an XML-RPC fault code.
        text: The other side's own words.
        uri: Who answered.
    """

    def __init__(self, method: str, code: int, text: str, *, uri: str = "") -> None:
        super().__init__(f"{method} refused{' by ' + uri if uri else ''}: {printable(text)} (status {code})")
        self.method = method
        self.code = code
        self.text = text
        self.uri = uri


class RegistrationsRefused(MasterError):
    """The master refused several registrations of one request (`Node.registering`); the others stand.

    Attributes:
        refused: Why, for each: ("publisher", "/topic") -> its own error.
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
    """A service answered with an error instead of a response, or is not there.

    Attributes:
        service: Resolved service name.
        text: The provider's own words.
    """

    def __init__(self, service: str, text: str) -> None:
        super().__init__(led(f"service {service}", shown(text)))
        self.service = service
        self.text = text


class ConnectionLost(RosError, ConnectionError):
    """A connection could not be made, or ended.

    Attributes:
        peer: "host:port" or URI of the other side.
        why: What happened there, see `RosError`.
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
        seconds: How long.
        peer: Who did not answer; "" when it was not one.
        why: What happened there, see `RosError`.
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
