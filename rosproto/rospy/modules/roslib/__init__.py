"""roslib: `load_manifest` and what is left of it."""

from . import message, names, packages
from .launcher import load_manifest

__all__ = ["is_interactive", "load_manifest", "message", "names", "packages", "set_interactive"]

_is_interactive = False


def set_interactive(interactive):
    """In an interactive session rospy leaves the signals alone."""
    global _is_interactive
    _is_interactive = interactive


def is_interactive():
    """True in an interactive session."""
    return _is_interactive
