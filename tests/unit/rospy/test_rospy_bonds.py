"""bondpy and topic_tools.LazyTransport, in a process of their own."""

from __future__ import annotations

from pathlib import Path

from rosproto.master import Master
from tests.support.rospy_program import output


def test_a_bond_is_formed_and_broken_from_the_other_end(tmp_path: Path) -> None:
    """Both ends are told once; a message of another bond is not taken for it."""
    code = """
        import rospy
        from bond.msg import Status
        from bondpy import bondpy
        rospy.init_node("n")
        told = []
        one = bondpy.Bond("/bond", "id", lambda: told.append("one broken"), lambda: told.append("one formed"))
        two = bondpy.Bond("/bond", "id", lambda: told.append("two broken"), lambda: told.append("two formed"))
        alone, short = bondpy.Bond("/bond", "other"), bondpy.Bond("/bond", "a third")
        for bond in (one, two, alone, short):
            bond.connect_timeout = bond.heartbeat_timeout = bond.disconnect_timeout = 50
            bond.heartbeat_period = 0.05
        short.connect_timeout = 0.3
        for bond in (one, two, alone, short):
            bond.start()
        print(one.wait_until_formed(50), two.wait_until_formed(rospy.Duration(50)))
        print(alone.wait_until_formed(0.05), short.wait_until_broken(50), short.is_broken())
        one.break_bond()
        print(one.wait_until_broken(50), two.wait_until_broken(50))
        while len(told) < 4 and not rospy.is_shutdown():  # the callbacks follow the state
            rospy.sleep(0.01)
        for bond in (one, two, alone, short):
            bond.shutdown()
        print(sorted(told))
    """
    with Master() as master:
        assert output(code, tmp_path, uri=master.uri).splitlines() == [
            "True True",
            "False True True",
            "True True",
            "['one broken', 'one formed', 'two broken', 'two formed']",
        ]


def test_a_bond_whose_other_end_falls_silent_is_broken(tmp_path: Path) -> None:
    """Also after its first message; with the parameter that disables it, it is not."""
    code = """
        import rospy
        from bond.msg import Constants, Status
        from bondpy import bondpy
        rospy.init_node("n")
        publisher = rospy.Publisher("/bond", Status, queue_size=1)
        bond = bondpy.Bond("/bond", "id")
        bond.connect_timeout, bond.heartbeat_timeout = 50, 0.2
        rospy.set_param(Constants.DISABLE_HEARTBEAT_TIMEOUT_PARAM, True)
        bond.start()
        while not publisher.get_num_connections():
            rospy.sleep(0.01)
        publisher.publish(Status(id="id", instance_id="other", active=True))
        print(bond.wait_until_formed(50), bond.wait_until_broken(0.6))
        rospy.set_param(Constants.DISABLE_HEARTBEAT_TIMEOUT_PARAM, False)
        print(bond.wait_until_broken(50))
        bond.shutdown()
    """
    with Master() as master:
        assert output(code, tmp_path, uri=master.uri).splitlines() == ["True False", "True"]


def test_a_lazy_transport_subscribes_while_it_is_subscribed(tmp_path: Path) -> None:
    """With ~lazy false from the beginning to the end."""
    code = """
        import rospy
        from std_msgs.msg import String
        from topic_tools import LazyTransport
        from topic_tools.srv import MuxAdd

        class Relay(LazyTransport):
            def __init__(self):
                super().__init__()
                self.told = []
                self.publisher = self.advertise("/out", String, queue_size=1)

            def subscribe(self):
                self.told.append("subscribe")

            def unsubscribe(self):
                self.told.append("unsubscribe")

        def wait(count):
            while len(relay.told) < count and not rospy.is_shutdown():
                rospy.sleep(0.01)
            return relay.told, relay.is_subscribed()

        rospy.init_node("n")
        relay = Relay()
        print(relay.told, relay.is_subscribed())
        ear = rospy.Subscriber("/out", String)
        print(*wait(1))
        ear.unregister()
        print(*wait(2))
        rospy.set_param("~lazy", False)
        print(Relay().is_subscribed())
    """
    with Master() as master:
        assert output(code, tmp_path, uri=master.uri).splitlines() == [
            "[] False",
            "['subscribe'] True",
            "['subscribe', 'unsubscribe'] False",
            "True",
        ]
