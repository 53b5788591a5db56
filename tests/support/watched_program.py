"""A program that publishes velocities, with a watchdog: `python -m tests.support.watched_program MASTER`.

It publishes 0.3 m/s ten times a second until it ends, and prints the process id of its watchdog in one line of JSON
once the watchdog is ready. Commands on stdin: "fork" starts a child that holds the pipes, and prints its process
id; "close" ends regularly; "standing" disarms and publishes zero.
"""

from __future__ import annotations

import json
import os
import sys
import threading
import time

from rosproto.codec import encode, message_class
from rosproto.node import Node
from rosproto.watchdog import LastMessage, Watchdog, WatchedNode

TWIST = message_class("geometry_msgs/Twist")


def main() -> None:
    asked: list[str] = []

    def read() -> None:
        asked.extend(line.strip() for line in sys.stdin)

    threading.Thread(target=read, daemon=True).start()
    with Node("/program", master_uri=sys.argv[1], rosout=False) as node, Watchdog() as watchdog:
        publisher = node.publisher("/cmd_vel", TWIST, queue_size=1, linger=False)
        publisher.wait_for_connection(10.0)
        zero = LastMessage("/cmd_vel", TWIST._type, TWIST._full_text, encode(TWIST()))
        watch = watchdog.watch(WatchedNode(sys.argv[1], node.name), messages=[zero])
        velocity = TWIST()
        velocity.linear.x = 0.3
        reported = 0
        while "close" not in asked:
            if "fork" in asked:
                asked.remove("fork")
                if (child := os.fork()) == 0:
                    time.sleep(30)
                    os._exit(0)
                print(json.dumps({"forked": child}), flush=True)
            if "standing" in asked:
                asked.remove("standing")
                velocity.linear.x = 0.0
                watch.disarm()
            publisher.publish(velocity)
            if watchdog.pid != reported and watch.ready:
                reported = watchdog.pid or 0
                print(json.dumps({"watchdog": reported}), flush=True)
            time.sleep(0.1)
        watch.drop()


if __name__ == "__main__":
    main()
