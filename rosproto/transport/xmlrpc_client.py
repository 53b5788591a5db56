"""An XML-RPC client for masters and nodes, over `HttpClient`."""

from __future__ import annotations

from rosproto.errors import MasterError, RemoteProtocolError, TooLarge
from rosproto.protocol import xmlrpc
from rosproto.sentence import both, say
from rosproto.transport.deadline import Deadline
from rosproto.transport.http_client import HttpClient


class LastReply:
    """The last reply to a question that is asked again and again, to decode it only when it has changed.

    Attributes:
        body: Its bytes.
        value: What they mean; not to be changed.
    """

    def __init__(self) -> None:
        self.body = b""
        self.value: object = None


class XmlRpcClient(HttpClient):
    """A client of one XML-RPC server: the calls of the master and slave API may be repeated safely."""

    def call(
        self,
        method: str,
        *params: object,
        timeout: float | None = None,
        retry: bool = True,
        last: LastReply | None = None,
    ) -> object:
        """Call a method and return its value.

        Args:
            method: XML-RPC method name.
            params: Its arguments.
            timeout: Seconds for connecting, sending and receiving together; None takes the client's.
            retry: Send once more if a kept connection turns out to be closed; False for a method that must
                not run twice.
            last: The reply before; if this one has the same bytes, its value is returned again.

        Raises:
            MasterError: The server replied with a fault.
            ConnectionLost: It cannot be reached, or the connection broke.
            RosTimeout: The time-out passed.
            RemoteProtocolError: The reply is not an XML-RPC response.
            LocalProtocolError: An argument cannot be sent.
        """
        deadline = Deadline(self.timeout if timeout is None else timeout, self._clock)
        body = xmlrpc.encode_call(method, params)
        try:
            response = self.post(method, body, deadline, retry=retry)
            if response.status != 200:
                raise RemoteProtocolError(f"HTTP {response.status} {response.reason}, expected 200 OK")
            if last is not None and last.body == response.body:
                return last.value
            value = xmlrpc.decode_response(response.body, self._limits)
            if last is not None:
                last.body, last.value = response.body, value
            return value
        except RemoteProtocolError as error:
            hint = () if isinstance(error, TooLarge) else ("is this a ROS master or node?",)
            error.peer, error.why = self.uri, both(str(error), *hint)
            text = say("{method} at {uri}: {error}", method=method, uri=self.uri, error=error.why)
            error.args = (text, *error.args[1:])
            raise
        except xmlrpc.Fault as fault:
            raise MasterError(method, fault.code, fault.text, uri=self.uri) from fault


def unpack(method: str, reply: object, uri: str = "") -> object:
    """The value of a ROS reply `[code, statusMessage, value]`.

    Peers are inexact: a missing value is None, a code may be a bool.

    Raises:
        MasterError: The code is not 1 (-1: the caller's error, 0: the other side failed).
        RemoteProtocolError: The reply has no code.
    """
    if not isinstance(reply, list) or not reply or not isinstance(reply[0], int):
        raise RemoteProtocolError(
            f"{method}{' at ' + uri if uri else ''}: reply {reply!r:.80}, "
            "expected [code, statusMessage, value]"
        )
    text = reply[1] if len(reply) > 1 else ""
    if reply[0] != 1:
        raise MasterError(method, int(reply[0]), str(text), uri=uri)
    return reply[2] if len(reply) > 2 else None
