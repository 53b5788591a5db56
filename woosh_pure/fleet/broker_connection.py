"""A vehicle's connection with the broker: paho-mqtt, with what the standard asks for (6.2, 6.14).

Each vehicle has one client of paho with paho's own thread, which connects, reads, writes, pings and connects
again. The last will says CONNECTIONBROKEN; ONLINE follows the connection, and OFFLINE comes before an orderly
end: all three retained, with quality of service 1. Everything else is sent with quality 0 and is not kept
while there is no broker: an old state is no news afterwards, and a new one goes out with the connection.

The client id is derived from the vehicle's topics and never changes: a broker that still holds a broken
connection closes it when the next one arrives, and publishes its CONNECTIONBROKEN before our ONLINE.

A broker that is away is tried every 1 to 2 s. One that is there and does not keep us (a wrong password,
another client of our name, no answer) is tried more and more rarely, a little at random, so that many
vehicles do not try in step. One that does not read costs a bounded number of messages; the rest is dropped
and counted, and a new state follows once it reads again.

MQTT 5 tells the broker how long a message may be, and that retained ones are not wanted: yesterday's order
would move the robot whenever it connects. With a broker that only speaks 3.1.1 that is used; it may have a
limit of its own, and what it has retained is not obeyed.

paho waits by select(), which takes no file beyond the 1024th: a process with more open files cannot have this
connection, and says so.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import socket
import ssl
import sys
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Any

from rosproto.logs import get_logger
from rosproto.transport import Backoff
from woosh_pure.fleet.broker_address import Broker, load_certificates, tls_context
from woosh_pure.fleet.messages.schema import MOST_BYTES

_log = get_logger("woosh_pure.fleet.broker_connection")
MOST_WAITING = 200
"""Messages of one vehicle that wait for a broker which does not read."""
MOST_WAITING_BYTES = 1_000_000
_KEEP_ALIVE = 15  # s, as 6.14 has it
_CONNECT_SECONDS = 2.0
_AWAY = (1.0, 2.0)  # the first and the longest wait for a broker that is away, s
_SENT_AWAY = (
    1.0,
    2.0,
    30.0,
    0.5,
)  # the waits of a connection that a broker does not keep, as `Backoff` has them
_STOOD = 2.0  # s after which a connection that breaks begins anew with short waits
_MOST_PACKET = MOST_BYTES + 65_600  # a message and its topic
_MOST_FILES = 1024  # of select() on POSIX
_END_SECONDS = 1.0  # for paho's thread to end


def paho() -> Any:
    """paho.mqtt.client.

    Raises:
        ImportError: It is not installed; the text names the extra.
    """
    try:
        import paho.mqtt.client as client
    except ImportError as error:
        raise ImportError('VDA 5050 needs paho-mqtt 2: pip install ".[fleet]"', name="paho") from error
    return client


class BrokerConnection:
    """One vehicle's connection with the broker.

    Args:
        broker: Where.
        prefix: Levels of the topics, "uagv/v2/Woosh/A-17".
        connection: Makes a connection message for a state: `connection("ONLINE")`.
        received: Called with topic and payload, in paho's thread; must not wait.
        changed: Called with whether it is connected, in paho's thread, and with True once more when what was
            sent meanwhile was dropped; must not wait.

    Raises:
        ImportError: paho-mqtt is not installed; the text names the extra.
        ValueError: What is in the files is no certificate, or the key of another.
        OSError: A certificate cannot be read.
    """

    def __init__(
        self,
        broker: Broker,
        prefix: str,
        connection: Callable[[str], dict[str, Any]],
        received: Callable[[str, bytes], object],
        changed: Callable[[bool], object],
    ) -> None:
        self._module = paho()
        self._context: ssl.SSLContext | None = tls_context(broker) if broker.tls else None
        self.broker, self.prefix = broker, prefix
        self._connection, self._received, self._changed = connection, received, changed
        self._told = ""  # the last thing that went wrong: said once
        self.retained = 0
        self.dropped = 0
        self.connected = threading.Event()
        self._closing = False
        self._client: Any = None
        self._lock = threading.RLock()
        self._waiting: deque[tuple[Any, int]] = deque()  # what paho has taken and not written yet
        self._waiting_bytes = 0
        self._behind = False
        self._refused = ""
        self._reached = False  # TCP, and TLS, has come to stand
        self._since = math.inf  # when it was connected
        self._sent_away = Backoff(*_SENT_AWAY)

    def __repr__(self) -> str:
        return f"<BrokerConnection {self.prefix} to {self.broker.url}>"

    def open(self) -> None:
        """Begin to connect, and keep trying until `close`."""
        if self._client is None and not self._closing:
            self._start(self._module.MQTTv5)

    def send(self, topic: str, message: dict[str, Any], *, retain: bool = False, quality: int = 0) -> bool:
        """Send a message, or drop it where there is no broker, or one that does not read; whether it was
        sent."""
        client = self._client
        if client is None or not self.connected.is_set():
            return False
        payload = json.dumps(message, separators=(",", ":")).encode()
        with self._lock:
            room = self._has_room(len(payload))
            first, self._behind = not room and not self._behind, self._behind or not room
            if not room:
                self.dropped += 1
            else:
                info = client.publish(f"{self.prefix}/{topic}", payload, qos=quality, retain=retain)
                if quality == 0:
                    self._waiting.append((info, len(payload)))
                    self._waiting_bytes += len(payload)
                room = info.rc == self._module.MQTT_ERR_SUCCESS
        if first:
            self._tell(f"the broker {self.broker.url} does not read: what is sent is dropped until it does")
        return bool(room)

    def _has_room(self, size: int) -> bool:
        """Whether one more message may wait; one always may."""
        waiting = self._waiting
        while waiting and _is_over(waiting[0][0]):
            self._waiting_bytes -= waiting.popleft()[1]
        return not waiting or (
            len(waiting) < MOST_WAITING and self._waiting_bytes + size <= MOST_WAITING_BYTES
        )

    @property
    def waiting(self) -> int:
        """How many messages paho has taken and not written yet."""
        with self._lock:
            self._has_room(0)
            return len(self._waiting)

    def revive(self) -> None:
        """Start paho's thread again if something that a broker sent has ended it; else this does nothing."""
        if self._client is not None and not self._closing:
            self._client.loop_start()

    def close(self, timeout: float = 2.0) -> None:
        """Say OFFLINE, wait for the broker to have it, leave. Bounded."""
        if self._closing:
            return
        self._closing = True
        client = self._client
        if client is None:
            return
        if self.connected.is_set():
            text = json.dumps(self._connection("OFFLINE"))
            try:
                client.publish(f"{self.prefix}/connection", text, qos=1, retain=True).wait_for_publish(
                    timeout
                )
            except (RuntimeError, ValueError) as error:
                _log.warning("! %s: OFFLINE was not sent: %s", self.prefix, error)
        client.disconnect()
        # It joins paho's thread without a limit: that may be in the middle of a try to connect.
        ending = threading.Thread(target=client.loop_stop, name="woosh:mqtt-end", daemon=True)
        ending.start()
        ending.join(_END_SECONDS)
        self.connected.clear()

    # -- paho's client ---------------------------------------------------------------------------------------

    def _start(self, protocol: Any) -> None:
        module, broker = self._module, self.broker
        client = module.Client(module.CallbackAPIVersion.VERSION2, client_id=self._name(), protocol=protocol)
        client.connect_timeout = _CONNECT_SECONDS
        client.reconnect_delay_set(*_AWAY)
        client.max_inflight_messages_set(1)  # ONLINE and OFFLINE stay in their order
        client.max_queued_messages_set(4)
        if broker.user is not None:
            client.username_pw_set(broker.user, broker.password)
        if self._context is not None:
            client.tls_set_context(self._context)
        client.on_pre_connect = self._guarded(self._on_pre_connect)
        client.on_connect_fail = self._guarded(self._on_connect_fail)
        client.on_socket_open = self._guarded(self._on_socket_open)
        client.on_connect = self._guarded(self._on_connect)
        client.on_disconnect = self._guarded(self._on_disconnect)
        client.on_message = self._guarded(self._on_message)
        client.on_publish = self._guarded(self._on_publish)
        given: dict[str, Any] = {}
        if protocol == module.MQTTv5:
            given = {"clean_start": True, "properties": _longest(_MOST_PACKET)}
        client.connect_async(broker.host, broker.port, _KEEP_ALIVE, **given)
        self._client = client
        client.loop_start()

    def _name(self) -> str:
        """The client id: at most 23 letters and digits, which every broker accepts."""
        return "woosh" + hashlib.sha256(self.prefix.encode()).hexdigest()[:16]

    # -- in paho's thread ------------------------------------------------------------------------------------

    def _guarded(self, callback: Callable[..., None]) -> Callable[..., None]:
        """A callback whose failure, which is ours, does not end paho's thread."""

        def call(*given: Any) -> None:
            try:
                callback(*given)
            except Exception:
                _log.exception("! %s: a failure of our own; the connection goes on", self.prefix)

        return call

    def _on_pre_connect(self, client: Any, data: Any) -> None:
        self._reached, self._refused, self._since = False, "", math.inf
        will = json.dumps(self._connection("CONNECTIONBROKEN"))
        client.will_set(f"{self.prefix}/connection", will, qos=1, retain=True)
        if self._context is not None:
            try:
                load_certificates(self._context, self.broker)  # they may have been renewed
            except (OSError, ValueError) as error:
                self._tell(f"the certificates cannot be read again, and those of before are used: {error}")

    def _on_connect_fail(self, client: Any, data: Any) -> None:
        error = sys.exc_info()[1]  # paho calls this where it has caught it
        client.reconnect_delay_set(*_AWAY)
        why = f": {error}" if error is not None and str(error) else ""
        self._tell(f"the broker {self.broker.url} cannot be reached{why}; it is tried again and again")

    def _on_socket_open(self, client: Any, data: Any, sock: Any) -> None:
        self._reached = True
        # A state that follows another one at once would wait 40 ms for the broker's acknowledgement.
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        if os.name == "posix" and sock.fileno() >= _MOST_FILES:
            self._tell(
                f"this process has more than {_MOST_FILES} files open, and paho-mqtt takes no further "
                "connection then: give each process fewer vehicles (25 whole chassis)"
            )

    def _on_connect(self, client: Any, data: Any, flags: Any, reason: Any, properties: Any) -> None:
        if reason.is_failure:
            self._refused = str(reason)
            return
        self._told = ""
        _log.info("= %s: connected with %s", self.prefix, self.broker.url)
        self._since = time.monotonic()
        with self._lock:
            self._waiting.clear()
            self._waiting_bytes, self._behind = 0, False
        topics = [f"{self.prefix}/order", f"{self.prefix}/instantActions"]
        client.subscribe([(topic, _options(client, self._module)) for topic in topics])
        self.connected.set()
        self.send("connection", self._connection("ONLINE"), retain=True, quality=1)
        self._changed(True)

    def _on_disconnect(self, client: Any, data: Any, flags: Any, reason: Any, properties: Any) -> None:
        stands, stood = self.connected.is_set(), time.monotonic() - self._since
        self.connected.clear()
        if self._closing or client is not self._client:
            return
        url = self.broker.url
        if stands and stood >= _STOOD:
            self._tell(f"the connection with the broker {url} is lost: {reason}")
            self._sent_away.reset()
            client.reconnect_delay_set(*_AWAY)
        else:
            wait = self._sent_away.next()
            client.reconnect_delay_set(wait, wait)
            if self._refused == "Unsupported protocol version":
                self._tell(f"the broker {url} does not speak MQTT 5: 3.1.1 is used")
                threading.Thread(target=self._speak_older, args=(client,), daemon=True).start()
            elif self._refused:
                self._tell(f"the broker {url} refused us: {self._refused}")
            elif stands:
                self._tell(
                    f"the broker {url} ended the connection as soon as it stood: {reason}; does another "
                    f"process say that it is {self.prefix}?"
                )
            else:
                self._tell(f"the broker {url} took the connection and did not answer: {reason}")
        if stands:
            self._changed(False)

    def _speak_older(self, client: Any) -> None:
        """Another client, for a broker of before MQTT 5; in a thread of its own, because paho's is joined."""
        client.disconnect()
        client.loop_stop()
        if not self._closing:
            self._start(self._module.MQTTv311)

    def _on_publish(self, client: Any, data: Any, mid: int, reason: Any, properties: Any) -> None:
        if not self._behind:
            return
        with self._lock:
            self._has_room(0)
            again = len(self._waiting) <= MOST_WAITING // 2
            self._behind = not again
        if again:
            self._told = ""
            _log.info("= %s: the broker %s reads again", self.prefix, self.broker.url)
            self._changed(True)

    def _on_message(self, client: Any, data: Any, message: Any) -> None:
        topic = message.topic.rpartition("/")[2]
        if not message.payload:
            return  # somebody has cleared a retained message
        if message.retain:
            self.retained += 1
            _log.warning("! %s: a retained message on %s is not obeyed; clear it", self.prefix, topic)
            return
        self._received(topic, message.payload)

    def _tell(self, text: str) -> None:
        if text != self._told:
            self._told = text
            _log.warning("! %s: %s", self.prefix, text)


def _is_over(info: Any) -> bool:
    """Whether a message was written, or never will be."""
    try:
        return bool(info.is_published())
    except (RuntimeError, ValueError):
        return True


def _longest(size: int) -> Any:
    """The properties of a CONNECT that says how long a packet may be."""
    from paho.mqtt.packettypes import PacketTypes
    from paho.mqtt.properties import Properties

    make: Any = Properties  # it has no annotations
    found = make(PacketTypes.CONNECT)
    found.MaximumPacketSize = size
    return found


def _options(client: Any, module: Any) -> Any:
    """Quality of service 0; with MQTT 5, no retained messages."""
    if client.protocol != module.MQTTv5:
        return 0
    from paho.mqtt.subscribeoptions import SubscribeOptions

    return SubscribeOptions(qos=0, retainHandling=SubscribeOptions.RETAIN_DO_NOT_SEND)
