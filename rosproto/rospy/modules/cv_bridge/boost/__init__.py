"""cv_bridge.boost: the functions of the C++ module."""
