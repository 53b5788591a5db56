"""rostest as test files import it: runs their unittest cases against the master that is there.

A .test or .launch file that starts nodes first needs roslaunch: start the nodes, then the test file.
"""

import sys

import rosgraph
import rosunit

__all__ = ["get_master", "is_publisher", "is_subscriber", "rosrun", "run", "unitrun"]


def get_master():
    """The master, by its API."""
    from rospy.core import xmlrpcapi

    return xmlrpcapi(rosgraph.get_master_uri())


def _state(table):
    code, text, state = get_master().getSystemState("/script")
    if code != 1:
        raise OSError("Unable to retrieve master state: %s" % text)
    return dict(state[table])


def is_subscriber(topic, subscriber_id):
    """True when the master knows this node as a subscriber of the topic."""
    return subscriber_id in _state(1).get(topic, ())


def is_publisher(topic, publisher_id):
    """True when the master knows this node as a publisher of the topic."""
    return publisher_id in _state(0).get(topic, ())


def rosrun(package, test_name, test, sysargs=None):
    """Run a TestCase class, or the tests of a name; ends the node, and the process with 1 when one fails."""
    import rospy

    result = rosunit.run(package, test_name, test, sys.argv if sysargs is None else sysargs)
    rospy.signal_shutdown("test complete")
    if not result.wasSuccessful():
        sys.exit(1)


run = rosrun


def unitrun(package, test_name, test, sysargs=None, coverage_packages=None):
    """The old name of `rosunit.unitrun`."""
    import warnings

    warnings.warn("Call to deprecated function unitrun.", category=DeprecationWarning, stacklevel=2)
    rosunit.unitrun(package, test_name, test, sysargs, coverage_packages)
