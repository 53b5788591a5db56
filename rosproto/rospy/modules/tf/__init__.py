"""tf: the listener and broadcaster that precede tf2, and transformations."""

from tf2_ros import ConnectivityException, ExtrapolationException, LookupException
from tf2_ros import TransformException as Exception

from .broadcaster import TransformBroadcaster
from .listener import Transformer, TransformerROS, TransformListener


def __getattr__(name):
    # Imported on first use: it needs numpy, which takes as long to import (0.2 s) as everything else.
    if name == "transformations":
        from importlib import import_module

        return import_module("tf.transformations")
    raise AttributeError("module %r has no attribute %r" % (__name__, name))
