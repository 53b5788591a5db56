"""rospkg as far as programs use it: the folder of a package, by ROS_PACKAGE_PATH or around the program."""

from .common import MANIFEST_FILE, STACK_FILE, ResourceNotFound
from .environment import (
    get_log_dir,
    get_ros_home,
    get_ros_package_path,
    get_ros_paths,
    get_ros_root,
    get_test_results_dir,
)
from .rospack import RosPack
