"""rospy's links take longer than a constructor, and programs use in a callback what the constructor assigns."""

from __future__ import annotations

from pathlib import Path

from rosproto.action import ActionServer
from rosproto.master import Master
from rosproto.node import Node
from tests.support.rospy_program import output


def test_no_callback_comes_in_the_first_20_ms(tmp_path: Path) -> None:
    """The topic is latched: the first message is there as soon as the link is."""
    code = """
        import threading
        import time
        import rospy
        from std_msgs.msg import String

        class Listener:
            def __init__(self, topic):
                self.done = threading.Event()
                self.began = time.monotonic()
                self.sub = rospy.Subscriber(topic, String, self.hear)

            def hear(self, message):
                self.heard = time.monotonic() - self.began >= 0.02
                self.done.set()

        rospy.init_node("hears")
        heard = []
        for i in range(10):
            listener = Listener("/kept%d" % i)
            heard.append(listener.done.wait(20) and listener.heard)
        print(all(heard), len(heard))
    """
    with Master() as master, Node("/says", master_uri=master.uri, rosout=False) as says:
        for number in range(10):
            says.publisher(f"/kept{number}", "std_msgs/String", latch=True).publish(data="x")
        assert output(code, tmp_path, uri=master.uri).split() == ["True", "10"]


def test_a_listener_can_publish_when_it_is_told(tmp_path: Path) -> None:
    """A subscriber was there before the publisher: its connection comes with the registration."""
    code = """
        import threading
        import time
        import rospy
        from std_msgs.msg import String

        class Greeter(rospy.SubscribeListener):
            def __init__(self, topic):
                self.done = threading.Event()
                self.began = time.monotonic()
                self.pub = rospy.Publisher(topic, String, subscriber_listener=self, queue_size=1)

            def peer_subscribe(self, topic_name, topic_publish, peer_publish):
                peer_publish(String("welcome"))
                self.told = time.monotonic() - self.began >= 0.02
                self.done.set()

        rospy.init_node("greets")
        greeters = [Greeter("/early%d" % i) for i in range(10)]
        print(all(greeter.done.wait(20) and greeter.told for greeter in greeters))
        time.sleep(1.0)  # what a busy subscriber has not read is lost with the link when the program ends
    """
    with Master() as master, Node("/hears", master_uri=master.uri, rosout=False) as hears:
        subscribers = [hears.subscriber(f"/early{number}", "std_msgs/String") for number in range(10)]
        assert output(code, tmp_path, uri=master.uri).split() == ["True"]
        assert [subscriber.next(20).data for subscriber in subscribers] == ["welcome"] * 10


def test_the_first_goal_waits_for_no_generated_code(tmp_path: Path) -> None:
    """It took 2 to 3 ms, and under load active_cb came before the statement after `send_goal`."""
    code = """
        import threading
        import actionlib
        import rospy
        from rosproto.codec.generated_source import Source
        from woosh_msgs.msg import StepControlAction, StepControlGoal

        generated, original, main = [], Source.compile, threading.get_ident()

        def compile_(source, name, type_name):
            if threading.get_ident() == main:
                generated.append((name, type_name))
            return original(source, name, type_name)

        Source.compile = compile_
        rospy.init_node("sends")
        client = actionlib.SimpleActionClient("/step", StepControlAction)
        goal = StepControlGoal()
        print(client.wait_for_server(rospy.Duration(20)), len(generated) > 0)
        generated.clear()
        client.send_goal(goal, active_cb=lambda: None)
        print(generated)
        client.wait_for_result(rospy.Duration(20))
    """
    with (
        Master() as master,
        Node("/serves", master_uri=master.uri, rosout=False) as serves,
        ActionServer(serves, "/step", "woosh_msgs/StepControl", lambda goal: None),
    ):
        assert output(code, tmp_path, uri=master.uri).splitlines() == ["True True", "[]"]
