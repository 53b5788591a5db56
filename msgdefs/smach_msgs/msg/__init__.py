"""Messages of smach_msgs as classes, made on first use."""

from msgdefs._lazy import lazy_module

__getattr__, __dir__ = lazy_module(__name__)
