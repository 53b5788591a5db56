"""`BrokerConnection`: a vehicle's MQTT connection by paho-mqtt, with connection messages and last will (6.2,
6.14).

Each vehicle has one paho client with one thread, which connects, reads, writes, pings and reconnects. The
last will is CONNECTIONBROKEN; ONLINE is sent after connecting, OFFLINE before a clean end: all three
retained, with quality of service 1. Everything else is sent with quality of service 0, and dropped while the
broker is not connected; a new state is sent after reconnecting.

The client id is derived from the vehicle's topics and never changes. So a broker that still holds a broken
connection closes it when the next one arrives, and publishes its CONNECTIONBROKEN before the new ONLINE.

An unreachable broker is tried every 1 to 2 s. If a broker ends the connection (wrong password, another client
with the same id, no answer), the waits grow and are partly random, so that many vehicles do not reconnect in
step. For a broker that does not read, a limited number of messages waits; others are dropped and counted, and
a new state is sent when it reads again.

With MQTT 5 the broker is given the largest message size, and asked not to send retained messages: an old
order must not move the robot after each connect. If the broker only supports MQTT 3.1.1, that is used; its
size limit is not known, and retained messages are ignored on arrival.

paho waits with select(), which cannot handle file descriptors above 1023: a process with more open files
cannot use this connection, and a warning is logged.
"""

from __future__ import annotations

import hashlib
import math
import os
import socket
import ssl
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from types import ModuleType
from typing import TYPE_CHECKING, Any

from rosproto.extras import optional_module
from rosproto.logs import get_logger
from rosproto.sentence import say
from rosproto.transport import Backoff
from woosh_pure.fleet.config import Broker
from woosh_pure.fleet.messages.parsing import MAX_MESSAGE_BYTES, compact_json

if TYPE_CHECKING:
    import paho.mqtt.client as mqtt
    from paho.mqtt.properties import Properties
    from paho.mqtt.reasoncodes import ReasonCode
    from paho.mqtt.subscribeoptions import SubscribeOptions

_log = get_logger("woosh_pure.fleet.broker_connection")
MAX_WAITING = 200
"""Messages of one vehicle that may wait for a broker that does not read."""
MAX_WAITING_BYTES = 1_000_000
_KEEP_ALIVE = 15  # s, by 6.14
_CONNECT_SECONDS = 2.0
_UNREACHABLE_WAITS = (1, 2)  # first and longest wait for an unreachable broker, s
_REJECTED_WAITS = (1.0, 2.0, 30.0, 0.5)  # arguments of `Backoff`, for a broker that ends the connection
_STABLE_SECONDS = 2.0  # of a connection, after which the waits start again with the shortest
_MAX_PACKET_BYTES = MAX_MESSAGE_BYTES + 65_600  # a message and its topic
_MAX_FILES = 1024  # of select() on POSIX
_END_SECONDS = 1.0  # for the end of paho's thread


def paho() -> ModuleType:
    """paho.mqtt.client.

    Raises:
        ImportError: It is not installed; the text names the extra.
    """
    missing = ImportError('VDA 5050 needs paho-mqtt 2: pip install ".[fleet]"', name="paho")
    return optional_module("paho.mqtt.client", missing)


class BrokerConnection:
    """One vehicle's connection with the broker.

    Args:
        broker: The broker.
        prefix: First levels of the topics, "uagv/v2/Woosh/A-17".
        connection: Makes a connection message for a state: `connection("ONLINE")`.
        received: Called with topic and payload in paho's thread; must not block.
        changed: Called with True or False after connecting or disconnecting, and with True when the broker
            reads again after messages were dropped. Called in paho's thread; must not block.

    Raises:
        ImportError: paho-mqtt is not installed; the text names the extra.
        ValueError: A file is not a certificate, or the key does not match.
        OSError: A certificate cannot be read.
    """

    def __init__(
        self,
        broker: Broker,
        prefix: str,
        connection: Callable[[str], dict[str, object]],
        received: Callable[[str, bytes], object],
        changed: Callable[[bool], object],
    ) -> None:
        self._module = paho()
        self._context: ssl.SSLContext | None = tls_context(broker) if broker.tls else None
        self.broker, self.prefix = broker, prefix
        self._connection, self._received, self._changed = connection, received, changed
        self._last_warning = ""  # each warning is logged once
        self.dropped = 0
        self.connected = threading.Event()
        self._closing = False
        self._client: mqtt.Client | None = None
        self._lock = threading.RLock()
        # Messages that paho has not written yet, and their sizes.
        self._waiting: deque[tuple[mqtt.MQTTMessageInfo, int]] = deque()
        self._waiting_bytes = 0
        self._behind = False
        self._refused = ""
        self._since = math.inf  # time of the last connect
        self._rejected_backoff = Backoff(*_REJECTED_WAITS)

    def __repr__(self) -> str:
        return f"<BrokerConnection {self.prefix} to {self.broker.url}>"

    def open(self) -> None:
        """Start connecting, and keep trying until `close`."""
        if self._client is None and not self._closing:
            self._start(self._module.MQTTv5)

    def send(
        self, topic: str, message: Mapping[str, object] | str, *, retain: bool = False, quality: int = 0
    ) -> bool:
        """Send a message, or its JSON text; False if it was dropped, because the broker is not connected or
        does not read."""
        client = self._client
        if client is None or not self.connected.is_set():
            return False
        text = message if isinstance(message, str) else compact_json(message)
        payload = text.encode()
        with self._lock:
            has_room = self._has_room(len(payload))
            first = not has_room and not self._behind
            self._behind = self._behind or not has_room
            if not has_room:
                self.dropped += 1
            else:
                info = client.publish(f"{self.prefix}/{topic}", payload, qos=quality, retain=retain)
                if quality == 0:
                    self._waiting.append((info, len(payload)))
                    self._waiting_bytes += len(payload)
                has_room = info.rc == self._module.MQTT_ERR_SUCCESS
        if first:
            self._warn("the broker {broker} does not read: what is sent is dropped until it does")
        return bool(has_room)

    def _has_room(self, size: int) -> bool:
        """Whether one more message may wait; the first always may."""
        waiting = self._waiting
        while waiting and _is_done(waiting[0][0]):
            self._waiting_bytes -= waiting.popleft()[1]
        return not waiting or (len(waiting) < MAX_WAITING and self._waiting_bytes + size <= MAX_WAITING_BYTES)

    @property
    def waiting(self) -> int:
        """Number of messages that paho has not written yet."""
        with self._lock:
            self._has_room(0)
            return len(self._waiting)

    def revive(self) -> None:
        """Start paho's thread again if an exception has ended it."""
        if self._client is not None and not self._closing:
            self._client.loop_start()

    def close(self, timeout: float = 2.0) -> None:
        """Send OFFLINE, wait until the broker has received it, and disconnect. Takes bounded time."""
        if self._closing:
            return
        self._closing = True
        client = self._client
        if client is None:
            return
        if self.connected.is_set():
            text = compact_json(self._connection("OFFLINE"))
            try:
                client.publish(f"{self.prefix}/connection", text, qos=1, retain=True).wait_for_publish(
                    timeout
                )
            except (RuntimeError, ValueError) as error:
                _log.warning("! %s: OFFLINE was not sent: %s", self.prefix, error)
        client.disconnect()
        # loop_stop joins paho's thread without a time limit, and that may be connecting.
        ending = threading.Thread(target=client.loop_stop, name="woosh:mqtt-end", daemon=True)
        ending.start()
        ending.join(_END_SECONDS)
        self.connected.clear()

    # -- paho's client ---------------------------------------------------------------------------------------

    def _start(self, protocol: int) -> None:
        module, broker = self._module, self.broker
        client = module.Client(module.CallbackAPIVersion.VERSION2, client_id=self._name(), protocol=protocol)
        client.connect_timeout = _CONNECT_SECONDS
        client.reconnect_delay_set(*_UNREACHABLE_WAITS)
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
        if protocol == module.MQTTv5:
            properties = _connect_properties(_MAX_PACKET_BYTES)
            client.connect_async(
                broker.host, broker.port, _KEEP_ALIVE, clean_start=True, properties=properties
            )
        else:
            client.connect_async(broker.host, broker.port, _KEEP_ALIVE)
        self._client = client
        client.loop_start()

    def _name(self) -> str:
        """The client id: at most 23 letters and digits, as every broker accepts."""
        return "woosh" + hashlib.sha256(self.prefix.encode()).hexdigest()[:16]

    # -- in paho's thread ------------------------------------------------------------------------------------

    def _guarded(self, callback: Callable[..., None]) -> Callable[..., None]:
        """Wrap a callback, so that an exception does not end paho's thread."""

        def call(*given: object) -> None:
            try:
                callback(*given)
            except Exception:
                _log.exception("! %s: an internal error; the connection goes on", self.prefix)

        return call

    def _on_pre_connect(self, client: mqtt.Client, data: object) -> None:
        self._refused, self._since = "", math.inf
        will = compact_json(self._connection("CONNECTIONBROKEN"))
        client.will_set(f"{self.prefix}/connection", will, qos=1, retain=True)
        if self._context is not None:
            try:
                load_certificates(self._context, self.broker)  # they may have been renewed
            except (OSError, ValueError) as error:
                text = "the certificates cannot be read again, and those of before are used: {error}"
                self._warn(text, error=error)

    def _on_connect_fail(self, client: mqtt.Client, data: object) -> None:
        error = sys.exc_info()[1]  # paho calls this while it handles the exception
        client.reconnect_delay_set(*_UNREACHABLE_WAITS)
        text = "the broker {broker} cannot be reached: {error}; it is tried again and again"
        self._warn(text, error=str(error or "") or say("no answer"))

    def _on_socket_open(self, client: mqtt.Client, data: object, sock: socket.socket) -> None:
        # Else a state right after another one waits 40 ms for the broker's acknowledgement.
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        if os.name == "posix" and sock.fileno() >= _MAX_FILES:
            self._warn(
                "this process has more than {files} files open, and paho-mqtt takes no further "
                "connection then: give each process fewer vehicles (25 whole chassis)",
                files=_MAX_FILES,
            )

    def _on_connect(
        self, client: mqtt.Client, data: object, flags: object, reason: ReasonCode, properties: object
    ) -> None:
        if reason.is_failure:
            self._refused = str(reason)
            return
        self._last_warning = ""
        _log.info("= %s: connected with %s", self.prefix, self.broker.url)
        self._since = time.monotonic()
        with self._lock:
            self._waiting.clear()
            self._waiting_bytes, self._behind = 0, False
        topics = [f"{self.prefix}/order", f"{self.prefix}/instantActions"]
        client.subscribe(_subscriptions(client, self._module, topics))
        self.connected.set()
        self.send("connection", self._connection("ONLINE"), retain=True, quality=1)
        self._changed(True)

    def _on_disconnect(
        self, client: mqtt.Client, data: object, flags: object, reason: ReasonCode, properties: object
    ) -> None:
        was_connected, duration = self.connected.is_set(), time.monotonic() - self._since
        self.connected.clear()
        if self._closing or client is not self._client:
            return
        if was_connected and duration >= _STABLE_SECONDS:
            self._warn("the connection with the broker {broker} is lost: {reason}", reason=reason)
            self._rejected_backoff.reset()
            client.reconnect_delay_set(*_UNREACHABLE_WAITS)
        else:
            wait: Any = self._rejected_backoff.next()  # paho takes any number; its annotation is int
            client.reconnect_delay_set(wait, wait)
            if self._refused == "Unsupported protocol version":
                self._warn("the broker {broker} does not speak MQTT 5: 3.1.1 is used")
                threading.Thread(target=self._use_mqtt_3, args=(client,), daemon=True).start()
            elif self._refused:
                self._warn("the broker {broker} refused us: {reason}", reason=self._refused)
            elif was_connected:
                self._warn(
                    "the broker {broker} ended the connection as soon as it stood: {reason}; does another "
                    "process say that it is {vehicle}?",
                    reason=reason,
                    vehicle=self.prefix,
                )
            else:
                self._warn(
                    "the broker {broker} took the connection and did not answer: {reason}", reason=reason
                )
        if was_connected:
            self._changed(False)

    def _use_mqtt_3(self, client: mqtt.Client) -> None:
        """Change to MQTT 3.1.1 with a new client. Runs in a separate thread, because it joins paho's."""
        client.disconnect()
        client.loop_stop()
        if not self._closing:
            self._start(self._module.MQTTv311)

    def _on_publish(
        self, client: mqtt.Client, data: object, mid: int, reason: object, properties: object
    ) -> None:
        if not self._behind:
            return
        with self._lock:
            self._has_room(0)
            again = len(self._waiting) <= MAX_WAITING // 2
            self._behind = not again
        if again:
            self._last_warning = ""
            _log.info("= %s: the broker %s reads again", self.prefix, self.broker.url)
            self._changed(True)

    def _on_message(self, client: mqtt.Client, data: object, message: mqtt.MQTTMessage) -> None:
        topic = message.topic.rpartition("/")[2]
        if not message.payload:
            return  # a retained message was cleared
        if message.retain:
            _log.warning("! %s: a retained message on %s is not obeyed; clear it", self.prefix, topic)
            return
        self._received(topic, bytes(message.payload))

    def _warn(self, template: str, **values: object) -> None:
        text = say(template, broker=self.broker.url, **values)
        if text != self._last_warning:
            self._last_warning = text
            _log.warning("! %s: %s", self.prefix, text)


def _is_done(info: mqtt.MQTTMessageInfo) -> bool:
    """Whether a message was written, or cannot be written any more."""
    try:
        return bool(info.is_published())
    except (RuntimeError, ValueError):
        return True


def _connect_properties(size: int) -> Properties:
    """CONNECT properties with the largest packet size."""
    from paho.mqtt.packettypes import PacketTypes
    from paho.mqtt.properties import Properties

    make: Any = Properties  # it has no annotations
    found: Properties = make(PacketTypes.CONNECT)
    found.MaximumPacketSize = size
    return found


def _subscriptions(
    client: mqtt.Client, module: ModuleType, topics: list[str]
) -> list[tuple[str, SubscribeOptions]] | list[tuple[str, int]]:
    """The topics with quality of service 0; with MQTT 5, no retained messages."""
    if client.protocol != module.MQTTv5:
        return [(topic, 0) for topic in topics]
    from paho.mqtt.subscribeoptions import SubscribeOptions

    options = SubscribeOptions(qos=0, retainHandling=SubscribeOptions.RETAIN_DO_NOT_SEND)
    return [(topic, options) for topic in topics]


# -- certificates --------------------------------------------------------------------------------------------


def load_certificates(context: ssl.SSLContext, broker: Broker) -> None:
    """Load the certificate files.

    Raises:
        OSError: A file cannot be read.
        ValueError: A file is not a certificate, or the key does not match.
    """
    for name in (broker.ca_file, broker.cert_file, broker.key_file):
        if name:
            os.stat(name)  # its error names the file; that of the context does not
    try:
        if broker.ca_file is not None:
            context.load_verify_locations(broker.ca_file)
        if broker.cert_file is not None:
            context.load_cert_chain(broker.cert_file, broker.key_file)
    except ssl.SSLError as error:
        files = ", ".join(name for name in (broker.ca_file, broker.cert_file, broker.key_file) if name)
        raise ValueError(
            say("the certificates in {files} cannot be used: {error}", files=files, error=error)
        ) from error


def tls_context(broker: Broker) -> ssl.SSLContext:
    """A TLS context with the certificates of the broker, or of the system; raises as `load_certificates`."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    if broker.ca_file is None:
        context.load_default_certs()
    load_certificates(context, broker)
    return context
