"""Topics by sockets alone: what is left of a round trip when the library takes no time.

The shape is a library's: a thread that reads and calls, `publish` in the caller's thread, a length before each
message, a Twist packed and unpacked. Nothing is looked for, counted, locked, queued or checked. Publishers listen
and write their port to a file of the folder; subscribers connect.
"""

from __future__ import annotations

import os
import socket
import struct
import threading
import time

FRAME = struct.Struct("<I6d")


class Vector:
    __slots__ = ("x", "y", "z")


class Twist:
    """A message as the other libraries have it: the fields' objects."""

    __slots__ = ("angular", "linear")

    def __init__(self):
        self.linear, self.angular = Vector(), Vector()
        for vector in (self.linear, self.angular):
            vector.x = vector.y = vector.z = 0.0


class Bare:
    """One process of two; TCP with TCP_NODELAY."""

    cls = Twist

    def __init__(self, folder):
        self.folder = folder
        self.imported = time.monotonic()

    def publisher(self, topic, queue_size):
        listener = socket.create_server(("127.0.0.1", 0))
        path = self.folder + topic.replace("/", "/bare_")
        with open(path + ".new", "w") as file:
            file.write(str(listener.getsockname()[1]))
        os.replace(path + ".new", path)
        there, links = threading.Event(), []

        def accept():
            sock, _ = listener.accept()
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            links.append(sock)
            there.set()

        threading.Thread(target=accept, daemon=True).start()
        self.wait = lambda: there.wait(30)
        pack = FRAME.pack

        def publish(message):
            linear, angular = message.linear, message.angular
            links[0].send(pack(48, linear.x, linear.y, linear.z, angular.x, angular.y, angular.z))

        return publish

    def subscribe(self, topic, callback, queue_size):
        def read():
            path = self.folder + topic.replace("/", "/bare_")
            while not os.path.exists(path):
                time.sleep(0.01)
            with open(path) as file:
                sock = socket.create_connection(("127.0.0.1", int(file.read())))
            buffer, unpack, recv_into = bytearray(4096), FRAME.unpack_from, sock.recv_into
            while count := recv_into(buffer):
                for start in range(0, count, FRAME.size):  # never a part: both sides are here
                    message = Twist.__new__(Twist)
                    linear = message.linear = Vector()
                    angular = message.angular = Vector()
                    _, linear.x, linear.y, linear.z, angular.x, angular.y, angular.z = unpack(buffer, start)
                    callback(message)

        threading.Thread(target=read, daemon=True).start()
