"""rostest's functions for test files: runs unittest cases against the running master.

.test and .launch files are not supported, they need roslaunch: start the nodes, then the test file.
"""

import sys
import warnings

import rosgraph
import rospy
import rosunit


def get_master():
    """The master API as an `xmlrpc.client.ServerProxy`."""
    return rospy.core.xmlrpcapi(rosgraph.get_master_uri())


def _state(table):
    code, text, state = get_master().getSystemState("/script")
    if code != 1:
        raise OSError("Unable to retrieve master state: %s" % text)
    return dict(state[table])


def is_subscriber(topic, subscriber_id):
    """True if the node is registered as a subscriber of the topic."""
    return subscriber_id in _state(1).get(topic, ())


def is_publisher(topic, publisher_id):
    """True if the node is registered as a publisher of the topic."""
    return publisher_id in _state(0).get(topic, ())


def rosrun(package, test_name, test, sysargs=None):
    """Run a TestCase class, or tests by name; end the node, and on a failure the process with exit code 1."""
    result = rosunit.run(package, test_name, test, sys.argv if sysargs is None else sysargs)
    rospy.signal_shutdown("test complete")
    if not result.wasSuccessful():
        sys.exit(1)


run = rosrun


def unitrun(package, test_name, test, sysargs=None, coverage_packages=None):
    """Old name of `rosunit.unitrun`."""
    warnings.warn("Call to deprecated function unitrun.", category=DeprecationWarning, stacklevel=2)
    rosunit.unitrun(package, test_name, test, sysargs, coverage_packages)
