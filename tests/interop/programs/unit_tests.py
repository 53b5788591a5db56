# ruff: noqa: PT009
"""A test file as ROS packages have it: unittest cases with a node, run by rostest and rosunit."""

import os
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

import rospy
import rostest
import rosunit
from std_msgs.msg import String


class TestTalk(unittest.TestCase):
    """Cases with a graph."""

    def test_roundtrip(self):
        """A message comes back."""
        publisher = rospy.Publisher("/talk", String, latch=True, queue_size=1)
        publisher.publish("hello")
        self.assertEqual(rospy.wait_for_message("/talk", String, 10).data, "hello")
        print("inside")

    def test_registered(self):
        """What rostest says of the master."""
        subscriber = rospy.Subscriber("/other", String)
        self.assertTrue(rostest.is_subscriber("/other", rospy.get_name()))
        self.assertFalse(rostest.is_publisher("/other", rospy.get_name()))
        self.assertFalse(rostest.is_subscriber("/none", "/x"))
        subscriber.unregister()


class TestWrong(unittest.TestCase):
    """Cases that fail."""

    def test_a_failure(self):
        """Asserts."""
        sys.stderr.write("to stderr \x01 <&>\n")
        self.assertEqual(1, 2, "one & two")

    def test_b_error(self):
        """Raises."""
        raise KeyError("no such <thing>")

    def test_c_good(self):
        """Passes."""

    @unittest.skip("not now")
    def test_d_skipped(self):
        """Is skipped."""


results = os.environ["ROS_TEST_RESULTS_DIR"] = tempfile.mkdtemp()


def show(file):
    """What was written, without times and places."""
    suite = ElementTree.parse(os.path.join(results, *file.split("/"))).getroot()
    print(suite.tag, sorted((k, v) for k, v in suite.attrib.items() if k != "time"))
    for child in suite:
        print(
            " ", child.tag, sorted((k, v) for k, v in child.attrib.items() if k != "time"), repr(child.text)
        )
        for grandchild in child:
            print("   ", grandchild.tag, grandchild.attrib, repr(grandchild.text.split("\n")[0]))


print = lambda *args: sys.stdout.write(" ".join(map(str, args)).replace(results, "RESULTS") + "\n")  # noqa: E731
real = sys.stdout


class Masked:
    """Stdout without the place of the results."""

    def __getattr__(self, name):
        return getattr(real, name)

    def write(self, text):
        """Without the place, and without frames."""
        if not text.startswith('  File "'):
            real.write(text.replace(results, "RESULTS"))


sys.stdout = Masked()
rospy.init_node("test_talk")
try:
    rosunit.unitrun("my_package", "a name/wrong ones", TestWrong, sysargs=["x"])
except SystemExit as end:
    print("exit", end.code)
show("my_package/rosunit-wrong_ones.xml")
rosunit.unitrun("my_package", "by_name", "__main__.TestTalk.test_registered", sysargs=["x"])
show("my_package/rosunit-by_name.xml")
print(rosunit.xml_results_file("p", "a b", True))
rosunit.unitrun(
    "my_package", "given", TestTalk, sysargs=["x", "--gtest_output=xml:" + results + "/my file.xml"]
)
show("my file.xml")
rostest.rosrun("my_package", "talk", TestTalk)
print(rospy.is_shutdown(), rostest.run is rostest.rosrun)
show("my_package/rosunit-talk.xml")
sys.stdout = real
