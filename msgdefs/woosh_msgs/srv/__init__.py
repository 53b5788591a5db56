"""Services of woosh_msgs as classes, made on first use."""

from msgdefs._door import door

__getattr__, __dir__ = door(__name__)
