"""roslib: `load_manifest` and the other names still in use."""

from . import message, names, packages
from .launcher import load_manifest

_is_interactive = False


def set_interactive(interactive):
    """Set whether the session is interactive; if so, rospy handles no signals."""
    global _is_interactive
    _is_interactive = interactive


def is_interactive():
    """True in an interactive session."""
    return _is_interactive
