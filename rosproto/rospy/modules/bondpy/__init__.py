"""bondpy: two processes that notice when the other one ends."""

from . import bondpy
