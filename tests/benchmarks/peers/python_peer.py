"""One role of a benchmark in a process of its own: `python_peer.py LIBRARY ROLE JSON`.

LIBRARY is "ours", "rospy" or "bare" (sockets alone, bare_sockets.py); all do the same in the words of their library.
Results are one JSON line on stdout, "ready" before them when the other side may begin. Clock: time.monotonic(), which
all processes of one Linux computer share.
"""

from __future__ import annotations

import json
import os
import resource
import sys
import threading
import time

STARTED = time.monotonic()
LIBRARY, ROLE, OPTIONS = sys.argv[1], sys.argv[2], json.loads(sys.argv[3])
TYPE = OPTIONS.get("type", "geometry_msgs/Twist")


class Ours:
    """Our library."""

    def __init__(self, name):
        import rosproto
        import rosproto.node  # `rosproto` itself loads its parts on first use

        self.lib = rosproto
        self.imported = time.monotonic()
        self.node = rosproto.Node("/" + name, master_uri=os.environ["ROS_MASTER_URI"], intraprocess=False)
        self.cls = rosproto.message_class(TYPE)

    def publisher(self, topic, queue_size):
        pub = self.node.publisher(topic, self.cls, queue_size=queue_size or 1000)
        self.wait = lambda: pub.wait_for_connection(30.0, OPTIONS.get("subscribers", 1))
        return pub.publish

    def subscribe(self, topic, callback, queue_size):
        return self.node.subscriber(
            topic, self.cls, callback, queue_size=queue_size or 1000, tcp_nodelay=bool(OPTIONS.get("nodelay"))
        )


class Rospy:
    """rospy."""

    def __init__(self, name):
        import rospy

        self.lib = rospy
        self.imported = time.monotonic()
        rospy.init_node(name, disable_signals=True)
        import importlib

        package, _, base = TYPE.partition("/")
        self.cls = getattr(importlib.import_module(package + ".msg"), base)

    def publisher(self, topic, queue_size):
        pub = self.lib.Publisher(topic, self.cls, queue_size=queue_size)

        def wait():
            end = time.monotonic() + 30
            while pub.get_num_connections() < OPTIONS.get("subscribers", 1) and time.monotonic() < end:
                time.sleep(0.01)

        self.wait = wait
        return pub.publish

    def subscribe(self, topic, callback, queue_size):
        return self.lib.Subscriber(
            topic, self.cls, callback, queue_size=queue_size, tcp_nodelay=bool(OPTIONS.get("nodelay"))
        )


def say(**values):
    print(json.dumps(values), flush=True)


def cpu():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def waits():
    """How often this process has waited and was woken."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_nvcsw


def make_message(cls):
    """A message of `size` bytes of payload (bytes, as both libraries take them), or a Twist."""
    message = cls()
    size = OPTIONS.get("size", 0)
    if size:
        if OPTIONS.get("array") and LIBRARY == "ours":
            import numpy

            message.data = numpy.zeros(size, "u1")
        else:
            message.data = bytes(size)
        message.width = size
    return message


def peer():
    if LIBRARY == "bare":
        from bare_sockets import Bare

        return Bare(os.environ["BENCH_FOLDER"])
    return (Ours if LIBRARY == "ours" else Rospy)(f"{ROLE}_{os.getpid()}")


def publish_fast():
    """As fast as possible for `seconds`, after the subscriber is there."""
    lib = peer()
    publish = lib.publisher("/bench", OPTIONS.get("queue_size"))
    message = make_message(lib.cls)
    lib.wait()
    time.sleep(0.3)
    began, busy, count = time.monotonic(), cpu(), 0
    end = began + OPTIONS["seconds"]
    while time.monotonic() < end:
        for _ in range(OPTIONS.get("chunk", 100)):
            publish(message)
        count += OPTIONS.get("chunk", 100)
    took = time.monotonic() - began
    say(sent=count, seconds=took, cpu=cpu() - busy)
    time.sleep(0.7)


def count_messages():
    """Count what arrives; ends when nothing has for half a second after the first."""
    lib = peer()
    state = {"count": 0}

    def callback(message):
        state["count"] += 1

    lib.subscribe("/bench", callback, OPTIONS.get("sub_queue_size"))
    if OPTIONS.get("compute"):
        threading.Thread(target=compute, daemon=True).start()
    say(ready=True)
    report_count(lambda: state["count"])


def report_count(count):
    """Say how many came, in which time; when nothing has for half a second after the first."""
    while not count():
        time.sleep(0.001)
    began, start_count, busy, waited = time.monotonic(), count(), cpu(), waits()
    last_count, last = start_count, began
    while True:
        time.sleep(0.02)
        now = time.monotonic()
        if count() != last_count:
            last_count, last, last_cpu, last_waits = count(), now, cpu(), waits()
        elif now - last > 0.5:
            break
    took = last - began
    say(received=last_count - start_count, seconds=took, cpu=last_cpu - busy, waits=last_waits - waited)


def sink():
    """As `count`, but nothing is cut or decoded, and few reads: what a publisher can do when its subscriber costs
    nothing."""
    from rosproto.node.incoming.tcpros_link import FrameReader

    size = OPTIONS.get("frame", 52)
    taken = [0]

    def drain(reader, *how):
        buffer = bytearray(1 << 20)
        while count := reader._sock.recv_into(buffer):
            taken[0] += count
            time.sleep(200e-6)
        raise reader._ended(0)

    FrameReader.receive = drain
    lib = peer()
    lib.subscribe("/bench", lambda message: None, 1000)
    say(ready=True)
    report_count(lambda: taken[0] // size)


def compute():
    """A user's thread that never rests."""
    x = 0
    while True:
        for i in range(10000):
            x = (x * 31 + i) & 0xFFFF


def ping():
    """Round trips: publish /ping, wait for /pong."""
    lib = peer()
    came = threading.Event()
    times = []

    def callback(message):
        times.append(time.perf_counter() - callback.sent)
        came.set()

    lib.subscribe("/pong", callback, OPTIONS.get("sub_queue_size"))
    publish = lib.publisher("/ping", OPTIONS.get("queue_size"))
    message = lib.cls()
    lib.wait()
    time.sleep(1.0)
    for _ in range(OPTIONS["count"] + 200):
        came.clear()
        callback.sent = time.perf_counter()
        publish(message)
        if not came.wait(2.0):
            break
    say(times=[round(t * 1e6, 1) for t in times[200:]])


def pong():
    """Answer each /ping from the callback."""
    lib = peer()
    publish = lib.publisher("/pong", OPTIONS.get("queue_size"))
    lib.subscribe("/ping", publish, OPTIONS.get("sub_queue_size"))
    say(ready=True)
    threading.Event().wait(OPTIONS.get("life", 60))


def publish_steady():
    """At `hz`, each message with its time of sending in linear.x (Twist), or just paced (images)."""
    lib = peer()
    publish = lib.publisher("/bench", OPTIONS.get("queue_size"))
    message = make_message(lib.cls)
    lib.wait()
    time.sleep(0.5)
    period, due = 1.0 / OPTIONS["hz"], time.monotonic()
    for _ in range(OPTIONS["count"]):
        due += period
        wait = due - time.monotonic()
        if wait > 0:
            time.sleep(wait)
        if not OPTIONS.get("size"):
            message.linear.x = time.monotonic()
        publish(message)
    say(sent=OPTIONS["count"])
    time.sleep(0.7)


def one_way():
    """Time from publish() to the callback."""
    lib = peer()
    times = []

    def callback(message):
        times.append(time.monotonic() - message.linear.x)

    lib.subscribe("/bench", callback, OPTIONS.get("sub_queue_size"))
    if OPTIONS.get("compute"):
        threading.Thread(target=compute, daemon=True).start()
    say(ready=True)
    end = time.monotonic() + 60
    last = 0
    while time.monotonic() < end:
        time.sleep(0.6)
        if times and len(times) == last:
            break
        last = len(times)
    say(times=[round(t * 1e6, 1) for t in times[len(times) // 10 :]])


def first_message():
    """Process start to first message; import time; memory."""
    began = OPTIONS["started"]
    lib = peer()
    came = threading.Event()
    lib.subscribe("/bench", lambda message: came.set(), 10)
    came.wait(20)
    now = time.monotonic()
    say(first=now - began, imported=lib.imported - STARTED, rss=rss(), began=STARTED - began)


def rss():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * 4096


def provide():
    """A service that answers std_srvs/SetBool."""
    if LIBRARY == "ours":
        import rosproto

        node = rosproto.Node(f"/p{os.getpid()}", master_uri=os.environ["ROS_MASTER_URI"])
        node.service_server("/set", "std_srvs/SetBool", lambda request: {"success": True, "message": ""})
    else:
        import rospy
        from std_srvs.srv import SetBool, SetBoolResponse

        rospy.init_node("provider", disable_signals=True)
        rospy.Service("/set", SetBool, lambda request: SetBoolResponse(True, ""))
    say(ready=True)
    time.sleep(OPTIONS.get("life", 30))


def call():
    """Calls one after the other."""
    persistent = OPTIONS["persistent"]
    if LIBRARY == "ours":
        import rosproto

        node = rosproto.Node(f"/c{os.getpid()}", master_uri=os.environ["ROS_MASTER_URI"])
        client = node.service_client("/set", "std_srvs/SetBool", persistent=persistent)
        request = rosproto.service_class("std_srvs/SetBool").Request(data=True)
        do = client.call
    else:
        import rospy
        from std_srvs.srv import SetBool, SetBoolRequest

        rospy.init_node("caller", disable_signals=True)
        rospy.wait_for_service("/set", 20)
        do = rospy.ServiceProxy("/set", SetBool, persistent=persistent)
        request = SetBoolRequest(True)
    times = []
    for _ in range(OPTIONS["count"] + 50):
        began = time.perf_counter()
        do(request)
        times.append(time.perf_counter() - began)
    say(times=[round(t * 1e6, 1) for t in times[50:]])


def fan_out():
    """`subscribers` subscribers of one topic, or `topics` topics, held by this process."""
    lib = peer()
    counts = [0]

    def callback(message):
        counts[0] += 1

    before, threads = rss(), threading.active_count()
    held = [lib.subscribe(f"/bench{i}", callback, 100) for i in range(OPTIONS["topics"])]
    say(ready=True)
    time.sleep(OPTIONS.get("life", 20))
    say(received=counts[0], rss=rss() - before, threads=threading.active_count() - threads, held=len(held))


def many_publish():
    """`topics` topics, each at `hz`, with the time of sending in linear.x; after all are connected."""
    lib = peer()
    before = threading.active_count()
    if LIBRARY == "ours":
        pubs = [lib.node.publisher(f"/many{i}", lib.cls, queue_size=10) for i in range(OPTIONS["topics"])]
        connected = lambda: sum(p.connections > 0 for p in pubs)  # noqa: E731
    else:
        pubs = [lib.lib.Publisher(f"/many{i}", lib.cls, queue_size=10) for i in range(OPTIONS["topics"])]
        connected = lambda: sum(p.get_num_connections() > 0 for p in pubs)  # noqa: E731
    began = time.monotonic()
    while connected() < len(pubs) and time.monotonic() < began + 20:
        time.sleep(0.01)
    took, there = time.monotonic() - began, connected()
    time.sleep(0.5)
    message, sent, busy = lib.cls(), 0, cpu()
    due = time.monotonic()
    end = due + OPTIONS["seconds"]
    while due < end:
        for pub in pubs:
            due += 1 / OPTIONS["hz"] / len(pubs)
            wait = due - time.monotonic()
            if wait > 0.001:
                time.sleep(wait)
            message.linear.x = time.monotonic()
            pub.publish(message)
            sent += 1
    say(
        sent=sent,
        connected=there,
        connect_seconds=took,
        cpu=cpu() - busy,
        threads=threading.active_count() - before,
    )
    time.sleep(1.0)


def many_subscribe():
    """The other side: counts, latencies, memory and threads; ends when nothing has come for two seconds."""
    lib = peer()
    times = []

    def callback(message):
        times.append(time.monotonic() - message.linear.x)

    memory, threads = rss(), threading.active_count()
    held = [lib.subscribe(f"/many{i}", callback, 100) for i in range(OPTIONS["topics"])]
    say(ready=len(held))
    busy = cpu()
    end = time.monotonic() + OPTIONS["life"] + 30
    last = -1
    result = {}
    while time.monotonic() < end and not (times and len(times) == last):
        last = len(times)
        if times:
            result = {
                "rss": rss() - memory,
                "threads": threading.active_count() - threads,
                "cpu": cpu() - busy,
            }
        time.sleep(0.5)
    say(received=len(times), times=[round(t, 7) for t in times], **result)


def quick_exit():
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    ROLES = {
        "publish_fast": publish_fast,
        "count": count_messages,
        "sink": sink,
        "ping": ping,
        "pong": pong,
        "publish_steady": publish_steady,
        "one_way": one_way,
        "first_message": first_message,
        "provide": provide,
        "call": call,
        "fan_out": fan_out,
        "many_publish": many_publish,
        "many_subscribe": many_subscribe,
    }
    ROLES[ROLE]()
    quick_exit()
