"""The fixtures of the interop tests serve here too."""

from tests.interop.conftest import genpy_packages, ros_installed, shared_directory

__all__ = ["genpy_packages", "ros_installed", "shared_directory"]
