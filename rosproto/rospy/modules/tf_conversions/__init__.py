"""tf_conversions: `posemath`, and tf's `transformations`."""

from importlib import import_module

__all__ = ["posemath", "transformations"]


def __getattr__(name):
    # Imported on first use: they need numpy and PyKDL.
    if name == "transformations":
        return import_module("tf.transformations")
    if name in ("posemath", "fromMsg", "toMsg", "fromTf", "toTf", "fromMatrix", "toMatrix"):
        module = import_module("tf_conversions.posemath")
        return module if name == "posemath" else getattr(module, name)
    raise AttributeError("module %r has no attribute %r" % (__name__, name))
