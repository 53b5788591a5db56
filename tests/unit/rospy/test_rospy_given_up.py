"""What a program gives up is given back; in a process."""

from __future__ import annotations

from pathlib import Path

from rosproto.master import Master
from tests.support.rospy_program import output


def test_unregistered_publishers_keep_no_memory(tmp_path: Path) -> None:
    """Latched messages of 40 publishers, 20 MB: gone with `unregister()`, without Python's collector."""
    code = """
        import gc
        import tracemalloc
        import weakref
        import rospy
        from std_msgs.msg import String

        rospy.init_node("busy")
        gc.disable()
        tracemalloc.start()
        refs = []
        for i in range(40):
            publisher = rospy.Publisher("/t%d" % i, String, latch=True, queue_size=1)
            publisher.publish("x" * 500000)
            refs.append(weakref.ref(publisher.impl))
            publisher.unregister()
        print(tracemalloc.get_traced_memory()[0] < 5e6)
        gc.collect()
        print(sum(ref() is not None for ref in refs))
    """
    with Master() as master:
        assert output(code, tmp_path, uri=master.uri).split() == ["True", "0"]


def test_a_listener_of_the_next_publisher_of_a_name_is_told(tmp_path: Path) -> None:
    """Unregistered and made again, the new publisher's listeners and headers count, the old one's no more."""
    code = """
        import time
        import rospy
        from std_msgs.msg import String

        class Listener(rospy.SubscribeListener):
            def __init__(self, name):
                self.name = name
            def peer_unsubscribe(self, topic, number):
                told.append((self.name, topic, number))

        def until(condition):
            end = time.time() + 10
            while not condition() and time.time() < end:
                time.sleep(0.01)

        told, got = [], []
        rospy.init_node("again")
        for name in ("first", "second"):
            publisher = rospy.Publisher(
                "/t", String, Listener(name), latch=True, headers={"who": name}, queue_size=1
            )
            publisher.publish("x")
            subscriber = rospy.Subscriber("/t", String, got.append)
            until(lambda: got)
            print(got.pop()._connection_header["who"])
            subscriber.unregister()
            until(lambda: told)
            print(told.pop())
            publisher.unregister()
        print(told, got)
    """
    with Master() as master:
        assert output(code, tmp_path, uri=master.uri).splitlines() == [
            "first",
            "('first', '/t', 0)",
            "second",
            "('second', '/t', 0)",
            "[] []",
        ]


def test_a_persistent_proxy_outlives_its_server(tmp_path: Path) -> None:
    """Its link is made again with the next call, once the service is provided again; until then it says so."""
    code = """
        import os
        import rospy
        import rosproto
        from std_srvs.srv import Trigger

        def server(text):
            node = rosproto.Node("/server", master_uri=os.environ["ROS_MASTER_URI"], rosout=False)
            node.service_server("/told", "std_srvs/Trigger", lambda request: (True, text))
            return node

        rospy.init_node("client", disable_rosout=True)
        proxy = rospy.ServiceProxy("/told", Trigger, persistent=True)
        for text in ("one", "two"):
            with server(text):
                print(proxy().message, proxy().message)
            try:
                proxy()
            except rospy.ServiceException as error:
                print(error)
    """
    with Master() as master:
        assert output(code, tmp_path, uri=master.uri).splitlines() == [
            "one one",
            "service [/told] unavailable",
            "two two",
            "service [/told] unavailable",
        ]
